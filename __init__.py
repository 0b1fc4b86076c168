"""mukca: calibrate a robot arm with a printed ball and socket base.

What a notebook needs::

    robot = mukca.load_robot("panda")
    train = mukca.read_placements("recordings/front")
    test = mukca.read_placements("recordings/left", "recordings/right")
    calibration = mukca.calibrate(robot, train, test=test)
    print(calibration)
    calibration.save("calibrated")

The package has four rooms, and data flows one way through them::

    drivers    robots        -> joint states
    recorder   joint states  -> recordings
    solver     recordings    -> calibrated robot
    tools      what people run: command line, report, printable parts, simulation

Names are imported when they are first used, so that ``import mukca`` costs nothing.
"""

from ._faces import attach_face

__getattr__, __dir__, __all__ = attach_face(__name__, __file__)

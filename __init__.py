"""mukca: calibrate a robot arm with a printed ball and socket base.

The package has four rooms, and data flows one way through them::

    drivers    robots        -> joint states
    recorder   joint states  -> recordings
    solver     recordings    -> calibrated robot
    tools      what people run: command line, report, printable parts, simulation
"""

__all__ = ["MukcaError"]


class MukcaError(Exception):
    """Base of all errors that a user can mend; the message is one line.

    The line says what is wrong, where (file, line, joint), and what would work.

    Attributes:
        failed: The input was good, and the work ran, but its result is not to be used.
    """

    failed: bool = False

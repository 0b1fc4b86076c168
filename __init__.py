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

from importlib import import_module

TYPE_CHECKING = False  # typing takes longer to import than Python to start

if TYPE_CHECKING:
    from typing import Any

    from .drivers.driver import Driver, JointState
    from .drivers.registry import open_driver
    from .recorder.dataset import Placement, read_placements
    from .solver.robot.urdf import Robot, load_robot
    from .tools.calibration.calibrate import calibrate
    from .tools.calibration.calibration import Calibration, Errors, load_calibration
    from .tools.simulated_arms import simulate_recordings

__all__ = [
    "Calibration",
    "Driver",
    "Errors",
    "JointState",
    "MukcaError",
    "Placement",
    "Robot",
    "calibrate",
    "load_calibration",
    "load_robot",
    "open_driver",
    "read_placements",
    "simulate_recordings",
]

_MODULES = {
    "Calibration": ".tools.calibration.calibration",
    "Driver": ".drivers.driver",
    "Errors": ".tools.calibration.calibration",
    "JointState": ".drivers.driver",
    "Placement": ".recorder.dataset",
    "Robot": ".solver.robot.urdf",
    "calibrate": ".tools.calibration.calibrate",
    "load_calibration": ".tools.calibration.calibration",
    "load_robot": ".solver.robot.urdf",
    "open_driver": ".drivers.registry",
    "read_placements": ".recorder.dataset",
    "simulate_recordings": ".tools.simulated_arms",
}
"""Where each public name is defined."""


__version__ = "0.1.0"


class MukcaError(Exception):
    """Base of all errors that a user can mend; the message is one line.

    The line says what is wrong, where (file, line, joint), and what would work.

    Attributes:
        failed: The input was good, and the work ran, but its result is not to be used.
    """

    failed: bool = False


def __getattr__(name: str) -> "Any":
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES[name], __name__), name)


def __dir__() -> list[str]:
    return sorted(__all__)

"""The calibration of several robots, which recorded at the same bases."""

from collections.abc import Mapping
from dataclasses import replace

from ..identification import Progress
from ..identification.robot import Robot
from .calibration import Calibration
from .document import document_of
from .multi_robot_calibration import MultiRobotCalibration
from .options import SolveOptions
from .preparation import Recordings
from .several_problems import located_in_training, problems_of_robots
from .tables import PROOF, STUDIES
from .tied_fits import tied_fits


def calibrate_robots(
    robots: Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
    progress: Progress,
) -> MultiRobotCalibration:
    """Calibrate several robots by name; arguments are those of :func:`.calibrate_robot`."""
    problems = problems_of_robots(robots, train, test, options)
    located = located_in_training(problems, options)
    settings = replace(options, sockets_at=located)
    fits, world = tied_fits([*problems.values()], settings, progress)
    calibrations: dict[str, Calibration] = {}
    for (name, problem), fit in zip(problems.items(), fits, strict=True):
        proven = PROOF(problem, fit, progress=progress)
        document = document_of(proven, fit, STUDIES)
        calibrations[name] = Calibration(document, fit.calibrated)
    data = {name: problem.measurements for name, problem in problems.items()}
    return MultiRobotCalibration.of(calibrations, world, data)

"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, overload

from ...recorder import Placement
from ..identification.data import base_name, in_placements, one_blas_thread
from ..identification.robot import Robot
from .calibration import Calibration
from .convergence import converged_fits
from .multi_robot_calibration import MultiRobotCalibration, common_document
from .options import CalibrateOptions, SolveOptions, check_keywords
from .preparation import Recordings, problems_of
from .results import document_of
from .setting_right import seen_at_rest

if TYPE_CHECKING:
    from typing_extensions import Unpack  # Python 3.10 has none

Progress = Callable[[str], None]
"""Called with a word for each model that is fitted."""


def _silent(_: str) -> None:
    pass


@overload
def calibrate(
    robot: Robot,
    train: Placement | Sequence[Placement],
    test: Placement | Sequence[Placement] = (),
    progress: Progress = _silent,
    **options: "Unpack[CalibrateOptions]",
) -> Calibration: ...


@overload
def calibrate(
    robot: Mapping[str, Robot],
    train: Recordings,
    test: Recordings = (),
    progress: Progress = _silent,
    **options: "Unpack[CalibrateOptions]",
) -> MultiRobotCalibration: ...


@one_blas_thread
def calibrate(
    robot: Robot | Mapping[str, Robot],
    train: Recordings,
    test: Recordings = (),
    progress: Progress = _silent,
    **options: "Unpack[CalibrateOptions]",
) -> Calibration | MultiRobotCalibration:
    """Calibrate a robot from recordings.

    One placement is enough to calibrate; others, held out by ``test``, show how well it worked.
    Nothing is written before :meth:`Calibration.save`.

    Args:
        robot: The nominal robot, see :func:`mukca.load_robot`; or several robots by name, which
            recorded at the same bases, so that their relative base poses are calibrated, too.
        train: The placements to fit, see :func:`mukca.read_placements`. Of several robots they are
            given by name, too, and those of one base have one name.
        test: Placements that the fit does not see. One that is trained on is left out of them.
        progress: Called with a word for each model that is fitted.
        options: Fields of :class:`.SolveOptions`, which ``mukca solve --help-all`` explains. Of
            both methods: method, distance, free, fix, as_recorded, leave_out,
            flange_poses, repeatability_mm, accept_distorted. Of ``auto`` alone: known, sockets_at,
            distance_deviation, without, zeros, prior, remounted, payload, gravity. Of ``paper``
            alone: optimizer, regularization, max_iterations.

    Raises:
        UsageError: An option that cannot be, or belongs to the other method.
        MeasurementError: A placement does not hold what is needed.
        KnownError: A known distance does not fit the placements.
        FrameError: Coordinates that cannot be, or a frame that nothing ties to the robot.
        NotConverged: The fit did not converge.
    """
    check_keywords("calibrate", options, CalibrateOptions.__annotations__)
    settings = SolveOptions(**options).validated()
    problems = problems_of(robot, train, test, settings)
    # Known distances have the names of placements now.
    if not isinstance(robot, Mapping):
        settings = replace(settings, known=problems[""].options.known)
    bases: dict[str, list[str]] = {"train": [], "test": []}
    for role, measured in chain(*(problem.placements for problem in problems.values())):
        bases[role].append(base_name(measured, len(problems)))
    located = in_placements(settings.located, bases["train"], bases["test"])
    settings = replace(settings, sockets_at=located)
    fits = converged_fits([*problems.values()], settings, progress)
    calibrations = {
        name: Calibration(document_of(seen_at_rest(problem, fit), fit), fit.calibrated)
        for (name, problem), fit in zip(problems.items(), fits, strict=True)
    }
    if not isinstance(robot, Mapping):
        return calibrations[""]
    assert fits[0].world is not None  # the paper's method knows one robot
    document = common_document(calibrations, fits[0].world)
    return MultiRobotCalibration(calibrations, document)

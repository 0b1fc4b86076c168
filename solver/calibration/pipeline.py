"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Mapping, Sequence
from inspect import signature
from typing import TYPE_CHECKING, overload

from ...recorder import Placement
from ..identification.data import one_blas_thread
from ..identification.robot import Robot
from .calibration import Calibration
from .earlier import prior_of
from .options import CalibrateOptions, SolveOptions, check_keywords
from .preparation import Recordings
from .robot_calibration import calibrate_robot
from .several_robots import MultiRobotCalibration, calibrate_robots
from .tables import TABLES

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

    The fit is to all placements. Fits that each leave one out show how well it worked:
    :attr:`Calibration.errors` has their errors, too. Nothing is written before
    :meth:`Calibration.save`.

    Args:
        robot: The nominal robot, see :func:`mukca.load_robot`; or several robots by name, which
            recorded at the same bases, so that their relative base poses are calibrated, too.
        train: The placements to fit, see :func:`mukca.read_placements`. Of several robots they are
            given by name, too, and those of one base have one name.
        test: Placements that are kept apart for the proof: the fit does not see them, and nothing
            is left out of it. One that is trained on is no test.
        progress: Called with a word for each model that is fitted.
        options: Fields of :class:`.SolveOptions`, which ``mukca solve --help-all`` explains. Of
                both methods: method, distance, free, fix, as_recorded, leave_out, flange_poses,
            repeatability_mm, accept_distorted, no_proof. Of ``auto`` alone: scale, known,
            sockets_at, distance_deviation, without, zeros, prior, remounted, payload,
            gravity. Of ``paper`` alone: optimizer, regularization, max_iterations.

    Raises:
        UsageError: An option that cannot be, or belongs to the other method.
        MeasurementError: A placement does not hold what is needed.
        KnownError: A known distance does not fit the placements.
        FrameError: Coordinates that cannot be, or a frame that nothing ties to the robot.
        NotConverged: The fit did not converge.
    """
    arguments = signature(calibrate).parameters
    check_keywords(
        "calibrate", options, [*arguments, *CalibrateOptions.__annotations__]
    )
    settings = SolveOptions(**options).validated()
    if isinstance(robot, Mapping):
        return calibrate_robots(robot, train, test, settings, progress)
    document, calibrated = calibrate_robot(
        robot,
        train,
        test,
        settings,
        TABLES,
        prior=lambda problem: prior_of(settings, [problem]),
        progress=progress,
    )
    return Calibration(document, calibrated)

"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, overload

import numpy as np

from ...recorder.dataset import Placement
from ..data import KnownDistance, RobotRecordings, SocketAt, in_placements
from ..paper import NotConverged
from ..robot import Robot, choose_parameters
from .arms import ArmsCalibration
from .calibration import Calibration
from .fit import Fit, fit_arms, fit_by_auto, fit_by_paper
from .options import Settings
from .prepare import as_list, coordinates_of, prepare
from .problem import CalibrationProblem
from .results import compose
from .type_prior import type_priors
from .usage import UsageError

if TYPE_CHECKING:
    from typing_extensions import Unpack

Recordings = Placement | Sequence[Placement] | Mapping[str, Placement | Sequence[Placement]]
"""Placements; of several robots by the robots' names, or each with its own ``robot_name``."""


class Options(TypedDict, total=False):
    """The options of :func:`calibrate`."""

    method: str
    distance: float | None
    free: Sequence[str]
    fix: Sequence[str]
    split_moved: bool
    known: Sequence[str | KnownDistance]
    sockets_at: str | Path | Sequence[str | Path | SocketAt]
    distance_deviation: float | None
    without: Sequence[str]
    zeros: bool | None
    type_prior: Sequence[str | Path]
    payload: float | None
    gravity: Sequence[float] | None
    optimizer: str | None
    regularization: float | None
    max_iterations: int | None
    repeatability_mm: float | None
    progress: Callable[[str], None]


def _silent(_: str) -> None:
    pass


@overload
def calibrate(
    robot: Robot,
    train: Placement | Sequence[Placement],
    *,
    test: Placement | Sequence[Placement] = (),
    **options: "Unpack[Options]",
) -> Calibration: ...


@overload
def calibrate(
    robot: Mapping[str, Robot],
    train: Recordings,
    *,
    test: Recordings = (),
    **options: "Unpack[Options]",
) -> ArmsCalibration: ...


def calibrate(
    robot: Robot | Mapping[str, Robot],
    train: Recordings,
    *,
    test: Recordings = (),
    method: str = "auto",
    distance: float | None = None,
    free: Sequence[str] = (),
    fix: Sequence[str] = (),
    split_moved: bool = False,
    known: Sequence[str | KnownDistance] = (),
    sockets_at: str | Path | Sequence[str | Path | SocketAt] = (),
    distance_deviation: float | None = None,
    without: Sequence[str] = (),
    zeros: bool | None = None,
    type_prior: Sequence[str | Path] = (),
    payload: float | None = None,
    gravity: Sequence[float] | None = None,
    optimizer: str | None = None,
    regularization: float | None = None,
    max_iterations: int | None = None,
    repeatability_mm: float | None = None,
    progress: Callable[[str], None] = _silent,
) -> Calibration | ArmsCalibration:
    """Calibrate a robot from recordings.

    One placement is enough to calibrate; others, held out by ``test``, show how well it worked.
    Nothing is written before :meth:`Calibration.save`.

    Args:
        robot: The nominal robot, see :func:`mukca.load_robot`; or several robots by name, which
            recorded at the same bases, so that it comes out where they stand to each other.
        train: The placements to fit, see :func:`mukca.read_placements`. Of several robots they are
            given by name, too, and those of one base have one name.
        test: Placements that the fit does not see. One that is trained on is left out of them.
        method: ``auto``: geometry, elasticity and transmission error, as far as the data
            support them; ``paper``: Eq. (5) of the paper, geometry alone.
        distance: Between the centres of a base's two sockets [m]; None for the recording's own,
            or 0.05 where it has none. 1 % wrong makes the robot 1 % too long.
        free: What of the geometry is free: joint names, ``JOINT.x`` .. ``JOINT.yaw``,
            ``JOINT.xyz`` or ``JOINT.rpy``; ``*`` stands for any text. Empty: all that is useful.
        fix: What is not free, by the same words.
        split_moved: Where a base moved, give the part after it a socket of its own.
        known: (auto) Further measured distances between sockets, as
            ``"left:0-right:0=0.175+-0.0001"``: placement, socket, metres.
        sockets_at: (auto) Files with measured coordinates of sockets, see
            :mod:`mukca.solver.data.sockets_at`; or such coordinates.
        distance_deviation: (auto) Standard deviation of ``distance`` [m]; None for a caliper's.
        without: (auto) Among ``compliance``, ``tilt``, ``play``, ``transmission``,
            ``joint-noise``: what not to try.
        zeros: (auto) Whether the joints' zeros may be off by degrees, as on arms made of servos.
        type_prior: (auto) ``calibration.json`` files of other arms of the type, or the
            ``elasticity.json`` that ``mukca fleet`` writes, whose elasticity is
            much alike; the data decide how far to believe it. ``["shipped"]``, the default: what
            was measured of the types of shipped robots; ``["none"]``: nothing.
        payload: (auto) Mass at the ball beyond that of the model [kg].
        gravity: (auto) Acceleration in the base frame [m/s^2], for an arm on a wall or ceiling.
        optimizer: (paper) ``gauss-newton`` or ``ipopt``; both reach the same minimum.
        regularization: (paper) lambda of Eq. (5).
        max_iterations: (paper) Steps allowed.
        repeatability_mm: Of the arm [mm], which the verdict's limits rest on; None for what is
            known of a shipped robot.
        progress: Told what is being fitted.

    Raises:
        UsageError: A setting that cannot be, or belongs to the other method.
        MeasurementError: A placement does not hold what is needed.
        KnownError: A known distance does not fit the placements.
        FrameError: Coordinates that cannot be, or a frame that nothing ties to the robot.
        NotConverged: The fit did not settle.
    """
    located = coordinates_of(sockets_at)
    settings = Settings(
        method=method,
        distance=distance,
        free=free,
        fix=fix,
        split_moved=split_moved,
        known=tuple(map(str, known)),
        sockets_at=tuple(map(str, located)),
        distance_deviation=distance_deviation,
        without=without,
        zeros=zeros,
        type_prior=tuple(map(str, type_prior)),
        payload=payload,
        gravity=gravity,
        optimizer=optimizer,
        regularization=regularization,
        max_iterations=max_iterations,
        repeatability_mm=repeatability_mm,
    ).settled()
    if isinstance(robot, Mapping):
        return _calibrate_arms(robot, train, test, settings, located, progress)
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    task = prepare(robot, train, test, settings, located)
    names = ([m.name for m in part] for part in (task.train, task.test))
    fit = _fit(task, in_placements(located, *names), progress)
    return Calibration(compose(task, fit), fit.calibrated)


def _calibrate_arms(
    robots: Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    settings: Settings,
    located: Sequence[SocketAt],
    progress: Callable[[str], None],
) -> ArmsCalibration:
    """Calibrate several robots together; see :func:`calibrate`."""
    if settings.method != "auto":
        raise UsageError("several robots: --method paper knows one, --method auto knows both")
    for one in located:
        if one.frame == "base":
            raise UsageError(
                f"{one.where}: the base of which robot? Write {next(iter(robots))}:base"
            )
    training, held_out = _by_robot(robots, train), _by_robot(robots, test)
    empty = next((name for name in robots if not training[name]), None)
    if empty is not None:
        raise UsageError(f"{empty}: no placement to train on; the robots are {', '.join(robots)}")
    tasks = {
        name: prepare(robot, training[name], held_out[name], settings, located)
        for name, robot in robots.items()
    }
    every = list(tasks.values())
    places = [m.placement.place for task in every for m in task.train]
    judged = [m.placement.place for task in every for m in task.test]
    arms = [RobotRecordings(t.robot, t.train, settings.load, name) for name, t in tasks.items()]
    parameters = [choose_parameters(r, settings.free, settings.fix) for r in robots.values()]
    types = type_priors(settings.type_prior, [arm.robot for arm in arms])
    options = {k: v for k, v in settings.of_auto().items() if k != "load"}
    fits = _settled(
        lambda: fit_arms(
            arms,
            parameters,
            sockets_at=in_placements(located, places, judged),
            types=types,
            progress=progress,
            **options,
        ),
        every,
    )
    assert fits[0].world is not None
    calibrations = {
        name: Calibration(compose(task, fit), fit.calibrated)
        for (name, task), fit in zip(tasks.items(), fits, strict=True)
    }
    return ArmsCalibration(calibrations, fits[0].world)


def _by_robot(robots: Mapping[str, Robot], placements: Recordings) -> dict[str, list[Placement]]:
    """Return each robot's placements: as given by name, or as each of them says."""
    by_robot: dict[str, list[Placement]] = {name: [] for name in robots}
    named = ", ".join(robots)
    if isinstance(placements, Mapping):
        pairs = [(name, p) for name, own in placements.items() for p in as_list(own)]
    else:
        pairs = [(p.robot_name, p) for p in as_list(placements)]
    for name, placement in pairs:
        where = placement.path or placement.name
        if name is None:
            raise UsageError(f"{where}: whose is it? Write NAME:{where}; the robots are {named}")
        if name not in by_robot:
            raise UsageError(f"{where}: of robot {name!r}, but the robots are {named}")
        if any(p.place == placement.place for p in by_robot[name]):
            raise UsageError(
                f"{where}: robot {name} has two placements called {placement.place!r}; rename a "
                "folder, since placements of one name are one base for all robots"
            )
        by_robot[name].append(placement)
    return by_robot


def _fit(
    task: CalibrationProblem, located: Sequence[SocketAt], progress: Callable[[str], None]
) -> Fit:
    settings = task.settings
    parameters = choose_parameters(task.robot, settings.free, settings.fix)
    if settings.method == "paper":
        options = settings.of_paper()
        return _settled(
            lambda: [fit_by_paper(task.robot, parameters, task.train, **options)], [task]
        )[0]
    options = settings.of_auto()
    (of_type,) = type_priors(settings.type_prior, [task.robot])
    return _settled(
        lambda: [
            fit_by_auto(
                task.robot,
                parameters,
                task.train,
                **options,
                of_type=of_type,
                sockets_at=located,
                progress=progress,
            )
        ],
        [task],
    )[0]


def _settled(fit: Callable[[], list[Fit]], tasks: Sequence[CalibrationProblem]) -> list[Fit]:
    """Return fits, if they settled to finite numbers; else say what is wrong in the recordings."""
    findings = [f for task in tasks if task.inspected is not None for f in task.inspected.findings]
    wrong = next((finding for finding in findings if finding.level == "error"), None)
    try:
        fits = fit()
    except NotConverged:
        if wrong is None:
            raise
        raise NotConverged(f"the fit did not settle; {wrong}") from None
    except np.linalg.LinAlgError as error:
        raise NotConverged(f"the fit did not settle ({error}); run mukca check") from None
    if not all(np.isfinite(one.calibrated.values).all() for one in fits):
        raise NotConverged("the fit did not settle: its numbers are not finite; run mukca check")
    return fits

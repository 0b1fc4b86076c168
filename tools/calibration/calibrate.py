"""From recordings to a calibration: check, fit, measure the errors."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ...recorder.dataset import Placement
from ...solver.checks.changes import split_at
from ...solver.checks.distances import named
from ...solver.checks.inspection import Survey, inspect_all, next_placement
from ...solver.data.measurements import Measurement, check_distinct, measure
from ...solver.data.observations import KnownDistance, SocketAt
from ...solver.data.sockets_at import in_placements, parse_socket_at, read_sockets_at, spaced
from ...solver.fit import Fit, fit_by_auto, fit_by_paper
from ...solver.paper.optimizers import NotConverged
from ...solver.robot.parameters import Parameter, choose_parameters
from ...solver.robot.urdf import Robot
from ..documents.calibration import NextPlacement
from ..usage import UsageError
from .calibration import Calibration
from .compose import compose
from .settings import Settings
from .task import Inspected, Task

__all__ = ["calibrate"]


def _silent(_: str) -> None:
    pass


def calibrate(
    robot: Robot,
    train: Placement | Sequence[Placement],
    *,
    test: Placement | Sequence[Placement] = (),
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
    payload: float | None = None,
    gravity: Sequence[float] | None = None,
    optimizer: str | None = None,
    regularization: float | None = None,
    max_iterations: int | None = None,
    repeatability_mm: float | None = None,
    progress: Callable[[str], None] = _silent,
) -> Calibration:
    """Calibrate a robot from recordings.

    One placement is enough to calibrate; others, held out by ``test``, show how well it worked.
    Nothing is written before :meth:`Calibration.save`.

    Args:
        robot: The nominal robot, see :func:`mukca.load_robot`.
        train: The placements to fit, see :func:`mukca.read_placements`.
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
    located = _coordinates(sockets_at)
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
        payload=payload,
        gravity=gravity,
        optimizer=optimizer,
        regularization=regularization,
        max_iterations=max_iterations,
        repeatability_mm=repeatability_mm,
    ).settled()
    training, held_out, warnings = _measured(robot, train, test, settings, located)
    training, inspected = _inspected(robot, training, held_out, settings)
    parameters = choose_parameters(robot, settings.free, settings.fix)
    _check_zeros(robot, parameters, settings)
    located = in_placements(located, [m.name for m in training], [m.name for m in held_out])
    fit = _fit(robot, parameters, training, settings, located, progress)
    task = Task(robot, settings, tuple(training), tuple(held_out), tuple(warnings), inspected)
    return Calibration(compose(task, fit), fit.calibrated)


def _check_zeros(robot: Robot, parameters: Sequence[Parameter], settings: Settings) -> None:
    """Refuse zeros that the URDF could not hold."""
    free = {parameter.name for parameter in parameters}
    for joint in robot.actuated if settings.zeros else ():
        angles = {f"{joint.name}.{angle}" for angle in ("roll", "pitch", "yaw")}
        if joint.type == "prismatic" or not angles <= free:
            raise UsageError(f"--zeros: {joint.name} must turn, and its angles be free")


def _measured(
    robot: Robot,
    train: Placement | Sequence[Placement],
    test: Placement | Sequence[Placement],
    settings: Settings,
    located: Sequence[SocketAt] = (),
) -> tuple[list[Measurement], list[Measurement], list[str]]:
    """Return the checked placements to train and to test on, and what to warn of."""
    training, held_out = _as_list(train), _as_list(test)
    if not training:
        raise UsageError("no placement to train on; read some by mukca.read_placements")
    trained = {p.path.resolve() for p in training if p.path is not None}
    kept = [p for p in held_out if p.path is None or p.path.resolve() not in trained]
    warnings = [f"{p.path}: trained on, so left out of the test" for p in held_out if p not in kept]
    sockets = 1 if settings.method == "auto" else 2
    measured = [p for p in (*training, *held_out) if p.samples and p.samples[0].point is not None]
    if measured and settings.method == "paper":
        raise UsageError(
            f"{measured[0].path or measured[0].name}: measured points; --method paper knows "
            "sockets only, --method auto knows both"
        )
    fitted, validated = (
        [
            spaced(measure(p, robot, settings.distance, sockets=sockets), p.name, located)
            for p in placements
        ]
        for placements in (training, kept)
    )
    check_distinct([*fitted, *validated])
    warnings += [line for m in (*fitted, *validated) for line in m.warnings]
    return fitted, validated, warnings


def _coordinates(
    sockets_at: str | Path | Sequence[str | Path | SocketAt],
) -> list[SocketAt]:
    """Return the coordinates of sockets that files, words, or they themselves give."""
    every = [sockets_at] if isinstance(sockets_at, str | Path) else sockets_at
    given = [one for one in every if isinstance(one, SocketAt)]
    others = [one for one in every if not isinstance(one, SocketAt)]
    words = [str(one) for one in others if "=" in str(one) and not Path(one).exists()]
    files = [one for one in others if str(one) not in words]
    return [*given, *map(parse_socket_at, words), *read_sockets_at(files)]


def _as_list(placements: Placement | Sequence[Placement]) -> list[Placement]:
    return [placements] if isinstance(placements, Placement) else list(placements)


def _inspected(
    robot: Robot, train: list[Measurement], test: list[Measurement], settings: Settings
) -> tuple[list[Measurement], Inspected]:
    """Look at all placements; what is held out is looked at here and never by the fit.

    Returns:
        The placements to train on, split where a base moved if asked for; and what was found.
    """
    parameters = choose_parameters(robot)
    points = [m for m in train if m.kind == "points"]
    train, test = ([m for m in part if m.kind == "sockets"] for part in (train, test))
    if not train and not test:
        return points, Inspected((), None)
    known = named(train, settings.distances)

    def look(placements: Sequence[Measurement]) -> Survey:
        deviation = settings.deviation
        return inspect_all(robot, parameters, placements, known=known, deviation=deviation)

    survey = look([*train, *test])
    if settings.split_moved:
        alone = look(train) if test else survey
        train = [split_at(one.measured, one.changes) for one in alone.placements]
    hint = NextPlacement(text=next_placement(robot, survey))
    return [*train, *points], Inspected(survey.findings, hint)


def _fit(
    robot: Robot,
    parameters: Sequence[Parameter],
    train: Sequence[Measurement],
    settings: Settings,
    located: Sequence[SocketAt],
    progress: Callable[[str], None],
) -> Fit:
    try:
        if settings.method == "paper":
            fit = fit_by_paper(robot, parameters, train, **settings.of_paper())
        else:
            options = settings.of_auto()
            fit = fit_by_auto(
                robot, parameters, train, **options, sockets_at=located, progress=progress
            )
    except np.linalg.LinAlgError as error:
        raise NotConverged(f"the fit did not settle ({error}); run mukca check") from None
    if not np.isfinite(fit.calibrated.values).all():
        raise NotConverged("the fit did not settle: its numbers are not finite; run mukca check")
    return fit

"""Recordings made ready for a fit: checked against the robot, and inspected."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import cast

from ...recorder import Placement
from ..data import Measurement, check_distinct, measure, spaced
from ..diagnostics import Diagnostic, Survey, inspect_all, named, next_placement, split_at
from ..results import NextPlacement
from ..robot import Parameter, Robot, choose_parameters
from .options import SolveOptions, UsageError


@dataclass(frozen=True)
class Inspected:
    """Diagnostics of the recordings, from before the fit."""

    findings: tuple[Diagnostic, ...]
    next_placement: NextPlacement | None
    """None where an instrument measured all samples."""


@dataclass(frozen=True)
class CalibrationProblem:
    """A robot, checked recordings of it, and the options of their fit."""

    robot: Robot
    options: SolveOptions
    train: tuple[Measurement, ...]
    test: tuple[Measurement, ...]
    warnings: tuple[str, ...]
    inspected: Inspected | None
    """None where the recordings could not be checked."""

    def findings(self, *, fitted: bool) -> tuple[Diagnostic, ...] | None:
        """Return what was found; of servos a fit, which knows their play, judges the size."""
        if self.inspected is None:
            return None
        judged = fitted and bool(self.options.zeros)
        return tuple(f for f in self.inspected.findings if not (judged and f.code == "scale"))


def prepare(
    robot: Robot,
    train: Placement | Sequence[Placement],
    test: Placement | Sequence[Placement],
    options: SolveOptions,
) -> CalibrationProblem:
    """Return a robot's recordings, checked and looked at.

    Args:
        robot: The nominal robot.
        train: The placements to fit.
        test: Those held out.
        options: Method, and its options.

    Raises:
        UsageError: Nothing to train on, or what the method does not know.
        MeasurementError: A placement does not hold what is needed.
    """
    _check_robot(robot)
    _check_zeros(robot, choose_parameters(robot, options.free, options.fix), options)
    training, held_out, warnings = _measured(robot, train, test, options)
    training, inspected = _inspected(robot, training, held_out, options)
    return CalibrationProblem(
        robot, options, tuple(training), tuple(held_out), tuple(warnings), inspected
    )


def _check_robot(robot: object) -> None:
    """Refuse a robot's name or file, which is to be loaded first."""
    if not isinstance(robot, Robot):
        raise UsageError(f"{robot!r:.60}: no robot; load it by mukca.load_robot")


def _check_zeros(robot: Robot, parameters: Sequence[Parameter], options: SolveOptions) -> None:
    """Refuse zeros that the URDF could not hold."""
    free = {parameter.name for parameter in parameters}
    for joint in robot.actuated if options.zeros else ():
        angles = {f"{joint.name}.{angle}" for angle in ("roll", "pitch", "yaw")}
        if joint.type == "prismatic" or not angles <= free:
            raise UsageError(f"--zeros: {joint.name} must turn, and its angles be free")


def _measured(
    robot: Robot,
    train: Placement | Sequence[Placement],
    test: Placement | Sequence[Placement],
    options: SolveOptions,
) -> tuple[list[Measurement], list[Measurement], list[str]]:
    """Return the checked placements to train and to test on, and what to warn of."""
    training, held_out = as_list(train), as_list(test)
    if not training:
        raise UsageError("no placement to train on; read some by mukca.read_placements")
    trained = {p.path.resolve() for p in training if p.path is not None}
    kept = [p for p in held_out if p.path is None or p.path.resolve() not in trained]
    warnings = [f"{p.path}: trained on, so left out of the test" for p in held_out if p not in kept]
    sockets = 1 if options.method == "auto" else 2
    measured = [p for p in (*training, *held_out) if p.samples and p.samples[0].point is not None]
    if measured and options.method == "paper":
        raise UsageError(
            f"{measured[0].path or measured[0].name}: measured points; --method paper knows "
            "sockets only, --method auto knows both"
        )
    fitted, validated = (
        [
            spaced(measure(p, robot, options.distance, sockets=sockets), p.name, options.located)
            for p in placements
        ]
        for placements in (training, kept)
    )
    check_distinct([*fitted, *validated])
    warnings += [line for m in (*fitted, *validated) for line in m.warnings]
    return fitted, validated, warnings


def as_list(placements: object) -> list[Placement]:
    """Return placements as a list; one stands for itself.

    Raises:
        UsageError: Something else, a path for instance, which is to be read first.
    """
    several = isinstance(placements, Iterable) and not isinstance(placements, str)
    every: list[object] = list(cast("Iterable[object]", placements)) if several else [placements]
    read = [one for one in every if isinstance(one, Placement)]
    if len(read) < len(every):
        other = next(one for one in every if not isinstance(one, Placement))
        raise UsageError(f"{other!r:.60}: no placement; read it by mukca.read_placements")
    return read


def _inspected(
    robot: Robot, train: list[Measurement], test: list[Measurement], options: SolveOptions
) -> tuple[list[Measurement], Inspected]:
    """Look at all placements; what is held out is looked at here and never by the fit.

    Returns:
        The placements to train on, split where a base moved if asked for; and what was found.
    """
    points = [m for m in train if m.kind == "points"]
    train, test = ([m for m in part if m.kind == "sockets"] for part in (train, test))
    if not train and not test:
        return points, Inspected((), None)
    known = named(train, options.distances)

    def look(placements: Sequence[Measurement]) -> Survey:
        return inspect_all(
            robot,
            placements,
            known=known,
            deviation=options.deviation,
            zeros=bool(options.zeros),
        )

    survey = look([*train, *test])
    if options.split_moved:
        alone = look(train) if test else survey
        train = [split_at(one.measured, one.changes) for one in alone.placements]
    hint = NextPlacement(text=next_placement(robot, survey))
    return [*train, *points], Inspected(survey.diagnostics, hint)

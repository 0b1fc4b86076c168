"""Recordings made ready for a fit: checked against the robot, and inspected."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from ...recorder import Placement
from .. import results
from ..bayes.model import set_apart
from ..bayes.selection import FoundMovement
from ..data import (
    Measurement,
    RobotRecordings,
    as_flange_poses,
    check_distinct,
    check_left_out,
    without,
)
from ..diagnostics import Survey, next_placement, single_socket_diagnostics, where_of
from ..robot import Parameter, Robot, choose_parameters
from .option import UsageError
from .options import SolveOptions
from .setting_right import NOTHING_SEEN, checked, mended

LOCKED = math.radians(6)
"""A pitch nearer than this to 90 degrees leaves roll and yaw hardly two turns."""
STEADY = "screw the base down, let the arm warm up, and record it again"
Recordings = Placement | Sequence[Placement] | Mapping[str, Placement | Sequence[Placement]]
"""Placements; of several robots by the robots' names, or each with its own ``robot_name``."""


@dataclass(frozen=True, kw_only=True)
class CalibrationProblem(RobotRecordings):
    """A robot, checked recordings of it to train on, and the options of their fit."""

    options: SolveOptions
    test: Sequence[Measurement] = ()
    warnings: tuple[str, ...] = ()
    checks: tuple[results.Diagnostic, ...] = ()
    """Diagnostics of the recordings, from before the fit."""
    survey: Survey = NOTHING_SEEN
    """What was seen of the placements, one by one and together, once all was set right."""
    hypotheses: tuple[results.Hypothesis, ...] = ()
    """Explanations of the recordings, the most probable first."""
    next_placement: results.NextPlacement | None = None
    """None where an instrument measured all samples."""

    @property
    def placements(self) -> list[tuple[results.Role, Measurement]]:
        """All placements, those to train on first."""
        return [*(("train", m) for m in self.measurements), *(("test", m) for m in self.test)]

    def at_rest(
        self,
        moved: np.ndarray | None,
        found: Iterable[FoundMovement],
        calibrated: results.CalibratedRobot,
    ) -> "CalibrationProblem":
        """Return the recordings with the movements of their places, row by row, as diagnostics.

        Where a placement that is held out differs throughout follows from its own samples.
        """
        named = {m.name: m for m in self.measurements}
        more = (
            results.Diagnostic(
                "warning",
                "movement" if one.kept else "moved",
                where_of([named[one.placement]]),
                _movement_text(named[one.placement], one),
                STEADY,
            )
            for one in found
        )
        ends = np.cumsum([len(m.positions) for m in self.measurements])
        parts = [None] * len(ends) if moved is None else np.split(moved, ends)[: len(ends)]
        train = (replace(m, moved=own) for m, own in zip(self.measurements, parts, strict=True))
        checks = (*self.checks, *more)
        test = tuple(_set_apart(m, calibrated) for m in self.test)
        return replace(self, checks=checks, measurements=tuple(train), test=test)


def _set_apart(measured: Measurement, calibrated: results.CalibratedRobot) -> Measurement:
    """Return a held-out placement with what is otherwise in it."""
    if not measured.apart or measured.kind == "points":
        return measured
    balls = calibrated.predict(measured)
    return replace(measured, moved=set_apart(calibrated.robot, measured, balls))


def _movement_text(measured: Measurement, movement: FoundMovement) -> str:
    """Return a movement in words, a step with the first sample after it."""
    if movement.rank is None:
        return movement.text
    in_time = measured.order[np.argsort(measured.clock("time"), kind="stable")]
    first = measured.placement.samples[int(in_time[movement.rank])]
    return movement.text.format(first=first.named)


def problems_of(
    robot: Robot | Mapping[str, Robot], train: Recordings, test: Recordings, options: SolveOptions
) -> dict[str, CalibrationProblem]:
    """Return what there is to fit by the robots' names; one robot alone has none."""
    every = [p for part in (train, test) for own in _each(part) for p in as_list(own)]
    check_left_out(every, options.leave_out)
    if isinstance(robot, Mapping):
        _check_robots(robot, options)
        training, held_out = _by_robot(robot, train), _by_robot(robot, test)
        if empty := [name for name, own in training.items() if not own]:
            known = ", ".join(robot)
            raise UsageError(f"{empty[0]}: no placement to train on; the robots are {known}")
        every = [p for one in (training, held_out) for part in one.values() for p in part]
        options.check_payloads(every)
        problems = {
            name: replace(_prepare(own, training[name], held_out[name], options), name=name)
            for name, own in robot.items()
        }
        # one arm's samples taken for another's as well would fit both
        check_distinct([m for p in problems.values() for m in (*p.measurements, *p.test)])
        return problems
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    options.check_payloads([*as_list(train), *as_list(test)])
    return {"": _with_lone_sockets(_prepare(robot, as_list(train), as_list(test), options))}


def _each(placements: Recordings) -> Iterable[object]:
    """Return the placements of each robot."""
    return placements.values() if isinstance(placements, Mapping) else [placements]


def _check_robots(robots: Mapping[str, Robot], options: SolveOptions) -> None:
    """Refuse options that several robots cannot have."""
    if options.method != "auto":
        raise UsageError("several robots: --method paper knows one, --method auto knows both")
    for one in options.located:
        if one.frame == "base":
            raise UsageError(
                f"{one.where}: the base of which robot? Write {next(iter(robots))}:base"
            )


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


def _prepare(
    robot: Robot, train: list[Placement], test: list[Placement], options: SolveOptions
) -> CalibrationProblem:
    """Return a robot's recordings, checked, looked at, and split where a base moved."""
    if not isinstance(robot, Robot):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise UsageError(f"{robot!r:.60}: no robot; load it by mukca.load_robot")
    _check_zeros(robot, choose_parameters(robot, options.free, options.fix), options)
    return _inspected(_measured(robot, train, test, options))


def _with_lone_sockets(problem: CalibrationProblem) -> CalibrationProblem:
    """Return one robot's recordings with diagnostics of lone sockets, which nothing ties."""
    if problem.options.located:
        return problem
    every = [m for _, m in problem.placements]
    more = single_socket_diagnostics(every, problem.options.distances)
    return replace(problem, checks=(*problem.checks, *more))


def _held_as_exact(robot: Robot, options: SolveOptions) -> list[str]:
    """Return what a few free numbers of a calibrated URDF cannot know."""
    file = Path(robot.source).with_name("calibration.json")
    if not options.free or options.prior or Path(robot.source).suffix != ".urdf":
        return []
    try:
        known = results.calibrated_robot(results.read_calibration(file), str(file))
    except results.DocumentError:
        return []
    same = robot.joint_names == known.robot.joint_names
    if not same or not np.array_equal(robot.origins, known.origins):
        return []
    return [
        f"{robot.source}: calibrated, and --free takes the rest of it for exact: neither its "
        f"elasticity nor how well it is known is in a URDF. mukca rezero, tool or handeye {file} "
        f"hold it with both; mukca solve --prior {file} fits all of it again"
    ]


def _locked_angles(robot: Robot, options: SolveOptions) -> list[str]:
    """Return a warning of joints whose roll and yaw are nearly one turn, which the paper fits."""
    free = {p.joint for p in choose_parameters(robot, options.free, options.fix) if p.unit == "rad"}
    joints = [joint for joint in robot.joints if joint.name in free and joint.actuated]
    locked = [j.name for j in joints if abs(math.cos(j.origin.rpy[1])) < math.sin(LOCKED)]
    if options.method != "paper" or not locked:
        return []
    return [
        f"{', '.join(locked)}: a pitch near 90 degrees makes roll and yaw one turn, and the third "
        "turn is lost to --method paper; --method auto has all three"
    ]


def _weightless(robot: Robot, data: Sequence[Measurement], options: SolveOptions) -> list[str]:
    """Return a warning of a model without masses, whose arm does not bend under its weight."""
    if robot.bodies or options.method == "paper" or all(m.efforts is not None for m in data):
        return []
    return [
        f"{robot.source}: the URDF has no masses, so how the arm bends under its weight is not "
        "fitted; give its links <inertial> with <mass> and <origin>"
    ]


def _check_zeros(robot: Robot, parameters: Sequence[Parameter], options: SolveOptions) -> None:
    """Refuse zeros that the URDF could not hold."""
    free = {parameter.name for parameter in parameters}
    for joint in robot.actuated if options.zeros else ():
        angles = {f"{joint.name}.{angle}" for angle in ("roll", "pitch", "yaw")}
        if joint.type == "prismatic" or not angles <= free:
            raise UsageError(f"--zeros: {joint.name} must turn, and its angles be free")


def _measured(
    robot: Robot, train: list[Placement], test: list[Placement], options: SolveOptions
) -> CalibrationProblem:
    """Return the checked placements to train and to test on, and what to warn of."""
    if not train:
        raise UsageError("no placement to train on; read some by mukca.read_placements")
    trained = {p.path.resolve() for p in train if p.path is not None}
    if options.flange_poses:
        train, test = as_flange_poses(train), as_flange_poses(test)
    train, test = (options.carrying(part) for part in (train, test))
    kept = [p for p in test if p.path is None or p.path.resolve() not in trained]
    warnings = [f"{p.path}: trained on, so left out of the test" for p in test if p not in kept]
    sockets = 1 if options.method == "auto" else 2
    measured = [p for p in (*train, *test) if p.samples and p.samples[0].point is not None]
    if measured and options.method == "paper":
        raise UsageError(
            f"{measured[0].path or measured[0].name}: measured points; --method paper knows "
            "sockets only, --method auto knows both"
        )
    fitted, refused = checked(robot, without(train, options.leave_out), options, sockets)
    held_out, more = checked(robot, without(kept, options.leave_out), options, sockets)
    if not fitted:
        raise next(iter(refused), UsageError("--leave-out: no placement is left to train on"))
    warnings += [f"{error}; it is left out" for error in (*refused, *more)]
    check_distinct([*fitted, *held_out])
    warnings += _held_as_exact(robot, options)
    warnings += _locked_angles(robot, options)
    warnings += _weightless(robot, [*fitted, *held_out], options)
    warnings += [line for m in (*fitted, *held_out) for line in m.warnings]
    return CalibrationProblem(
        robot, fitted, options.load, options=options, test=held_out, warnings=tuple(warnings)
    )


def as_list(placements: object) -> list[Placement]:
    """Return placements as a list; one stands for itself, and a path is refused."""
    several = isinstance(placements, Iterable) and not isinstance(placements, str)
    every: list[object] = list(cast("Iterable[object]", placements)) if several else [placements]
    read = [one for one in every if isinstance(one, Placement)]
    if len(read) < len(every):
        other = next(one for one in every if not isinstance(one, Placement))
        raise UsageError(f"{other!r:.60}: no placement; read it by mukca.read_placements")
    return read


def _inspected(problem: CalibrationProblem) -> CalibrationProblem:
    """Look at all placements; what is held out is looked at here and never by the fit."""
    options, robot = problem.options, problem.robot
    right = mended(robot, problem.measurements, problem.test, options)
    survey, place = right.survey, None
    if any(m.kind == "sockets" for m in (*right.train, *right.test)):
        place = results.NextPlacement(text=next_placement(robot, survey))
    return replace(
        problem,
        measurements=right.train,
        test=right.test,
        checks=(*right.done, *survey.diagnostics),
        options=replace(options, known=right.known),
        survey=survey,
        hypotheses=survey.hypotheses,
        next_placement=place,
    )

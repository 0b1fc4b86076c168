"""Recordings made ready for a fit: checked against the robot, and inspected."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from typing import cast

import numpy as np

from ...recorder import Placement, distinctly_named
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
from ..robot import Robot, choose_parameters
from .model_warnings import check_zeros, held_as_exact, locked_angles, weightless
from .options import SolveOptions, UsageError
from .setting_right import NOTHING_SEEN, checked, mended

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
    """Findings on the placements, one by one and together, once all was set right."""
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
        shifts: np.ndarray | None,
        movements: Iterable[FoundMovement],
        calibrated: results.CalibratedRobot,
    ) -> "CalibrationProblem":
        """Return the recordings with the movements of their places, row by row, as diagnostics.

        Where a placement that is held out differs throughout follows from its own samples.
        """
        by_name = {m.name: m for m in self.measurements}
        diagnostics = (
            results.Diagnostic(
                "warning",
                "movement" if movement.kept else "moved",
                where_of([by_name[movement.placement]]),
                _movement_text(by_name[movement.placement], movement),
                STEADY,
            )
            for movement in movements
        )
        ends = np.cumsum([len(m.positions) for m in self.measurements])
        parts = [None] * len(ends) if shifts is None else np.split(shifts, ends)[: len(ends)]
        train = (replace(m, moved=shift) for m, shift in zip(self.measurements, parts, strict=True))
        checks = (*self.checks, *diagnostics)
        test = tuple(_set_apart(m, calibrated) for m in self.test)
        return replace(self, checks=checks, measurements=tuple(train), test=test)


def _set_apart(measured: Measurement, calibrated: results.CalibratedRobot) -> Measurement:
    """Return a held-out placement with what is otherwise in it."""
    if not measured.apart:
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
    train = train if isinstance(train, Mapping) else as_list(train)
    test = test if isinstance(test, Mapping) else as_list(test)
    parts = chain.from_iterable(map(_each, (train, test)))
    placements = list(chain.from_iterable(map(as_list, parts)))
    several = isinstance(robot, Mapping)
    check_left_out(placements if several else distinctly_named(placements), options.leave_out)
    if isinstance(robot, Mapping):
        _check_robots(robot, options)
        training = _by_robot(robot, train)
        held_out = _by_robot(robot, test)
        if missing_robots := [
            name for name, placements_of_robot in training.items() if not placements_of_robot
        ]:
            names = ", ".join(robot)
            raise UsageError(
                f"{missing_robots[0]}: no placement to train on; the robots are {names}"
            )
        parts = chain(training.values(), held_out.values())
        placements = list(chain.from_iterable(parts))
        options.check_payloads(placements)
        problems = {
            name: replace(
                _prepare(robot_of_name, training[name], held_out[name], options), name=name
            )
            for name, robot_of_name in robot.items()
        }
        # The same samples given to two arms would fit both, so refuse them.
        check_distinct(
            list(chain.from_iterable((*p.measurements, *p.test) for p in problems.values()))
        )
        return problems
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    training, held_out = as_list(train), as_list(test)
    options.check_payloads([*training, *held_out])
    return {"": _with_lone_sockets(_prepare(robot, training, held_out, options))}


def _each(placements: Recordings) -> Iterable[object]:
    """Return the placements of each robot."""
    return placements.values() if isinstance(placements, Mapping) else [placements]


def _check_robots(robots: Mapping[str, Robot], options: SolveOptions) -> None:
    """Refuse options that several robots cannot have."""
    if options.method != "auto":
        raise UsageError("several robots: --method paper knows one, --method auto knows both")
    for socket in options.located:
        if socket.frame == "base":
            raise UsageError(
                f"{socket.where}: the base of which robot? Write {next(iter(robots))}:base"
            )


def _by_robot(robots: Mapping[str, Robot], placements: Recordings) -> dict[str, list[Placement]]:
    """Return each robot's placements: as given by name, or as each of them says."""
    by_robot: dict[str, list[Placement]] = {name: [] for name in robots}
    listing = ", ".join(robots)
    if isinstance(placements, Mapping):
        groups = ((name, as_list(group)) for name, group in placements.items())
        pairs = list(chain.from_iterable(product([name], group) for name, group in groups))
    else:
        pairs = [(p.robot_name, p) for p in as_list(placements)]
    for name, placement in pairs:
        where = placement.path or placement.name
        if name is None:
            raise UsageError(
                f"{where}: which robot recorded it? Write NAME:{where}; the robots are {listing}"
            )
        if name not in by_robot:
            raise UsageError(f"{where}: of robot {name!r}, but the robots are {listing}")
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
    check_zeros(robot, choose_parameters(robot, options.free, options.fix), options)
    return _inspected(_measured(robot, train, test, options))


def _with_lone_sockets(problem: CalibrationProblem) -> CalibrationProblem:
    """Return one robot's recordings with diagnostics of lone sockets, which nothing ties."""
    if problem.options.located:
        return problem
    measurements = [m for _, m in problem.placements]
    diagnostics = single_socket_diagnostics(measurements, problem.options.distances)
    return replace(problem, checks=(*problem.checks, *diagnostics))


def _measured(
    robot: Robot, train: list[Placement], test: list[Placement], options: SolveOptions
) -> CalibrationProblem:
    """Return the checked placements to train and to test on, and what to warn of."""
    if not train:
        raise UsageError("no placement to train on; read some by mukca.read_placements")
    distinct = distinctly_named([*train, *test])
    train, test = distinct[: len(train)], distinct[len(train) :]
    paths = {p.path.resolve() for p in train if p.path is not None}
    if options.flange_poses:
        train = as_flange_poses(train)
        test = as_flange_poses(test)
    train = options.carrying(train)
    test = options.carrying(test)
    held_out_placements = [p for p in test if p.path is None or p.path.resolve() not in paths]
    warnings = [
        f"{p.path}: trained on, so left out of the test"
        for p in test
        if p not in held_out_placements
    ]
    sockets = 1 if options.method == "auto" else 2
    measured = [p for p in (*train, *test) if p.samples and p.samples[0].point is not None]
    if measured and options.method == "paper":
        raise UsageError(
            f"{measured[0].path or measured[0].name}: measured points; --method paper knows "
            "sockets only, --method auto knows both"
        )
    training, errors = checked(robot, without(train, options.leave_out), options, sockets)
    held_out, errors_held_out = checked(
        robot, without(held_out_placements, options.leave_out), options, sockets
    )
    if not training:
        raise next(iter(errors), UsageError("--leave-out: no placement is left to train on"))
    warnings += [f"{error}; it is left out" for error in (*errors, *errors_held_out)]
    check_distinct([*training, *held_out])
    warnings += held_as_exact(robot, options)
    warnings += locked_angles(robot, options)
    warnings += weightless(robot, [*training, *held_out], options)
    warnings += list(chain.from_iterable(m.warnings for m in (*training, *held_out)))
    return CalibrationProblem(
        robot, training, options.load, options=options, test=held_out, warnings=tuple(warnings)
    )


def as_list(placements: object) -> list[Placement]:
    """Return placements as a list; one stands for itself, and a path is refused."""
    several = isinstance(placements, Iterable) and not isinstance(placements, str)
    items: list[object] = list(cast("Iterable[object]", placements)) if several else [placements]
    placements_only = [item for item in items if isinstance(item, Placement)]
    if len(placements_only) < len(items):
        stranger = next(item for item in items if not isinstance(item, Placement))
        raise UsageError(f"{stranger!r:.60}: no placement; read it by mukca.read_placements")
    return placements_only


def _inspected(problem: CalibrationProblem) -> CalibrationProblem:
    """Look at all placements; what is held out is looked at here and never by the fit."""
    options = problem.options
    robot = problem.robot
    mending = mended(robot, problem.measurements, problem.test, options)
    survey = mending.survey
    place = None
    if any(m.kind == "sockets" for m in (*mending.train, *mending.test)):
        place = results.NextPlacement(text=next_placement(robot, survey))
    return replace(
        problem,
        measurements=mending.train,
        test=mending.test,
        checks=(*mending.done, *survey.diagnostics),
        options=replace(options, known=mending.known),
        survey=survey,
        hypotheses=survey.hypotheses,
        next_placement=place,
        effects=mending.effects,
    )

"""Recordings made ready for a fit: checked against the robot, and inspected."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import cast

from ...recorder import Placement, distinctly_named
from .. import results
from ..diagnostics import next_placement, single_socket_diagnostics
from ..identification.data import as_flange_poses, check_distinct, check_left_out
from ..identification.robot import Robot
from .checking import checked
from .model_warnings import check_zeros, model_warnings
from .options import SolveOptions, UsageError
from .problem import CalibrationProblem
from .setting_right import mended

Recordings = (
    Placement | Sequence[Placement] | Mapping[str, Placement | Sequence[Placement]]
)
"""Placements; of several robots by the robots' names, or each with its own ``robot_name``."""


def problems_of(
    robot: Robot | Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
) -> dict[str, CalibrationProblem]:
    """Return what there is to fit by the robots' names; one robot alone has none."""
    if isinstance(robot, Mapping):
        return _problems_of_robots(robot, train, test, options)
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    training = as_list(train)
    held_out = as_list(test)
    placements = [*training, *held_out]
    check_left_out(distinctly_named(placements), options.leave_out)
    options.payloads.check(placements)
    problem = _prepare(robot, training, held_out, options)
    if not options.located:
        measurements = [measured for _, measured in problem.placements]
        lone_sockets = single_socket_diagnostics(
            measurements, problem.options.distances
        )
        problem = replace(problem, checks=(*problem.checks, *lone_sockets))
    return {"": problem}


def _problems_of_robots(
    robots: Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
) -> dict[str, CalibrationProblem]:
    """Return what there is to fit to several robots."""
    _check_robots(robots, options)
    training = _by_robot(robots, train)
    held_out = _by_robot(robots, test)
    placements = list(chain(*training.values(), *held_out.values()))
    check_left_out(placements, options.leave_out)
    options.payloads.check(placements)
    problems: dict[str, CalibrationProblem] = {}
    for name, robot in robots.items():
        if not training[name]:
            names = ", ".join(robots)
            raise UsageError(
                f"{name}: no placement to train on; the robots are {names}"
            )
        problem = _prepare(robot, training[name], held_out[name], options)
        problems[name] = replace(problem, name=name)
    # The same samples given to two arms would fit both, so refuse them.
    rows = chain.from_iterable(problem.placements for problem in problems.values())
    check_distinct([measured for _, measured in rows])
    return problems


def _check_robots(robots: Mapping[str, Robot], options: SolveOptions) -> None:
    """Refuse options that several robots cannot have."""
    if options.method != "auto":
        raise UsageError(
            "several robots: --method paper knows one, --method auto knows both"
        )
    for socket in options.located:
        if socket.frame == "base":
            raise UsageError(
                f"{socket.where}: the base of which robot? Write {next(iter(robots))}:base"
            )


def _by_robot(
    robots: Mapping[str, Robot], placements: Recordings
) -> dict[str, list[Placement]]:
    """Return each robot's placements: as given by name, or as each of them says."""
    by_robot: dict[str, list[Placement]] = {name: [] for name in robots}
    listing = ", ".join(robots)
    pairs: list[tuple[str | None, Placement]] = []
    if isinstance(placements, Mapping):
        for name, group in placements.items():
            pairs += [(name, placement) for placement in as_list(group)]
    else:
        pairs += [
            (placement.robot_name, placement) for placement in as_list(placements)
        ]
    for name, placement in pairs:
        where = placement.where
        if name is None:
            raise UsageError(
                f"{where}: which robot recorded it? Write NAME:{where}; the robots are {listing}"
            )
        if name not in by_robot:
            raise UsageError(
                f"{where}: of robot {name!r}, but the robots are {listing}"
            )
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
    check_zeros(robot, options)
    problem, done = mended(_measured(robot, train, test, options))
    place = None
    if any(measured.kind == "sockets" for _, measured in problem.placements):
        place = results.NextPlacement(text=next_placement(robot, problem.survey))
    checks = (*done, *problem.survey.diagnostics)
    return replace(problem, checks=checks, next_placement=place)


def _measured(
    robot: Robot, train: list[Placement], test: list[Placement], options: SolveOptions
) -> CalibrationProblem:
    """Return the checked placements to train and to test on, and what to warn of."""
    if not train:
        raise UsageError("no placement to train on; read some by mukca.read_placements")
    distinct = options.payloads.carried_by(distinctly_named([*train, *test]))
    if options.flange_poses:
        distinct = as_flange_poses(distinct)
    train, test = distinct[: len(train)], distinct[len(train) :]
    paths = {p.path.resolve() for p in train if p.path is not None}
    trained_on = [p for p in test if p.path is not None and p.path.resolve() in paths]
    warnings = [f"{p.path}: trained on, so left out of the test" for p in trained_on]
    measured = [placement for placement in distinct if placement.kind == "points"]
    if measured and options.method == "paper":
        raise UsageError(
            f"{measured[0].where}: measured points; --method paper knows sockets only, "
            "--method auto knows both"
        )
    training, errors = checked(robot, train, options)
    held_out, errors_held_out = checked(
        robot, [p for p in test if p not in trained_on], options
    )
    if not training:
        raise next(
            iter(errors), UsageError("--leave-out: no placement is left to train on")
        )
    warnings += [f"{error}; it is left out" for error in (*errors, *errors_held_out)]
    data = (*training, *held_out)
    check_distinct(data)
    warnings += model_warnings(robot, data, options)
    warnings += chain.from_iterable(m.warnings for m in data)
    return CalibrationProblem(
        robot,
        training,
        options.load,
        options=options,
        test=held_out,
        warnings=tuple(warnings),
    )


def as_list(placements: object) -> list[Placement]:
    """Return placements as a list; one stands for itself, and a path is refused."""
    several = isinstance(placements, Iterable) and not isinstance(placements, str)
    items: list[object] = (
        list(cast("Iterable[object]", placements)) if several else [placements]
    )
    checked_items: list[Placement] = []
    for item in items:
        if not isinstance(item, Placement):
            raise UsageError(
                f"{item!r:.60}: no placement; read it by mukca.read_placements"
            )
        checked_items.append(item)
    return checked_items

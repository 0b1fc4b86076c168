"""Recordings made ready for a fit: checked against the robot, and by a table of checks."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import cast

from ...recorder import Placement, distinctly_named
from ..identification.data import as_flange_poses, check_distinct
from ..identification.robot import Robot
from .checking import checked
from .model_warnings import check_zeros, model_warnings
from .options import SolveOptions, UsageError
from .problem import CalibrationProblem

Recordings = (
    Placement | Sequence[Placement] | Mapping[str, Placement | Sequence[Placement]]
)
"""Placements; of several robots by the robots' names, or each with its own ``robot_name``."""

Check = Callable[[CalibrationProblem], CalibrationProblem]
"""A look at measurements before their fit: it adds findings, or returns other measurements."""


def problem_of(
    robot: Robot,
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
    checks: Sequence[Check],
    name: str = "",
) -> CalibrationProblem:
    """Return what there is to fit to one robot, once each check has looked at it."""
    if isinstance(train, Mapping) or isinstance(test, Mapping):
        raise UsageError("placements by the names of robots need robots by name, too")
    training = as_list(train)
    held_out = as_list(test)
    if not name:
        options.check_names(distinctly_named([*training, *held_out]))
    if not isinstance(robot, Robot):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise UsageError(f"{robot!r:.60}: no robot; load it by mukca.load_robot")
    check_zeros(robot, options)
    problem = _measured(robot, training, held_out, options)
    problem = replace(problem, name=name)
    for check in checks:
        problem = check(problem)
    return problem


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
    warnings += model_warnings(robot, options)
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

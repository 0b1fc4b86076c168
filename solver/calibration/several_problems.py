"""The problems of calibrations: of one robot alone, or of several by their names."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from ...recorder import Placement
from ..bases import base_name
from ..diagnostics import OF_JOINTS
from ..identification.data import LimitsError, SocketAt, check_distinct
from ..identification.robot import Robot
from ..tables import in_placements
from .fit import CalibrationProblem
from .options import SolveOptions, UsageError
from .preparation import Recordings, as_list, problem_of
from .tables import CHECKS

UNEXPLAINED = "model"
"""Code of samples that no cause explains."""


def problems_of(
    robot: Robot | Mapping[str, Robot],
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
) -> dict[str, CalibrationProblem]:
    """Return what there is to fit by the robots' names; one robot alone has none."""
    if isinstance(robot, Mapping):
        return problems_of_robots(robot, train, test, options)
    return {"": problem_of(robot, train, test, options, CHECKS)}


def reaching(robot: Robot, positions: np.ndarray) -> Robot:
    """Return the robot whose limits hold joint positions, too, shape (N, m) [rad]."""
    columns = dict(zip(robot.joint_names, positions.T.tolist(), strict=True))
    joints = list(robot.joints)
    for i, joint in enumerate(joints):
        ends = [joint.lower, joint.upper, *columns.get(joint.name, ())]
        joints[i] = replace(joint, lower=min(ends), upper=max(ends))
    return replace(robot, joints=tuple(joints))


def problem_in_any_reach(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> CalibrationProblem:
    """Return recordings that were looked at.

    Readings outside of the limits are those of wrong columns, where these explain all samples.
    """
    try:
        return problem_of(robot, placements, (), options, CHECKS)
    except LimitsError as error:
        ordered = [p.for_joints(robot.joint_names).positions for p in placements]
        positions = np.concatenate(ordered)
        if np.abs(positions).max() > 2 * np.pi:  # in another unit
            raise
        wider = reaching(robot, positions)
        problem = problem_of(wider, placements, (), options, CHECKS)
        codes = {finding.code for finding in problem.checks}
        if not codes.intersection(OF_JOINTS) or UNEXPLAINED in codes:
            raise error from None
        return replace(problem, warnings=(str(error), *problem.warnings))


def located_in_training(
    problems: Mapping[str, CalibrationProblem], options: SolveOptions
) -> list[SocketAt]:
    """Return coordinates of sockets in the placements of several robots to train on."""
    bases: dict[str, list[str]] = {"train": [], "test": []}
    for role, measured in chain(*(problem.placements for problem in problems.values())):
        bases[role].append(base_name(measured, len(problems)))
    return in_placements(options.located, bases["train"], bases["test"])


def problems_of_robots(
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
    options.check_names(placements)
    problems: dict[str, CalibrationProblem] = {}
    for name, robot in robots.items():
        if not training[name]:
            names = ", ".join(robots)
            raise UsageError(
                f"{name}: no placement to train on; the robots are {names}"
            )
        problems[name] = problem_of(
            robot, training[name], held_out[name], options, CHECKS, name
        )
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
    groups = placements if isinstance(placements, Mapping) else {None: placements}
    pairs = [(g, p) for g, recordings in groups.items() for p in as_list(recordings)]
    for group, placement in pairs:
        name = placement.robot_name if group is None else group
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

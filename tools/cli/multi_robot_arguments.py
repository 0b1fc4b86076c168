"""Arguments of a command that may have several robots: each by a name, and whose placements."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...solver.calibration import UsageError
from .robot_arguments import placements_of, split_test

if TYPE_CHECKING:
    from ...recorder.dataset import Placement
    from ...solver.robot import Robot


def robots_of(arguments: argparse.Namespace) -> "Robot | dict[str, Robot]":
    """Return the robot that arguments name; by names where there are several.

    Raises:
        UsageError: A robot without a name beside others, or a name that is there twice.
        ModelError: No such robot, link, or chain.
    """
    from ...solver.robot import BALL_LINK, load_robot

    given: list[str] = arguments.robot
    if len(given) == 1:
        name, _, alone = given[0].partition("=")
        if alone and name.isidentifier():
            raise UsageError(f"--robot {given[0]}: one robot needs no name; write --robot {alone}")
        return load_robot(
            given[0],
            base=_only(arguments.base, "base"),
            tip=_only(arguments.tip, "tip") or BALL_LINK,
            flange=_only(arguments.flange, "flange"),
            ball=arguments.ball,
        )
    named: dict[str, str] = {}
    for words in given:
        name, _, robot = words.partition("=")
        if not robot or not name.replace("_", "").replace("-", "").isalnum():
            raise UsageError(
                f"--robot {words}: of several robots each needs a name, as in --robot left=panda"
            )
        if name in named:
            raise UsageError(f"--robot {words}: two robots are called {name!r}")
        named[name] = robot
    base, tip, flange = (
        _by_name(getattr(arguments, key), key, named) for key in ("base", "tip", "flange")
    )
    shared = len(set(named.values())) < len(named) and any(flange.values())
    return {
        name: load_robot(
            robot,
            base=base[name],
            tip=tip[name] or (f"{name}_{BALL_LINK}" if shared and flange[name] else BALL_LINK),
            flange=flange[name],
            ball=arguments.ball if flange[name] else None,
        )
        for name, robot in named.items()
    }


def _only(given: Sequence[str] | None, key: str) -> str | None:
    """Return the last of the values of an option of one robot."""
    if given and len(given) > 1:
        raise UsageError(f"--{key} {given[1]}: one robot has one {key}")
    return given[0] if given else None


def _by_name(
    given: Sequence[str] | None, key: str, robots: dict[str, str]
) -> dict[str, str | None]:
    """Return an option's value for each robot; one without a name is for all of them."""
    by_name: dict[str, str | None] = dict.fromkeys(robots)
    for words in given or ():
        name, _, link = words.partition("=")
        if link and name not in robots:
            known = ", ".join(robots)
            raise UsageError(f"--{key} {words}: no robot is called {name!r}; there are: {known}")
        by_name |= {name: link} if link else dict.fromkeys(robots, words)
    return by_name


def split_by_robot(
    train: Sequence[Path], test: Sequence[Path], robots: "dict[str, Robot]"
) -> tuple[dict[str, list[Path]], dict[str, list[Path]], list[str]]:
    """Return whose each path is, ``NAME:PATH`` or as its recording says; and what was left out.

    Raises:
        UsageError: A path of no robot, or one to train on that is named for the test too.
    """
    trained, tested = _owned(train, robots), _owned(test, robots)
    left_out: list[str] = []
    for name in robots:
        tested[name], lines = split_test(trained[name], tested[name])
        left_out += lines
    return trained, tested, left_out


def _owned(paths: Sequence[Path], robots: "dict[str, Robot]") -> dict[str, list[Path]]:
    from ...recorder import METADATA, find_placements, read_metadata

    owned: dict[str, list[Path]] = {name: [] for name in robots}
    for path in paths:
        name, _, rest = str(path).partition(":")
        if rest and name in robots:
            owned[name].append(Path(rest))
            continue
        if rest and not path.exists() and Path(rest).exists():
            raise UsageError(f"{path}: no robot is called {name!r}; there are: {', '.join(robots)}")
        for folder in find_placements([path]):
            owner = read_metadata(folder / METADATA).get("robot_name")
            if owner not in robots:
                known, example = ", ".join(robots), next(iter(robots))
                said = f"of robot {owner!r}" if owner else "whose is it?"
                raise UsageError(
                    f"{folder}: {said}; write {example}:{folder}; the robots are {known}"
                )
            owned[owner].append(folder)
    return owned


def placements_by_robot(paths: dict[str, list[Path]]) -> "dict[str, list[Placement]]":
    """Read the placements of each robot."""
    return {name: placements_of(own) for name, own in paths.items() if own}

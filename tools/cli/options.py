"""Options that several verbs have: output, payload, robots, tables, and workers."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...solver import results
from ...solver.calibration import UsageError
from ...solver.identification import robot as robots
from .. import parallel
from .arguments import Options

DISTANCES = (0.01, 3.0)
"""Range of a distance between sockets [m]: they hold balls side by side, in an arm's reach."""


class RobotOptions(Options, group="robot"):
    """Options of one robot: its model, and the two ends of its chain."""

    robot: str
    base: str | None = None
    tip: str = "ball_link"
    flange: str | None = None
    ball: tuple[float, float, float] | None = None

    def load_robot(self) -> "robots.Robot":
        """Read the model of the robot; a ModelError names a missing link."""
        return robots.load_robot(**self.model_arguments())

    def model_arguments(self) -> dict[str, Any]:
        """Arguments of :func:`mukca.load_robot`, by their names."""
        return {name: getattr(self, name) for name in RobotOptions.__annotations__}


class RobotsOptions(Options, group="robot"):
    """Options of one robot, or of several by their names."""

    robot: Sequence[str]
    base: Sequence[str] = ()
    tip: Sequence[str] = ()
    flange: Sequence[str] = ()
    ball: Sequence[str] = ()

    def load_robots(self) -> "dict[str, robots.Robot]":
        """Read the models of the robots by their names; the name of a single robot is empty."""
        by_name = _named(self.robot)
        bases = _by_name(self.base, "base", by_name)
        tips = _by_name(self.tip, "tip", by_name)
        flanges = _by_name(self.flange, "flange", by_name)
        balls = _balls(self.ball, by_name)
        twice = len(set(by_name.values())) < len(by_name)
        models: dict[str, robots.Robot] = {}
        for name, robot in by_name.items():
            flange = flanges[name]
            prefix = f"{name}_" if twice and flange else ""
            models[name] = robots.load_robot(
                robot,
                base=bases[name],
                tip=tips[name] or f"{prefix}{robots.BALL_LINK}",
                flange=flange,
                ball=balls[name] if flange or not name else None,
            )
        return models


class TableOptions(Options, group="tables of other programs"):
    """Options that say what the columns of a table are, where its header does not."""

    columns: Sequence[str] = ()
    on: str = ""

    @property
    def table(self) -> dict[str, Any]:
        """Arguments of :func:`mukca.read_placements` on tables, by their names."""
        return {"columns": self.columns, "on": self.on}


def _named(words_given: Sequence[str]) -> dict[str, str]:
    """Robots by their names; a single one has none."""
    by_name: dict[str, str] = {}
    for words in words_given:
        name, _, robot = words.partition("=")
        example = ""
        if len(words_given) == 1 and robot and name.isidentifier():
            example = f"one robot needs no name; write --robot {robot}"
        elif len(words_given) == 1:
            return {"": words}
        elif not robot or not name.replace("_", "").replace("-", "").isalnum():
            example = "of several robots each needs a name, as in --robot left=panda"
        elif name in by_name:
            example = f"two robots are called {name!r}"
        if example:
            raise UsageError(f"--robot {words}: {example}")
        by_name[name] = robot
    return by_name


def _by_name(
    items: Sequence[str], key: str, sources: Mapping[str, str]
) -> dict[str, str | None]:
    """Value of an option for each robot; one without a name is for all of them."""
    by_name: dict[str, str | None] = dict.fromkeys(sources)
    if "" in sources and len(items) > 1:
        raise UsageError(f"--{key} {items[1]}: one robot has one {key}")
    for words in items:
        name, _, link = ("", "", "") if "" in sources else words.partition("=")
        if link and name not in sources:
            names = ", ".join(sources)
            raise UsageError(
                f"--{key} {words}: no robot is called {name!r}; there are: {names}"
            )
        by_name |= {name: link} if link else dict.fromkeys(sources, words)
    return by_name


def _balls(
    words: Sequence[str], sources: Mapping[str, str]
) -> dict[str, list[float] | None]:
    """Balls of the robots, from three words each; one without a name is for all of them [m]."""
    by_name: dict[str, list[float] | None] = dict.fromkeys(sources)
    for k in range(0, len(words), 3):
        name, _, x = words[k].rpartition("=")
        given = "--ball " + " ".join(words[k : k + 3])
        if name and ("" in sources or name not in sources):
            there = "one robot needs no name" if "" in sources else ", ".join(sources)
            raise UsageError(f"{given}: no robot is called {name!r}; {there}")
        try:
            place = [float(word) for word in (x, *words[k + 1 : k + 3])]
        except ValueError:
            raise UsageError(f"{given}: give three numbers, in metres") from None
        by_name |= {name: place} if name else dict.fromkeys(sources, place)
    return by_name


class WorkerOptions(Options, group="workers"):
    """Options of a verb whose work is shared out."""

    processes: int = os.cpu_count() or 1
    cluster: str | None = None

    @property
    def workers(self) -> "parallel.Workers":
        """Workers that were asked for."""
        return parallel.Workers(self.processes, self.cluster)


class JsonOption(Options, group="output"):
    """Option of each verb that scripts read."""

    json: bool = False


class PayloadOptions(Options):
    """Options of the payload."""

    payload: float | None = None
    payload_at: tuple[float, float, float] = (0, 0, 0)

    @property
    def carried(self) -> tuple[float, tuple[float, float, float]] | None:
        """Mass [kg] and centre [m] of the payload; None for that of the recordings."""
        return None if self.payload is None else (self.payload, self.payload_at)


class OutputOptions(JsonOption, group="output"):
    """Options of a verb that writes files."""

    out: Path | None = None
    force: bool = False

    def check_out(self) -> None:
        """Refuse a folder whose results would be overwritten, before any work."""
        if self.out:
            results.refuse_existing(self.out, force=self.force)


class DetailsOptions(OutputOptions):
    """Options of a verb whose screen is its answer alone."""

    details: bool = False

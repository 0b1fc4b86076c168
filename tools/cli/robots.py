"""Options of a robot or several, their placements, and the workers of a verb."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from ... import recorder
from ...solver import tables
from ...solver.calibration import SolveOptions, UsageError
from ...solver.identification import data
from ...solver.identification import robot as robots
from .. import parallel
from .arguments import Options, option

DISTANCES = (0.01, 3.0)
"""Range of a distance between sockets [m]: they hold balls side by side, in an arm's reach."""
WINDOWS = (0.02, 10.0)
"""Range of the time that a sample averages [s]."""
SPREADS = (1e-9, 0.1)
"""Range of the standard deviation of an arm that is still [rad]."""


class RobotOptions(Options, group="robot"):
    """Options of one robot: its model, and the two ends of its chain."""

    robot: str = option(..., "a shipped robot's name, or a URDF file", "R")
    base: str | None = option(None, "the base link (default: the root)", "LINK")
    tip: str = option("ball_link", "the ball's link", "LINK")
    flange: str | None = option(
        None, "for a URDF without a ball: the link that carries it", "LINK"
    )
    ball: tuple[float, float, float] | None = option(
        None,
        "with --flange: the ball's centre in that link's frame, in metres; points and poses do "
        "without",
        ("X", "Y", "Z"),
    )

    def load_robot(self) -> "robots.Robot":
        """Read the model of the robot; a ModelError names a missing link."""
        return robots.load_robot(**self.model_arguments())

    def model_arguments(self) -> dict[str, Any]:
        """Arguments of :func:`mukca.load_robot`, by their names."""
        return {name: getattr(self, name) for name in RobotOptions.__annotations__}


class RobotsOptions(Options, group="robot"):
    """Options of one robot, or of several by their names."""

    robot: Sequence[str] = option(
        ...,
        "a shipped robot's name, or a URDF file; several as NAME=R, each by an option of its own",
        "R",
        repeated=True,
    )
    base: Sequence[str] = option(
        (),
        "the base link (default: the root; of several robots NAME=LINK)",
        "LINK",
        repeated=True,
    )
    tip: Sequence[str] = option(
        (),
        "the ball's link (default: ball_link; of several robots NAME=LINK)",
        "LINK",
        repeated=True,
    )
    flange: Sequence[str] = option(
        (),
        "for a URDF without a ball: the link that carries it; of several robots NAME=LINK",
        "LINK",
        repeated=True,
    )
    ball: Sequence[str] = option(
        (),
        "with --flange: the ball's centre in that link's frame, in metres; points and poses do "
        "without (of several robots NAME=X Y Z)",
        ("X", "Y", "Z"),
    )

    def load_robots(self) -> "dict[str, robots.Robot]":
        """Read the models of the robots by their names; the name of a single robot is empty."""
        by_name = _named(self.robot)
        base = _by_name(self.base, "base", by_name)
        tip = _by_name(self.tip, "tip", by_name)
        flange = _by_name(self.flange, "flange", by_name)
        balls = _balls(self.ball, by_name)
        ball = robots.BALL_LINK
        twice = len(set(by_name.values())) < len(by_name)
        return {
            name: robots.load_robot(
                robot,
                base=base[name],
                tip=tip[name] or (f"{name}_{ball}" if twice and flange[name] else ball),
                flange=flange[name],
                ball=balls[name] if flange[name] or not name else None,
            )
            for name, robot in by_name.items()
        }


class TableOptions(Options, group="tables of other programs"):
    """Options that say what the columns of a table are, where its header does not."""

    columns: Sequence[str] = option(
        (),
        "what the columns are, as in 'q=joint_1..6 [deg]' 'x=x_t+x_dif [mm]', by number as in "
        "'q=1..6 [deg]' 'x=7 [mm]'; also y, z, qx, .., roll, .., socket, effort",
        "NAME=COLUMNS",
    )
    on: str = option(
        "",
        "column by which the rows of two files JOINTS.csv+POINTS.csv belong together (default: "
        "their order)",
        "COLUMN",
    )

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


class _Placement(NamedTuple):
    """A placement that a path stands for."""

    path: Path
    folder: Path
    """The same without links."""
    is_named: bool
    """True where the path is its own, and not that of a folder of placements."""


def _placements(paths: Sequence[Path]) -> list[_Placement]:
    """Return the placements that paths stand for."""
    placements: list[_Placement] = []
    for path in paths:
        for folder in recorder.find_placements([path]):
            placements.append(_Placement(folder, folder.resolve(), folder == path))
    return placements


def split_by_robot(
    train: Sequence[Path], test: Sequence[Path], sources: Mapping[str, object]
) -> tuple[dict[str, list[Path]], dict[str, list[Path]], list[str]]:
    """Return placements to train on and to test on by robot, and a line for each left out.

    A path is ``NAME:PATH`` where there are several robots, or the recording names the robot; one of
    no robot, or named both to train on and for the test, is a UsageError. A placement that is named
    counts before one that a folder stands for.
    """
    training = paths_by_robot(train, sources)
    test_folders = paths_by_robot(test, sources)
    tested: dict[str, list[Path]] = {name: [] for name in sources}
    held_out: list[str] = []
    trained: list[str] = []
    unread: list[str] = []
    for name, paths in test_folders.items():
        unread += recorder.unread(paths)
        tests = _placements(paths)
        named = {test.folder for test in tests if test.is_named}
        placements = _placements(training[name])
        remaining = [p for p in placements if p.is_named or p.folder not in named]
        if placements and not remaining:
            raise UsageError(f"{paths[0]}: held out, so nothing is left to train on")
        if len(remaining) < len(placements):
            unread += recorder.unread(training[name])
            training[name] = [placement.path for placement in remaining]
            held_out += [p.path.name for p in placements if p not in remaining]
        folders_trained = {placement.folder for placement in remaining}
        for placement in tests:
            if placement.folder not in folders_trained:
                tested[name].append(placement.path)
            elif placement.is_named:
                raise UsageError(
                    f"{placement.path}: trained on, so it cannot be held out as well"
                )
            else:
                trained.append(placement.path.name)
    lines = {
        "held out, so left out of the training": held_out,
        "trained on, so left out of the test": trained,
    }
    remarks = [f"{', '.join(names)}: {why}" for why, names in lines.items() if names]
    return training, tested, [*remarks, *dict.fromkeys(unread)]


def paths_by_robot(
    paths: Sequence[Path], sources: Mapping[str, object]
) -> dict[str, list[Path]]:
    """Return placements by robot, as :func:`split_by_robot` reads them."""
    if "" in sources:
        return {"": list(paths)}
    by_robot: dict[str, list[Path]] = {name: [] for name in sources}
    for path in paths:
        name, _, path_after_name = str(path).partition(":")
        if path_after_name and name in sources:
            by_robot[name].append(Path(path_after_name))
            continue
        if path_after_name and not path.exists() and Path(path_after_name).exists():
            raise UsageError(
                f"{path}: no robot is called {name!r}; there are: {', '.join(sources)}"
            )
        for folder in recorder.find_placements([path]):
            owner = str(
                recorder.read_metadata(folder / recorder.METADATA).get("robot_name")
                or ""
            )
            if owner not in sources:
                names = ", ".join(sources)
                example = next(iter(sources))
                problem = f"of robot {owner!r}" if owner else "which robot recorded it?"
                raise UsageError(
                    f"{folder}: {problem}; write {example}:{folder}; the robots are {names}"
                )
            by_robot[owner].append(folder)
    return by_robot


def read_data(
    paths: Sequence[Path],
    settings: SolveOptions,
    table: Mapping[str, Any] | None = None,
) -> "list[recorder.Placement]":
    """Read all placements that paths stand for, without what is left out by hand."""
    placements = recorder.read_placements(
        *paths, as_recorded=settings.as_recorded, **(table or {})
    )
    tables.check_left_out(placements, settings.leave_out)
    placements = tables.without(placements, settings.leave_out)
    settings.payloads.check(placements)
    if not placements:
        raise UsageError("--leave-out: no placement is left")
    return data.as_flange_poses(placements) if settings.flange_poses else placements


class WorkerOptions(Options, group="workers"):
    """Options of a verb whose work is shared out."""

    processes: int = option(
        os.cpu_count() or 1,
        "number of processes (default: all cores)",
        "N",
        between=(1, 4096),
    )
    cluster: str | None = option(
        None,
        "address of a Dask scheduler, whose workers do the work; needs mukca[cluster]",
        "ADDRESS",
        unless="processes",
    )

    @property
    def workers(self) -> "parallel.Workers":
        """Workers that were asked for."""
        return parallel.Workers(self.processes, self.cluster)

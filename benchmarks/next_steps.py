"""Where the next steps of an answer lead, followed literally to their end.

    python benchmarks/next_steps.py [--runs 40] [--kind NAME ...]

A run is a case of ``verdicts.py`` with three placements or two, written to files. The first command
trains on all but the last, which is recorded where a step asks for another placement. ``MEASURED``
is a reading of the true distance with a caliper's error, ``MM`` what the arm's data sheet says. A
run ends without a next step, or where one only looks or commands; it is a circle where a command
comes again. Counted are: ends in USE IT, circles, dead ends, runs whose file is truly worse at the
end than at the start, and by how much the error is larger than the step's forecast.
"""

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import json
import shlex
from collections.abc import Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory

import numpy as np
from verdicts import (
    CALIPER_DEVIATION,
    PAIRS,
    SHARED,
    World,
    case,
    workspace_error,
    world,
)

import mukca
from mukca.recorder import Placement, set_distance, write_holes
from mukca.solver.identification.robot import workspace
from mukca.tools.cli import WorkerOptions, add_options, main, read_options

KINDS = (
    "sound",
    "distance wrong",
    "one length",
    "another version",
    "all scaled",
    "zero",
    "base moved",
    "base between",
    "drift",
    "ball in one",
    "zero elsewhere",
    "ball elsewhere",
)
"""Mistakes that files can hold, of which ``verdicts.py`` has the sizes."""
MOST = 6
"""Steps that are followed at most."""
PLACES = "recordings"


@dataclass
class Run:
    """A run of commands, and what came of each."""

    name: str
    commands: list[str] = field(default_factory=list[str])
    errors: list[float] = field(default_factory=list[float])
    """True error of distances after each solve, by ``calibrated.urdf`` [m]."""
    forecasts: list[float] = field(default_factory=list[float])
    """The error after a step over its forecast."""
    use: bool = False
    end: str = "nothing is left to do"


def followed(i: int) -> Run:
    """Spoil case i, solve, and follow the next steps."""
    name, kind, size = case(i)
    one = world(i)
    kind.spoil(one, size)
    run = Run(f"{i} {name} ({one.robot.name} {size:g})")
    with TemporaryDirectory() as folder, chdir(folder):
        _follow(one, run)
    return run


def _follow(one: World, run: Run) -> None:
    """Begin with all placements but the last, and do what each answer asks for."""
    Path("robot.urdf").write_bytes(one.robot.text.data)
    *first, spare = one.placements
    folders = [_written(placement, f"{PLACES}/{placement.name}") for placement in first]
    words = ["mukca", "solve", *folders, "--robot", "robot.urdf"]
    if one.settings.get("distance") is not None:
        words += ["--distance", str(one.settings["distance"])]
    expected = None
    for number in range(MOST):
        step = _solved(one, run, words, f"out{number}")
        if expected:
            run.forecasts.append(run.errors[-1] / expected)
        if step is None:
            return
        expected = step.get("after")
        following = shlex.split(step["command"])
        verb = following[1]
        if verb == "record" and Path(PLACES, "another").is_dir():
            run.end = "no placement is left to record"
            return
        if verb == "record":
            out = _written(spare, following[following.index("--out") + 1])
            following = _with_placement(words, out, step["text"])
        elif verb != "solve":
            run.end = f"mukca {verb}"
            return
        words = [_typed(word, one) for word in following]
        if shlex.join(words) in run.commands:
            run.end = "circle"
            return
    run.end = "no end"


def _solved(one: World, run: Run, words: Sequence[str], out: str) -> dict | None:
    """Solve, keep what came of it, and return the next step."""
    words = [word for word in words if word != "calibrated-again"]
    words = [word for word in words if word != "--out"]
    run.commands.append(shlex.join(words))
    said = StringIO()
    with redirect_stdout(said), redirect_stderr(said):
        status = main([*words[1:], "--out", out])
    if status not in (0, 1, 3):
        run.end = f"refused: {said.getvalue()[-200:]}"
        return None
    report = json.loads(Path(out, "report.json").read_text())
    calibration = mukca.load_calibration(Path(out, "calibration.json"))
    ball = calibration.calibrated.geometric_ball
    q = workspace(one.robot, 2 * PAIRS)
    run.errors.append(workspace_error(one.truth, ball, q))
    run.use = bool(report["verdict"]["use"])
    return next(iter(report.get("todo", [])), None)


def _written(placement: Placement, folder: str) -> str:
    """Write a placement's files to a folder that is made for it."""
    write_holes(placement, Path(folder))
    if placement.distance is not None:
        set_distance(Path(folder), placement.distance)
    return folder


def _with_placement(words: Sequence[str], folder: str, text: str) -> list[str]:
    """Return the last solve with another placement, or with it in place of the one named."""
    again = text.removeprefix("Record ").partition(" again")[0]
    rmtree(Path(PLACES, again), ignore_errors=True)
    kept = [word for word in words if Path(word).name != again]
    return kept if PLACES in kept else [*kept[:2], folder, *kept[2:]]


def _typed(word: str, one: World) -> str:
    """Return what a person types for a word that stands for a figure."""
    if word == "MEASURED":
        reading = one.placements[-1].distance or 0.05
        return f"{reading + CALIPER_DEVIATION * one.generator.normal():.6f}"
    return "0.1" if word == "MM" else word


def summary(runs: Sequence[Run]) -> list[str]:
    """Return what the runs came to, a line each, then the counts."""
    lines: list[str] = []
    for run in runs:
        errors = " > ".join(f"{1e3 * error:.2f}" for error in run.errors)
        use = "USE IT" if run.use else "not used"
        lines.append(f"{run.name}: {errors} mm, {use}; {run.end}")
    solved = [run for run in runs if run.errors]
    worse = sum(run.errors[-1] > 1.05 * run.errors[0] for run in solved)
    ends = [run.end.partition(":")[0] for run in runs]
    counts = ", ".join(f"{ends.count(end)} {end}" for end in dict.fromkeys(ends))
    forecasts = [ratio for run in runs for ratio in run.forecasts]
    typical = f"{np.median(forecasts):.2f}" if forecasts else "-"
    return [
        *lines,
        f"{len(runs)} runs: {sum(run.use for run in runs)} end in USE IT; {counts}; truly worse at "
        f"the end {worse}; error over forecast, median of {len(forecasts)}: {typical}",
    ]


def run_benchmark() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--kind", nargs="+", default=KINDS, help="these kinds alone")
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    numbers = range(0, 40 * len(KINDS) * 4, 2)
    cases = [i for i in numbers if case(i)[0] in arguments.kind]
    simulated = [i for i in cases if i % 16 not in (6, 7) or not SHARED.is_dir()]
    runs = read_options(arguments).workers.map(followed, simulated[: arguments.runs])
    print("\n".join(summary(runs)), flush=True)


if __name__ == "__main__":
    run_benchmark()

"""The paper's experiments on several simulated arms, and how fast they run.

    python benchmarks/insertion.py [--arms 1 2 3 4 5 2920]

The arms are those of seeds 1 to 5 and the demo's, whatever they turn out to be. Each is recorded at
four placements and calibrated by ``mukca solve``; its exported URDF goes to the controller. Physics
and control run in one thread; the ratio is simulated time against processor time.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import contextlib
import io
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from mukca.recorder import write_holes
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.cli import main as mukca
from mukca.tools.experiments import Drawing, Insertions
from mukca.tools.experiments.motion import ROWS_PER_SECOND, Cell
from mukca.tools.experiments.runs import record_placements
from mukca.tools.experiments.scene import urdf_of
from mukca.tools.experiments.tasks import (
    drawing_results,
    insert_at_centre,
    insert_on_cross,
    insertion_results,
    retrace,
)
from mukca.tools.parallel import Workers
from mukca.tools.simulation import DEMO_SEED, demo_arm

Insert = Callable[[Cell, int, int], Iterator[Any]]
SEED = 0
"""Of recordings, teaching and starts."""
INSERTIONS: tuple[tuple[str, float, Insert, int], ...] = (
    ("nominal", 0.016, insert_at_centre, 20),
    ("nominal", 0.0104, insert_at_centre, 20),
    ("nominal", 0.0104, insert_on_cross, 24),
    ("calibrated", 0.0104, insert_at_centre, 20),
    ("calibrated", 0.0104, insert_on_cross, 24),
    ("true", 0.0104, insert_at_centre, 20),
)
"""Model, diameter of the hole [m], where it stands, and how many trials."""
LINES = 6
"""Retracings of the drawing."""


def models_of(arm: int) -> dict[str, bytes]:
    """Return what the controller may be given; the calibrated one as a user would get it."""
    nominal, true = demo_arm(arm, keep_size=False)
    with tempfile.TemporaryDirectory() as folder:
        recordings, out = Path(folder) / "recordings", Path(folder) / "calibrated"
        for placement in record_placements(true, SEED):
            write_holes(placement, recordings / placement.name)
        words = ["solve", str(recordings), "--robot", "panda", "--out", str(out)]
        with contextlib.redirect_stdout(io.StringIO()) as said:
            # Such arms differ in size by more than real ones, so the verdict is FAIL.
            mukca(words)
        if not (out / "calibrated.urdf").exists():
            raise SystemExit(
                f"arm {arm}: mukca {' '.join(words)} failed: {said.getvalue()}"
            )
        calibrated = (out / "calibrated.urdf").read_bytes()
    return {
        "nominal": nominal.text.data,
        "calibrated": calibrated,
        "true": urdf_of(true),
    }


@dataclass(frozen=True)
class Run:
    """Trials of one arm with one model, and what they cost."""

    trials: list[Any]
    spent: float
    """Processor time [s]."""

    @property
    def simulated(self) -> float:
        """Time in the simulation [s]."""
        return sum(len(trial.log.q) for trial in self.trials) / ROWS_PER_SECOND


def run(trials: Iterator[Any]) -> Run:
    begin = time.process_time()
    done = list(trials)
    return Run(done, time.process_time() - begin)


def inserted(models: dict[int, dict[str, bytes]], which: tuple[int, int]) -> Run:
    """Do one line of INSERTIONS with one arm."""
    i, arm = which
    word, hole, insert, count = INSERTIONS[i]
    true = demo_arm(arm, keep_size=False)[1]
    return run(insert(Cell(true, models[arm][word], hole), count, SEED))


def drawn(models: dict[int, dict[str, bytes]], which: tuple[str, int]) -> Run:
    """Let one arm draw with one model."""
    word, arm = which
    true = demo_arm(arm, keep_size=False)[1]
    return run(retrace(Cell(true, models[arm][word]), LINES, SEED))


def row(arm: str, name: str, count: str, figures: Drawing | Insertions) -> str:
    """Return a line of the table; lengths in mm, forces in N."""
    force, peak = figures.force, figures.peak_force
    elbows = np.degrees([one.elbow for one in figures.each])
    return (
        f"| {arm} | {name} | {count} | {1e3 * figures.tracking_error:.2f} "
        f"({1e3 * figures.max_tracking_error:.2f}) | {force.mean:.1f} "
        f"({force.min:.1f} to {force.max:.1f}) | {peak.mean:.1f} ({peak.max:.1f}) | "
        f"{elbows.min():.0f} to {elbows.max():.0f} |"
    )


def insertions(models: dict[int, dict[str, bytes]], workers: Workers) -> list[Run]:
    pieces = list(product(range(len(INSERTIONS)), models))
    runs = workers.map(partial(inserted, models), pieces)
    print(
        "| arm | model, hole | inserted | above the hole | force | peak force | elbow |"
    )
    print("|---|---|---|---|---|---|---|")
    for i, (word, hole, insert, _) in enumerate(INSERTIONS):
        place = "X, " if insert is insert_on_cross else ""
        name = f"{word}, {place}{1e3 * hole:g} mm"
        each = {
            str(arm): r.trials
            for (k, arm), r in zip(pieces, runs, strict=True)
            if k == i
        }
        each["all"] = [trial for trials in each.values() for trial in trials]
        for arm, trials in each.items():
            figures = insertion_results(trials)
            print(row(arm, name, f"{figures.inserted} of {len(trials)}", figures))
    return runs


def drawings(models: dict[int, dict[str, bytes]], workers: Workers) -> list[Run]:
    pieces = list(product(("nominal", "calibrated", "true"), models))
    runs = workers.map(partial(drawn, models), pieces)
    print("| arm | model | spread | off the figure | force | peak force | elbow |")
    print("|---|---|---|---|---|---|---|")
    for (word, arm), done in zip(pieces, runs, strict=True):
        figures = drawing_results(done.trials)
        spread = f"{1e3 * figures.spread:.2f} ({1e3 * figures.max_spread:.2f})"
        print(row(str(arm), word, spread, figures))
    return runs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--arms", type=int, nargs="+", default=[1, 2, 3, 4, 5, DEMO_SEED]
    )
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    arms, workers = arguments.arms, read_options(arguments).workers
    models = dict(zip(arms, workers.map(models_of, arms), strict=True))
    print(
        "Lengths in mm and forces in N, mean (largest) or mean (least to largest of the trials);"
    )
    print("elbow in degrees from straight up, at the start.")
    runs = [*insertions(models, workers), *drawings(models, workers)]
    simulated, spent = sum(r.simulated for r in runs), sum(r.spent for r in runs)
    print(
        f"{simulated:.0f} s simulated in {spent:.0f} s of one core: "
        f"{simulated / spent:.1f} times real time"
    )


if __name__ == "__main__":
    main()

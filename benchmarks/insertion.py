"""The paper's experiments on several simulated arms, and how fast they run.

    python benchmarks/insertion.py [--arms 1 2 3 4 5 2920]

The arms are those of seeds 1 to 5 and the demo's, whatever they turn out to be. Each is recorded at
four placements and calibrated by ``mukca solve``; its exported URDF goes to the controller. Physics
and control run in one thread; the ratio is simulated time against this process' own time.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import contextlib
import io
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mukca.recorder.convert import write_holes
from mukca.tools.cli import main as mukca
from mukca.tools.commands.demo import DEMO_SEED, demo_arm
from mukca.tools.experiments.cell import Cell, build_cell
from mukca.tools.experiments.drawing import retrace
from mukca.tools.experiments.insertion import Trial, insert_at_centre, insert_on_cross
from mukca.tools.experiments.models import record_placements
from mukca.tools.experiments.results import drawing_figures, insertion_figures
from mukca.tools.experiments.scene import TIME_STEP, urdf_of

Insert = Callable[[Cell, int, int], Iterator[Trial]]
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
            status = mukca(words)
        if status:
            raise SystemExit(f"arm {arm}: mukca {' '.join(words)} failed: {said.getvalue()}")
        calibrated = (out / "calibrated.urdf").read_bytes()
    return {"nominal": nominal.text.data, "calibrated": calibrated, "true": urdf_of(true)}


class Clock:
    """Adds up simulated time, and this process' own."""

    simulated = spent = 0.0

    def exhaust(self, trials: Iterator[Any]) -> list[Any]:
        """Run all trials."""
        begin = time.process_time()
        done = list(trials)
        self.spent += time.process_time() - begin
        self.simulated += sum(one.log.steps for one in done) * TIME_STEP
        return done


def row(arm: str, name: str, count: str, figures: dict[str, Any]) -> str:
    """Return a line of the table; lengths in mm, forces in N."""
    force, peak, each = figures["force"], figures["peak_force"], figures["each"]
    elbows = np.degrees([one["elbow"] for one in each])
    return (
        f"| {arm} | {name} | {count} | {1e3 * figures['tracking_error']:.2f} "
        f"({1e3 * figures['max_tracking_error']:.2f}) | {force['mean']:.1f} "
        f"({force['min']:.1f} to {force['max']:.1f}) | {peak['mean']:.1f} ({peak['max']:.1f}) | "
        f"{elbows.min():.0f} to {elbows.max():.0f} |"
    )


def insertions(arms: dict[int, dict[str, bytes]], clock: Clock) -> None:
    print("| arm | model, hole | inserted | above the hole | force | peak force | elbow |")
    print("|---|---|---|---|---|---|---|")
    for word, hole, insert, count in INSERTIONS:
        place = "X, " if insert is insert_on_cross else ""
        name = f"{word}, {place}{1e3 * hole:g} mm"
        pooled: list[Trial] = []
        for arm, models in arms.items():
            cell = build_cell(demo_arm(arm, keep_size=False)[1], models[word], hole)
            trials = clock.exhaust(insert(cell, count, SEED))
            figures = insertion_figures(trials)
            print(row(str(arm), name, f"{figures['inserted']} of {count}", figures), flush=True)
            pooled += trials
        figures = insertion_figures(pooled)
        print(row("all", name, f"{figures['inserted']} of {len(pooled)}", figures), flush=True)


def drawings(arms: dict[int, dict[str, bytes]], clock: Clock) -> None:
    print("| arm | model | spread | off the figure | force | peak force | elbow |")
    print("|---|---|---|---|---|---|---|")
    for word in ("nominal", "calibrated", "true"):
        for arm, models in arms.items():
            cell = build_cell(demo_arm(arm, keep_size=False)[1], models[word])
            figures = drawing_figures(clock.exhaust(retrace(cell, LINES, SEED)))
            spread = f"{1e3 * figures['spread']:.2f} ({1e3 * figures['max_spread']:.2f})"
            print(row(str(arm), word, spread, figures), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, nargs="+", default=[1, 2, 3, 4, 5, DEMO_SEED])
    arms = {arm: models_of(arm) for arm in parser.parse_args().arms}
    clock = Clock()
    print("Lengths in mm and forces in N, mean (largest) or mean (least to largest of the trials);")
    print("elbow in degrees from straight up, at the start.")
    insertions(arms, clock)
    drawings(arms, clock)
    print(
        f"{clock.simulated:.0f} s simulated in {clock.spent:.0f} s of one core: "
        f"{clock.simulated / clock.spent:.1f} times real time"
    )


if __name__ == "__main__":
    main()

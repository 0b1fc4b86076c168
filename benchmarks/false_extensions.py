"""How often is an extension kept that the arm does not have?

    python benchmarks/false_extensions.py [--arms 216] [--first 0]

Arms of all shipped robots in turn, rigid and without play, gears as even as can be: nothing but
their geometry is off, as far as real arms' is. Each is recorded at one place, 2 x 30 samples, and
calibrated with every extension as a candidate: compliance, tilt, transmission and play, with zeros
sought, too. Printed is each one that was kept, and the largest evidence for one that is not there.
"""

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import re
from collections import Counter

import numpy as np
from worlds import NOISE, TRANSLATION, TURN

from mukca.errors import NotConverged
from mukca.solver.identification import FitOptions, fit
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import (
    load_robot,
    shipped_robots,
)
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

ROUND = 24
"""Arms between two lines of progress."""


def notes_of(seed: int) -> tuple[str, tuple[str, ...]]:
    """Return the robot, and what became of each extension."""
    names = list(shipped_robots())
    nominal, generator = (
        load_robot(names[seed % len(names)]),
        np.random.default_rng([seed, 7]),
    )
    arm = perturb(nominal, generator, TRANSLATION, TURN)
    how = Imperfection(noise=generator.uniform(*NOISE))
    placement = record(
        arm, reachable_bases(arm, generator, 1)[0], generator, imperfection=how
    )
    try:
        posterior = fit(nominal, [measure(placement, nominal)], FitOptions(zeros=True))
    except NotConverged:
        return nominal.name, ("no model: the fit did not settle",)
    return nominal.name, posterior.notes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=216)
    parser.add_argument("--first", type=int, default=0)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    tried, kept, arms, most = Counter[str](), Counter[str](), set[int](), -np.inf
    workers, end = read_options(arguments).workers, arguments.first + arguments.arms
    for begin in range(arguments.first, end, ROUND):
        seeds = range(begin, min(begin + ROUND, end))
        for seed, (robot, notes) in zip(
            seeds, workers.map(notes_of, seeds), strict=True
        ):
            for note in notes:
                extension = note.partition(":")[0]
                tried[extension] += 1
                gain = re.search(r"log evidence ([+-][0-9.]+)", note)
                most = max(most, float(gain[1])) if gain else most
                if "kept" in note:
                    kept[extension] += 1
                    arms.add(seed)
                    print(f"arm {seed} ({robot}): {note}")
        print(
            f"{seeds.stop} arms, {len(arms)} with one kept, evidence to {most:+.1f}",
            flush=True,
        )
    for extension, count in tried.items():
        print(f"{extension}: kept on {kept[extension]} of {count} arms that have none")
    share = 100 * len(arms) / arguments.arms
    print(
        f"{len(arms)} of {arguments.arms} arms ({share:.1f} %); largest evidence {most:+.1f}"
    )


if __name__ == "__main__":
    main()

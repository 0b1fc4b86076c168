"""How often chance explains the difference of two calibrations of one simulated arm.

    python benchmarks/chance.py [--draws 20] [--kind rigid] [--seed 0]

For each draw an arm is recorded at four placements with a noisy seat, and calibrated by the first
two, then by the last two; it is rigid, or bends and turns unevenly as real arms do. The caliper's
error is the same in both. Stated: one in 20 is beyond chance, in the workspace and at placements.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from dataclasses import replace
from functools import partial

import numpy as np
from worlds import realistic_flaws

import mukca
from mukca.solver.calibration import differences
from mukca.solver.identification.data import CALIPER_DEVIATION, SEAT_DEVIATION, measure
from mukca.solver.results import Apart
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

ROBOTS = ("panda", "ur5e")


def draw(kind: str, seed: int) -> list[Apart | None]:
    """Return how far two calibrations are apart, in the workspace and at four placements."""
    robot, generator = mukca.load_robot(ROBOTS[seed % 2]), np.random.default_rng(seed)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    rigid = Imperfection(noise=1e-4)
    flaws = rigid if kind == "rigid" else realistic_flaws(robot, generator)
    bases = reachable_bases(arm, generator, 4)
    stated = bases[0].distance + generator.normal(0, CALIPER_DEVIATION)
    lengths = [base.distance + generator.normal(0, SEAT_DEVIATION) for base in bases]
    placements = [
        record(
            arm, replace(base, distance=d), generator, samples=20, imperfection=flaws
        )
        for base, d in zip(bases, lengths, strict=True)
    ]
    first, second = (
        mukca.calibrate(robot, part, distance=stated)
        for part in (placements[:2], placements[2:])
    )
    data = [measure(one, robot, stated) for one in placements]
    workspace, places = differences(first, second, data)
    return [workspace, *places]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--kind", choices=("rigid", "bending"), default="rigid")
    parser.add_argument("--seed", type=int, default=0)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.draws)
    rows = read_options(arguments).workers.map(partial(draw, arguments.kind), seeds)
    for name, columns in (("workspace", [0]), ("placements", [1, 2, 3, 4])):
        apart = [row[i] for row in rows for i in columns if row[i] is not None]
        beyond = sum(one.beyond_chance for one in apart)
        likely = np.mean([one.probability > 0.5 for one in apart])
        ratio = np.median([one.value / one.chance for one in apart])
        print(
            f"{name:11s} {beyond} of {len(apart)} beyond chance; {100 * likely:.0f} % (50) more "
            f"probable than a half; median {ratio:.2f} of the mean by chance"
        )


if __name__ == "__main__":
    main()

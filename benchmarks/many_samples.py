"""How time and memory grow with the number of samples, and of placements, by both methods.

    python benchmarks/many_samples.py [--most 50000]

Each figure comes from a process of its own, on one core. Time is that of the processor, stated per
sample, and as a ratio to that of the smallest recording in the same run: where it stays near 1 or
below, time is linear.
"""

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import resource
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np

from mukca.recorder import Placement, Sample
from mukca.solver.calibration import SolveOptions, fit_robots
from mukca.solver.identification.data import Measurement, measure
from mukca.solver.identification.model import Deflection
from mukca.solver.identification.robot import BallModel, Robot
from mukca.solver.results import Measurements
from mukca.tools.simulation import (
    Imperfection,
    demo_arm,
    demo_bases,
    reachable_bases,
    record,
)

GUIDED = 500
"""Configurations that are truly guided to in each socket; more are made beside them."""
SEAT_NOISE = 5e-5
BESIDE = 1e-3
"""How far from its configuration each sample is, in directions that leave the ball [rad]."""
BENDS = 5e-5
"""Compliance of each joint of the arm that is recorded at many places [rad/(N m)]."""


def one_placement(count: int) -> list[Measurement]:
    """Return a placement with so many samples in each of its two sockets."""
    nominal, arm = demo_arm()
    generator = np.random.default_rng(0)
    guided = record(arm, demo_bases()[0], generator, samples=min(count, GUIDED))
    return [measure(_again(arm, guided, count, generator), nominal)]


def _again(
    arm: Robot, placement: Placement, count: int, generator: np.random.Generator
) -> Placement:
    """Return a placement of so many samples beside the guided ones, each seated anew."""
    model, samples = BallModel(arm, []), []
    for socket in (0, 1):
        own = np.array([s.position for s in placement.samples if s.socket == socket])
        slopes = model.linearise(np.empty(0), own).by_joints
        inverse = np.linalg.pinv(slopes)
        rows = np.arange(count) % len(own)
        beside = generator.normal(0, BESIDE, (count, own.shape[1]))
        off = generator.normal(0, SEAT_NOISE, (count, 3))
        off -= (slopes[rows] @ beside[:, :, None])[:, :, 0]
        q = own[rows] + beside + (inverse[rows] @ off[:, :, None])[:, :, 0]
        samples += [Sample(tuple(position), socket) for position in q.tolist()]
    return replace(placement, samples=tuple(samples))


def many_placements(count: int) -> list[Measurement]:
    """Return so many placements of 2 x 30 samples, at four places in turn, of an arm that bends.

    So one extension has to prove itself where placements are left out, which takes fits.
    """
    nominal, arm = demo_arm()
    bends = Deflection(("compliance",), (np.full(len(arm.actuated), BENDS),))
    how = Imperfection(SEAT_NOISE, bends)
    generator = np.random.default_rng(0)
    bases = reachable_bases(arm, generator, 4)
    placements = [
        record(
            arm,
            replace(bases[i % 4], name=f"placement_{i}"),
            generator,
            imperfection=how,
        )
        for i in range(count)
    ]
    return [measure(placement, nominal) for placement in placements]


def fit(method: str, samples: int, placements: int) -> None:
    """Print time [s] and peak memory [MB] of a fit; run in a process of its own."""
    train = one_placement(samples) if samples else many_placements(placements)
    robot, _ = demo_arm()
    begin = time.process_time()
    auto = SolveOptions(type_prior=("none",))
    options = SolveOptions(method="paper") if method == "paper" else auto
    (result,) = fit_robots([Measurements(robot, train)], options)
    seconds = time.process_time() - begin
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(seconds, memory, sum(len(m.positions) for m in train), len(result.iterates))


def table(method: str, option: str, counts: list[int]) -> None:
    baseline = 0.0
    for count in counts:
        words = [sys.executable, __file__, "--method", method, option, str(count)]
        out = subprocess.run(words, check=True, capture_output=True, text=True).stdout
        seconds, memory, total, iterations = map(float, out.split())
        per_sample = seconds / total
        baseline = baseline or per_sample
        print(
            f"{method:5s} {option[2:]:10s} {count:6d}: {seconds:7.2f} s, {iterations:3.0f} "
            f"iterations, {1e6 * per_sample:7.1f} us a sample ({per_sample / baseline:.2f} x), "
            f"peak memory {memory:.0f} MB",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--most", type=int, default=50_000, help="samples in each socket"
    )
    parser.add_argument("--method", choices=("auto", "paper"), help=argparse.SUPPRESS)
    parser.add_argument("--samples", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--placements", type=int, default=0, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.method:
        fit(arguments.method, arguments.samples, arguments.placements)
        return
    counts = [c for c in (30, 300, 3_000, 50_000) if c <= arguments.most]
    for method in ("paper", "auto"):
        table(method, "--samples", counts)
        table(method, "--placements", [4, 25, 100])


if __name__ == "__main__":
    main()

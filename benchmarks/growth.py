"""How time and memory of mukca solve grow with placements and samples, as ratios in one run.

    python benchmarks/growth.py

A Panda is simulated. Placements have 12 + 12 samples; a placement alone has more and more.
``page.py --measure growth`` keeps the table in docs/benchmarks.md.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mukca.recorder import write_holes
from mukca.solver.identification.robot import load_robot
from mukca.tools.simulation import Base, perturb, reachable_bases, record

PLACEMENTS = (2, 8, 40, 200)
SAMPLES = (60, 600, 6000, 30000)
STARTER = """
import resource, subprocess, sys
done = subprocess.run(sys.argv[1:], capture_output=True)
usage = resource.getrusage(resource.RUSAGE_CHILDREN)
print(done.returncode, usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""
AT_ONCE = 10
"""Bases that are drawn far from each other."""


def cost(words: Sequence[str]) -> tuple[float, float]:
    """Return what a command computes [s], and how much memory it takes at most [MB].

    A small process starts it: until then a process is as large as the one that starts it.
    """
    starter = [sys.executable, "-c", STARTER, *words]
    done = subprocess.run(starter, capture_output=True, check=True, text=True)
    status, seconds, kilobytes = map(float, done.stdout.split())
    assert status in (0, 1, 3), words
    return seconds, kilobytes * 1024 / 1e6


def show(what: str, folders: dict[int, Path]) -> None:
    """Print a row for each folder: its cost, and the growth from the one before."""
    before = 0.0
    for count, folder in folders.items():
        words = ("solve", str(folder), "--robot", "panda", "--distance", "0.05")
        seconds, memory = cost([sys.executable, "-m", "mukca", *words, "--no-proof"])
        growth = f"{seconds / before:.1f} x" if before else ""
        row = f"{count:,} {what}", f"{seconds:.1f}", growth, f"{memory:.0f}"
        print(f"| {' | '.join(row)} |", flush=True)
        before = seconds


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    robot = load_robot("panda")
    arms, places, hands = (np.random.default_rng([1, k]) for k in range(3))
    arm = perturb(robot, arms, 2e-3, 5e-3)
    bases: list[Base] = []
    while len(bases) < max(PLACEMENTS):
        bases += reachable_bases(arm, places, AT_ONCE)
    with tempfile.TemporaryDirectory() as temporary:
        root = Path(temporary)
        by_placements = {count: root / f"placements_{count}" for count in PLACEMENTS}
        for k in range(max(PLACEMENTS)):
            base = replace(bases[k], name=f"placement_{k:03d}")
            placement = record(arm, base, hands, samples=12, noise=5e-5)
            for count, folder in by_placements.items():
                if k < count:
                    write_holes(placement, folder / base.name)
        by_samples = {count: root / f"samples_{count}" for count in SAMPLES}
        for count, folder in by_samples.items():
            placement = record(arm, bases[0], hands, samples=count // 2, noise=5e-5)
            write_holes(placement, folder / "placement")
        print("| | CPU, s | growth | memory, MB |\n|---|---|---|---|")
        show("placements", by_placements)
        show("samples", by_samples)


if __name__ == "__main__":
    main()

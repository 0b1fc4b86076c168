"""How time and memory of mukca solve grow with placements and samples, as ratios in one run.

    python benchmarks/growth.py

A Panda is simulated. Placements have 12 + 12 samples; a placement alone has more and more.
"""

import argparse
import os
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

PLACEMENTS = (2, 8, 40, 80, 200)
SAMPLES = (60, 600, 6000, 30000)
AT_ONCE = 10
"""Bases that are drawn far from each other."""


def cost(words: Sequence[str]) -> tuple[float, float]:
    """Return what a command computes [s], and how much memory it takes at most [MB]."""
    program = subprocess.Popen(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(program.pid, 0)
    program.returncode = os.waitstatus_to_exitcode(status)
    assert program.returncode in (0, 1, 3), words
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024 / 1e6


def table(title: str, folders: dict[int, Path]) -> None:
    """Print the cost of each folder of placements, and its growth from the one before."""
    print(f"{title:>10s}   CPU, s   growth   memory, MB")
    before = None
    for count, folder in folders.items():
        words = [
            "-m",
            "mukca",
            "solve",
            str(folder),
            "--robot",
            "panda",
            "--distance",
            "0.05",
            "--no-proof",
        ]
        seconds, memory = cost([sys.executable, *words])
        growth = f"{seconds / before:.1f} x" if before else ""
        print(f"{count:10d} {seconds:8.1f} {growth:>8s} {memory:12.0f}")
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
        table("placements", by_placements)
        table("samples", by_samples)


if __name__ == "__main__":
    main()

"""What a report costs, against bare imports of what it needs, measured in the same run.

    python benchmarks/report.py [PLACEMENT ... --robot R]

The first placement is trained on, all others are held out. Without any, simulated ones of the
demo arm are used: six placements of 2 x 30 samples.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from mukca.recorder import write_holes
from mukca.tools.simulation import SEAT_NOISE, demo_arm, reachable_bases, record


def seconds(words: list[str], runs: int = 5) -> float:
    """Return the median time of a process."""
    times: list[float] = []
    for _ in range(runs):
        begin = time.perf_counter()
        done = subprocess.run(words, capture_output=True, text=True)
        # Any verdict will do; 2 is a usage error.
        assert done.returncode != 2, done.stderr
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def simulate(folder: Path, count: int = 6) -> list[str]:
    """Write placements of the demo arm and return their folders."""
    nominal, arm = demo_arm()
    generator = np.random.default_rng(1)
    bases = reachable_bases(nominal, generator, count)
    for base in bases:
        write_holes(record(arm, base, generator, noise=SEAT_NOISE), folder / base.name)
    return [str(folder / base.name) for base in bases]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("placements", nargs="*")
    parser.add_argument("--robot", default="panda")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        train, *test = arguments.placements or simulate(folder / "recordings")
        out = folder / "out"
        words = [train, "--robot", arguments.robot, "--out", str(out)]
        held_out = ["--test", *test] if test else []
        seconds([sys.executable, "-m", "mukca", "solve", *words, *held_out], runs=1)
        file = str(out / "calibration.json")
        report = seconds([sys.executable, "-m", "mukca", "report", file])
        bare = seconds([sys.executable, "-c", "import numpy, casadi"])
        size = (out / "report.html").stat().st_size
        count = len(json.loads((out / "report.json").read_text())["placements"])
    print(
        f"{count} placements: report {report:.2f} s, {report / bare:.1f} x bare imports"
    )
    print(f"report.html: {size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()

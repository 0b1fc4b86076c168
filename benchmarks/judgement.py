"""Share of the judgement in ``mukca solve`` on a real Panda, measured in pairs.

    python benchmarks/judgement.py [--pairs 7]

A pair is the processor time of the whole command in a process of its own, and that of what judges,
timed in another: the inspection of all recordings, and the verdict. Printed is the median of the
second over the rest of the first. It needs ``../shared/recordings/panda_3``.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mukca
from mukca.solver.data import measure
from mukca.solver.diagnostics import inspect_all

DATA = Path(__file__).resolve().parents[2] / "shared" / "recordings" / "panda_3"


def command() -> float:
    """Return the processor time of the whole command [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = ["solve", str(DATA / "frontcenter"), "--test", str(DATA), "--robot", "panda"]
    full = [sys.executable, "-m", "mukca", *words, "--distance", "0.05"]
    subprocess.run(full, check=False, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=7)
    pairs = parser.parse_args().pairs
    robot, placements = mukca.load_robot("panda"), mukca.read_placements(DATA)
    train = [p for p in placements if p.name.endswith("frontcenter")]
    test = [p for p in placements if p not in train]
    shares: list[float] = []
    for _ in range(pairs):
        calibration = mukca.calibrate(robot, train, test=test, distance=0.05)
        measured = [measure(p, robot, 0.05) for p in placements]
        begin = time.process_time()
        inspect_all(robot, measured)
        judged = (calibration.verdict, time.process_time() - begin)[1]
        whole = command()
        shares.append(judged / (whole - judged))
        print(f"the command {whole:.2f} s, of which judging {judged:.2f} s", flush=True)
    print(f"judging adds {100 * statistics.median(shares):.0f} % (median of {pairs})")


if __name__ == "__main__":
    main()

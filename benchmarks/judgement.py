"""Share of the judgement in ``mukca solve`` on a real Panda, measured in pairs.

    python benchmarks/judgement.py [--pairs 9]

A pair is the processor time of the whole command, each in a process of its own: as it is, and with
nothing looked at before the fit and no verdict after it. Printed is the median of what the first
takes more. It needs ``../shared/recordings/panda_3``.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "shared" / "recordings" / "panda_3"
WITHOUT = """
from types import SimpleNamespace
from mukca.solver import assessment
from mukca.solver.calibration import calibration, problem
limits = SimpleNamespace(repeatability=None)
nothing = SimpleNamespace(verdict=assessment.judge(()), limits=limits)
for module, name, instead in (
    (problem, "_inspected", lambda one: one),
    (calibration, "assess", lambda *_: nothing),
):
    assert hasattr(module, name), f"{module.__name__}.{name} is no more: change the benchmark"
    setattr(module, name, instead)
"""
RUN = "import sys\nfrom mukca.tools.cli import main\n{}\nsys.exit(main())"


def seconds(change: str) -> float:
    """Return the processor time of the command, with something changed in it [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [
        "solve",
        str(DATA / "frontcenter"),
        "--test",
        str(DATA),
        "--robot",
        "panda",
    ]
    full = [sys.executable, "-c", RUN.format(change), *words, "--distance", "0.05"]
    done = subprocess.run(
        full,
        check=False,
        capture_output=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr.decode()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=9)
    pairs = parser.parse_args().pairs
    seconds("")  # what is read from disk is read
    shares: list[float] = []
    for _ in range(pairs):
        judged, plain = seconds(""), seconds(WITHOUT)
        shares.append(judged / plain - 1)
        print(f"{judged:.2f} s, without judging {plain:.2f} s", flush=True)
    print(f"judging adds {100 * statistics.median(shares):.0f} % (median of {pairs})")


if __name__ == "__main__":
    main()

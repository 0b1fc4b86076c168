"""Share of the judgement in ``mukca solve`` on a real Panda.

    python benchmarks/judgement.py [--rounds 9]

The judgement is what is looked at before the fit, and the verdict after it. A round is the
processor time of the whole command, in this process. It needs ``../shared/recordings/panda_3``.
"""

import argparse
import contextlib
import io
import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from mukca.solver.calibration import calibration, preparation
from mukca.tools.cli import main as mukca

DATA = Path(__file__).resolve().parents[2] / "shared" / "recordings" / "panda_3"
JUDGING = ((preparation, "mended"), (calibration, "assess"))
"""Modules, and the functions in them that judge."""


class Stopwatch:
    """Adds up the processor time of functions [s]."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function whose time is added."""

        def call(*arguments: Any, **options: Any) -> Any:
            begin = time.process_time()
            try:
                return function(*arguments, **options)
            finally:
                self.seconds += time.process_time() - begin

        return call


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=9)
    rounds = parser.parse_args().rounds
    stopwatch = Stopwatch()
    for module, name in JUDGING:
        setattr(module, name, stopwatch.timed(getattr(module, name)))
    words = ["solve", str(DATA / "frontcenter"), "--test", str(DATA)]
    words += ["--robot", "panda", "--distance", "0.05"]
    shares: list[float] = []
    for number in range(rounds + 1):
        begin, judged = time.process_time(), stopwatch.seconds
        with contextlib.redirect_stdout(io.StringIO()):
            mukca(words)
        seconds = time.process_time() - begin
        judging = stopwatch.seconds - judged
        if not number:  # in the first round modules are loaded
            continue
        shares.append(judging / seconds)
        print(f"{seconds:.2f} s, of these judging {judging:.2f} s", flush=True)
    print(f"judging is {100 * statistics.median(shares):.0f} % (median of {rounds})")


if __name__ == "__main__":
    main()

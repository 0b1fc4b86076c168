"""Take awkward recordings through all verbs: the whole zoo, and random cases as long as told.

    python benchmarks/zoo.py [--only WORD] [--cases 0] [--seconds 0] [--seed 0] [--processes 1]

Each goes through check, solve by both methods, validate, report, export and rezero, in this
process. Nothing but a MukcaError may come out of it, nothing may hang, and every stated deviation
is finite and positive; RuntimeWarnings count as exceptions. The zoo is a table, a row for each
case: exit statuses, and what broke. Random cases begin with ``--seed`` and count up; of these the
ones that broke are printed, with the seed that ``--seed N --cases 1`` does again. There are as many
as ``--cases`` says, or as begin within ``--seconds``. Exit status 1 if anything broke.
"""

import argparse
import os
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from worlds.verbs import Outcome, walked
from worlds.zoo import Case, random_case, zoo

from mukca.tools.parallel import Workers

BATCH = 4
"""Cases that each process takes before they are printed."""
LOOK = 8
"""Random cases between two looks at the clock."""


def outcome_of(case: Case) -> tuple[Outcome, float]:
    """Return how the verbs ended on a case, and the processor time that they took [s]."""
    warnings.simplefilter("error")
    recorded, begin = case.recorded(), time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        return walked(recorded, Path(folder)), time.process_time() - begin


def row(case: Case, outcome: Outcome, seconds: float) -> str:
    """Return a row of the table."""
    statuses = ", ".join(
        f"{verb} {status}" for verb, status in outcome.statuses.items()
    )
    broke = "; ".join(outcome.faults) or "nothing"
    return f"| {case.name} | {statuses} | {seconds:.1f} | {broke} |"


def taken_through(
    cases: Sequence[Case], workers: Workers
) -> Iterator[tuple[Case, Outcome, float]]:
    """Yield each case with how its verbs ended, some at a time."""
    size = BATCH * workers.processes
    for begin in range(0, len(cases), size):
        batch = cases[begin : begin + size]
        for case, ends in zip(batch, workers.map(outcome_of, batch), strict=True):
            yield case, *ends


def whole_zoo(only: str, workers: Workers) -> int:
    """Print the table of the zoo, and return the number of cases that broke."""
    cases = [
        case
        for kind in zoo()
        for case in kind
        if only in case.name and not case.missing
    ]
    broken = 0
    print(
        "| case | exit status | processor time in s | what broke |\n|---|---|---|---|"
    )
    for case, outcome, seconds in taken_through(cases, workers):
        print(row(case, outcome, seconds), flush=True)
        broken += bool(outcome.faults)
    return broken


def random_cases(first: int, count: int, seconds: float, workers: Workers) -> int:
    """Print the random cases that broke, and return their number."""
    begin, broken, done = time.monotonic(), 0, 0
    while done < count or time.monotonic() - begin < seconds:
        size = min(count - done, LOOK) if done < count else LOOK
        cases = [random_case(first + done + i) for i in range(size)]
        for case, outcome, taken in taken_through(cases, workers):
            if outcome.faults:
                print(f"--seed {case.seed}: {row(case, outcome, taken)}", flush=True)
            broken += bool(outcome.faults)
        done += size
        print(f"{done} random cases, {broken} broke", file=sys.stderr, flush=True)
    print(f"{done} random cases, {broken} broke")
    return broken


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--only", default="", metavar="WORD", help="cases with this in their name"
    )
    parser.add_argument(
        "--cases", type=int, default=0, help="random cases, in place of the zoo"
    )
    parser.add_argument(
        "--seconds", type=float, default=0, help="random cases for so long"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the first random case")
    parser.add_argument("--processes", type=int, default=1)
    arguments = parser.parse_args()
    workers = Workers(arguments.processes)
    if arguments.cases or arguments.seconds:
        told = arguments.seed, arguments.cases, arguments.seconds
        return int(random_cases(*told, workers) > 0)
    return int(whole_zoo(arguments.only, workers) > 0)


if __name__ == "__main__":
    raise SystemExit(main())

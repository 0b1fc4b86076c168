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
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from worlds.verbs import Outcome, walked
from worlds.zoo import Case, random_case, zoo

from mukca.tools.parallel import Workers

BATCH = 20
"""Random cases between two looks at the clock, for each process."""


def outcome_of(case: Case) -> tuple[Outcome, float]:
    """Return how the verbs ended on a case, and the processor time that they took [s]."""
    warnings.simplefilter("error")
    recorded, begin = case.recorded(), time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        return walked(recorded, Path(folder)), time.process_time() - begin


def row(case: Case, outcome: Outcome, seconds: float) -> str:
    """Return a row of the table."""
    statuses = ", ".join(f"{verb} {status}" for verb, status in outcome.statuses.items())
    broke = "; ".join(outcome.faults) or "nothing"
    return f"| {case.name} | {statuses} | {seconds:.1f} | {broke} |"


def whole_zoo(only: str, workers: Workers) -> int:
    """Print the table of the zoo, and return the number of cases that broke."""
    cases = [case for kind in zoo() for case in kind if only in case.name and not case.missing]
    outcomes = workers.map(outcome_of, cases)
    print("| case | exit status | processor time in s | what broke |\n|---|---|---|---|")
    print("\n".join(row(case, *ends) for case, ends in zip(cases, outcomes, strict=True)))
    return sum(bool(outcome.faults) for outcome, _ in outcomes)


def random_cases(seeds: range, seconds: float, workers: Workers) -> int:
    """Print the random cases that broke, and return their number."""
    begin, broken, done = time.monotonic(), 0, 0
    ends: Counter[str] = Counter()
    while done < len(seeds) or time.monotonic() - begin < seconds:
        size = min(BATCH * workers.processes, max(len(seeds) - done, 0) or BATCH)
        batch = range(seeds.start + done, seeds.start + done + size)
        cases = [random_case(seed) for seed in batch]
        for case, (outcome, taken) in zip(cases, workers.map(outcome_of, cases), strict=True):
            ends[f"solve {outcome.statuses['solve']}"] += 1
            broken += bool(outcome.faults)
            if outcome.faults:
                print(f"--seed {case.seed}: {row(case, outcome, taken)}", flush=True)
        done += size
    print(f"{done} random cases, {broken} broke; {dict(ends)}")
    return broken


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", metavar="WORD", help="cases with this in their name")
    parser.add_argument("--cases", type=int, default=0, help="random cases, in place of the zoo")
    parser.add_argument("--seconds", type=float, default=0, help="random cases for so long")
    parser.add_argument("--seed", type=int, default=0, help="of the first random case")
    parser.add_argument("--processes", type=int, default=1)
    arguments = parser.parse_args()
    workers = Workers(arguments.processes)
    if arguments.cases or arguments.seconds:
        seeds = range(arguments.seed, arguments.seed + arguments.cases)
        return int(random_cases(seeds, arguments.seconds, workers) > 0)
    return int(whole_zoo(arguments.only, workers) > 0)


if __name__ == "__main__":
    raise SystemExit(main())

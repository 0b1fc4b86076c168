"""``mukca crossval``: leave each placement out once, and train on each alone."""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..arguments import UsageError, add_load, add_robot, load_of, measure_all, robot_of
from ..terminal import Terminal

if TYPE_CHECKING:
    from ...solver.crossval import Job, Plan
    from ...solver.data.metrics import Metrics

EXAMPLE = """example:
  mukca crossval recordings --robot panda"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    parser.add_argument("data", nargs="+", type=Path, metavar="DATA", help="placements, 2 or more")
    add_robot(parser)
    parser.add_argument("--method", choices=("auto", "paper"), default="auto")
    parser.add_argument(
        "--distance", type=float, metavar="M", help="distance of the sockets' centres in metres"
    )
    parser.add_argument(
        "--bootstrap",
        type=int,
        default=0,
        metavar="N",
        help="fit N times to samples drawn anew, for the spread of the errors",
    )
    parser.add_argument(
        "--processes", type=int, default=os.cpu_count(), metavar="N", help="(default: all cores)"
    )
    add_load(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Run all fits, and show the errors left out, and the matrix of the paper's Fig. 6."""
    from ...solver.crossval import Plan, jobs
    from ...solver.data.measurements import check_distinct
    from ...solver.robot.parameters import choose_parameters

    robot = robot_of(arguments)
    data = measure_all(arguments.data, robot, arguments.distance)
    check_distinct(data)
    if len(data) < 2:
        raise UsageError("crossval needs two placements or more; there is one")
    if arguments.bootstrap == 1 or arguments.bootstrap < 0:
        raise UsageError(f"--bootstrap {arguments.bootstrap}: a spread needs 2 fits or more")
    plan = Plan(
        robot,
        choose_parameters(robot),
        tuple(data),
        arguments.method,
        load_of(arguments),
    )
    work = jobs(len(data), arguments.bootstrap)
    metrics = run_all(plan, work, max(1, arguments.processes), terminal)
    result = {
        "robot": arguments.robot,
        "method": arguments.method,
        **summary([m.name for m in data], work, metrics),
    }
    show(result, terminal)
    if arguments.json:
        terminal.emit(result)
    return 0


def run_all(
    plan: "Plan", work: "list[Job]", processes: int, terminal: Terminal
) -> "list[list[Metrics]]":
    """Run fits over several processes, in order, with a progress bar."""
    from ...solver.crossval import run_job

    results: list[list[Metrics]] = []
    with (
        terminal.progress(len(work)) as progress,
        ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool,
    ):
        futures = [pool.submit(run_job, plan, job) for job in work]
        for job, future in zip(work, futures, strict=True):
            progress(job.kind.replace("_", " "))
            results.append(future.result())
    return results


def summary(names: list[str], work: "list[Job]", metrics: "list[list[Metrics]]") -> dict[str, Any]:
    """Return errors with each placement left out, the matrix, and the bootstrap's spread."""
    from ...solver.crossval import spread
    from ...solver.data.metrics import mean_metrics

    by_kind: dict[str, list[list[Metrics]]] = {}
    for job, row in zip(work, metrics, strict=True):
        by_kind.setdefault(job.kind, []).append(row)
    left_out = [row[i] for i, row in enumerate(by_kind["left_out"])]
    matrix = [[m.mean_absolute_error for m in row] for row in by_kind["alone"]]
    result: dict[str, Any] = {
        "left_out": [
            {"name": name, **m.as_dict()} for name, m in zip(names, left_out, strict=True)
        ],
        "summary": mean_metrics(left_out).as_dict(),
        "cross_placement": {"names": names, "matrix": matrix},
    }
    if "bootstrap" in by_kind:
        errors = [[m.mean_absolute_error for m in row] for row in by_kind["bootstrap"]]
        result["bootstrap"] = [
            {"name": name, "standard_deviation": s}
            for name, s in zip(names, spread(errors), strict=True)
        ]
    return result


def show(result: dict[str, Any], terminal: Terminal) -> None:
    """Print the tables for people."""
    from ..console_tables import left_out_table, matrix_table

    terminal.console.print(left_out_table(result))
    terminal.console.print(matrix_table(result["cross_placement"]))

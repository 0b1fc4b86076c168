"""``mukca crossval``: leave each placement out once, and train on each alone."""

import argparse
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...parallel import Workers, add_workers, workers_of
from .. import (
    Terminal,
    add_load,
    add_measured,
    add_robot,
    add_type_prior,
    measure_all,
    robot_of,
    settings_of,
)
from ..robot_arguments import UsageError

if TYPE_CHECKING:
    from ....solver.calibration import HeldOutErrors, Job, Plan
    from ....solver.data import Metrics

WORTH = 0.05
"""Part of the error that must be gained for more placements to be worth it."""
_NOTHING = {"mean_absolute_error": None, "max_error": None, "distance_error": None}
EXAMPLE = """example:
  mukca crossval recordings --robot panda --distance 0.0501"""


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
    add_measured(parser)
    add_type_prior(parser)
    add_load(parser)
    add_workers(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object, SI units")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Run all fits, and show the errors left out, and the matrix of the paper's Fig. 6."""
    from ....solver.calibration import Plan, jobs, type_priors
    from ....solver.data import check_distinct
    from ....solver.diagnostics import inspect_all, named
    from ....solver.robot import choose_parameters

    workers = workers_of(arguments)
    robot, settings = robot_of(arguments), settings_of(arguments, arguments.method)
    data = measure_all(arguments.data, robot, arguments.distance)
    check_distinct(data)
    if len(data) < 2:
        raise UsageError("crossval needs two placements or more; there is one")
    if arguments.bootstrap == 1 or arguments.bootstrap < 0:
        raise UsageError(f"--bootstrap {arguments.bootstrap}: a spread needs 2 fits or more")
    parameters = choose_parameters(robot)
    known, deviation = named(data, settings.distances), settings.deviation
    zeros = bool(settings.zeros)
    survey = inspect_all(robot, data, known=known, deviation=deviation, zeros=zeros)
    for finding in survey.diagnostics:
        terminal.warn(str(finding))
    plan = Plan(
        robot=robot,
        parameters=parameters,
        measurements=tuple(data),
        method=arguments.method,
        load=settings.load,
        known=tuple(known),
        deviation=deviation,
        zeros=zeros,
        of_type=type_priors(settings.type_prior, [robot])[0],
    )
    work = jobs(len(data), arguments.bootstrap)
    metrics = run_all(plan, work, workers, terminal)
    result = {
        "robot": arguments.robot,
        "method": arguments.method,
        **summary([m.name for m in data], work, metrics),
    }
    wrong = [one.measured.name for one in survey.placements if not one.sound]
    result["advice"] = advice(result, wrong)
    show(result, terminal)
    if arguments.json:
        terminal.emit(result)
    return 0


def run_all(
    plan: "Plan", work: "list[Job]", workers: Workers, terminal: Terminal
) -> "list[HeldOutErrors | None]":
    """Run fits, in order, with a progress bar; None where one failed."""
    from ....solver.calibration import run_job

    with terminal.progress(len(work)) as progress:
        return workers.map(
            partial(run_job, plan), work, lambda i: progress(work[i].kind.replace("_", " "))
        )


def summary(
    names: list[str], work: "list[Job]", metrics: "list[HeldOutErrors | None]"
) -> dict[str, Any]:
    """Return errors with each placement left out, the matrix, and the bootstrap's spread.

    A fit that did not settle leaves None: in the matrix for a whole row, and in ``left_out`` for
    the figures of a placement.
    """
    from ....solver.calibration import spread

    by_kind: dict[str, list[HeldOutErrors | None]] = {}
    for job, row in zip(work, metrics, strict=True):
        by_kind.setdefault(job.kind, []).append(row)
    rows = by_kind["left_out"]
    left_out = [None if row is None else row.full[i] for i, row in enumerate(rows)]
    by_urdf = [None if row is None else row.loaded[i] for i, row in enumerate(rows)]
    matrix = [row and [m.mean_absolute_error for m in row.full] for row in by_kind["alone"]]
    result: dict[str, Any] = {
        "left_out": [
            {"name": name, **_figures(m), "loaded": _figures(loaded)}
            for name, m, loaded in zip(names, left_out, by_urdf, strict=True)
        ],
        "summary": {**_mean(left_out), "loaded": _mean(by_urdf)},
        "cross_placement": {"names": names, "matrix": matrix},
    }
    drawn = [row for row in by_kind.get("bootstrap", []) if row is not None]
    if len(drawn) > 1:
        errors = [[m.mean_absolute_error for m in row.full] for row in drawn]
        result["bootstrap"] = [
            {"name": name, "standard_deviation": s}
            for name, s in zip(names, spread(errors), strict=True)
        ]
    return result


def _figures(metrics: "Metrics | None") -> Mapping[str, float | None]:
    return _NOTHING if metrics is None else metrics.as_dict()


def _mean(metrics: "Sequence[Metrics | None]") -> Mapping[str, float | None]:
    """Return the mean figures of those fits that settled."""
    from ....solver.data import mean_metrics

    given = [m for m in metrics if m is not None]
    return _figures(mean_metrics(given) if given else None)


def advice(result: Mapping[str, Any], wrong: Sequence[str]) -> str:
    """Return in one sentence what to do.

    Args:
        result: As :func:`summary` returns it.
        wrong: Names of the placements in which the checks found errors.
    """
    names, matrix = result["cross_placement"]["names"], result["cross_placement"]["matrix"]
    unsettled = [name for name, row in zip(names, matrix, strict=True) if row is None]
    wrong = [name for name in names if name in (*wrong, *unsettled)]
    if wrong:
        return (
            f"Mend or leave out {' and '.join(wrong)} and run this again: nothing trained or "
            "measured there is to be trusted."
        )
    error = result["summary"]["mean_absolute_error"]
    if error is None:
        return "No fit settled: see mukca check on what the data lack."
    others = [[v for j, v in enumerate(row) if j != i] for i, row in enumerate(matrix)]
    means = [sum(row) / len(row) for row in others]
    best = min(range(len(means)), key=means.__getitem__)
    gain = 1 - error / means[best]
    if gain > WORTH:
        return (
            f"Train on all: one left out is then off by {1e3 * error:.3f} mm, {100 * gain:.0f} % "
            f"less than by the best alone, {names[best]} ({1e3 * means[best]:.3f} mm)."
        )
    return (
        f"More placements would bring little: {names[best]} alone leaves {1e3 * means[best]:.3f} "
        f"mm in the others, all but one together {1e3 * error:.3f} mm."
    )


def show(result: dict[str, Any], terminal: Terminal) -> None:
    """Print the tables for people."""
    from .. import left_out_table, matrix_table

    terminal.console.print(left_out_table(result))
    terminal.console.print(matrix_table(result["cross_placement"]))
    terminal.say(result["advice"])

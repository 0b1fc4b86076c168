"""``mukca crossval``: one calibration for each placement, shared out over workers."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from statistics import stdev
from typing import Any

from ....solver import assessment, calibration, data, results
from ....solver.assessment import millimetres
from ....solver.calibration import SolveOptions, UsageError
from ... import cli

WORTH = 0.05
"""Part of the error that must be gained for more placements to be worth it."""
_NOTHING = {"mean_absolute_error": None, "max_error": None, "distance_error": None}


class _CrossvalOptions(cli.RobotOptions, cli.WorkerOptions, cli.JsonOption):
    data: Sequence[Path] = cli.argument("placements, 2 or more", "DATA")
    bootstrap: int = cli.option(
        0, "fit N times to samples drawn anew, for the spread of the errors", "N"
    )
    settings: SolveOptions = cli.part(
        SolveOptions, "method distance known distance_deviation zeros type_prior payload gravity"
    )


def run_crossval(options: _CrossvalOptions, terminal: cli.Terminal) -> int:
    """Run all fits, and show the errors left out, and the matrix of the paper's Fig. 6."""
    robot, settings = options.load_robot(), options.settings.validated()
    if options.bootstrap == 1 or options.bootstrap < 0:
        raise UsageError(f"--bootstrap {options.bootstrap}: a spread needs 2 fits or more")
    placements, survey = cli.survey_of(options.data, robot, settings)
    if len(placements) < 2:
        raise UsageError("crossval needs two placements or more; there is one")
    terminal.warn(*map(str, survey.diagnostics))
    problem = calibration.CalibrationProblem(robot, placements, settings.load, options=settings)
    fit = partial(calibration.run_job, problem)
    work = calibration.jobs(len(placements), options.bootstrap)
    with terminal.progress(len(work)) as progress:
        kinds = [job.kind.replace("_", " ") for job in work]
        fits = options.workers.map(fit, work, lambda i: progress(kinds[i]))
    metrics = [fit and fit.errors for fit in fits]
    result: dict[str, Any] = {"robot": options.robot, "method": settings.method}
    result |= summary([m.name for m in placements], work, metrics)
    result["apart"] = apart(problem, work, fits)
    faulty = [inspection.measured.name for inspection in survey.placements if not inspection.sound]
    result["advice"] = advice(result, faulty)
    show(result, terminal)
    terminal.emit(result)
    return 0


def summary(
    names: list[str],
    work: "list[calibration.Job]",
    metrics: "list[list[results.PlacementErrors] | None]",
) -> dict[str, Any]:
    """Errors with each placement left out, matrix, and spread; None where a fit did not settle."""
    left_out = [row for job, row in zip(work, metrics, strict=True) if job.kind == "left_out"]
    lone = [row for job, row in zip(work, metrics, strict=True) if job.kind == "alone"]
    bootstrap = [row for job, row in zip(work, metrics, strict=True) if job.kind == "bootstrap"]
    corrected_metrics = [row[i].calibrated if row else None for i, row in enumerate(left_out)]
    loaded = [row[i].loaded if row else None for i, row in enumerate(left_out)]
    result: dict[str, Any] = {
        "left_out": [
            {"name": name, **_figures(corrected), "loaded": _figures(loaded_metrics)}
            for name, corrected, loaded_metrics in zip(
                names, corrected_metrics, loaded, strict=True
            )
        ],
        "summary": {**_mean(corrected_metrics), "loaded": _mean(loaded)},
        "cross_placement": {"names": names, "matrix": [row and _means(row) for row in lone]},
    }
    drawn = [_means(row) for row in bootstrap if row is not None]
    if len(drawn) > 1:
        result["bootstrap"] = [
            {"name": name, "standard_deviation": stdev(values)}
            for name, values in zip(names, zip(*drawn, strict=True), strict=True)
        ]
    return result


def apart(
    problem: "calibration.CalibrationProblem",
    work: "list[calibration.Job]",
    fits: "list[calibration.JobResult | None]",
) -> list[dict[str, Any]]:
    """Return how far two fits are apart at each placement; None where one has no covariance.

    Two fits are that to the placement and that to all others, or those to its odd and even samples.
    """
    posteriors = {
        (job.kind, job.trained): fit.posterior
        for job, fit in zip(work, fits, strict=True)
        if fit is not None and job.seed is None
    }
    everything, rows = tuple(range(len(problem.measurements))), list[dict[str, Any]]()
    for i, measured in enumerate(problem.measurements):
        remainder = everything[:i] + everything[i + 1 :]
        pairs = {
            "others": (("left_out", remainder), ("alone", (i,))),
            "halves": (("odd", (i,)), ("even", (i,))),
        }
        row: dict[str, Any] = {"name": measured.name}
        for name, (a, b) in pairs.items():
            first, second = posteriors.get(a), posteriors.get(b)
            row[name] = None
            if first is not None and second is not None:
                row[name] = calibration.Comparison(first, second, problem.load).at(measured)
        rows.append(row)
    return rows


def _means(errors: "list[results.PlacementErrors]") -> list[float]:
    return [row.calibrated.mean_absolute_error for row in errors]


def _figures(metrics: "data.Metrics | None") -> Mapping[str, float | None]:
    return metrics.as_dict() if metrics else _NOTHING


def _mean(metrics: "Sequence[data.Metrics | None]") -> Mapping[str, float | None]:
    present = [m for m in metrics if m is not None]
    return _figures(data.mean_metrics(present) if present else None)


def advice(result: Mapping[str, Any], faulty: Sequence[str]) -> str:
    """Advice in one sentence; ``faulty`` names the placements with errors."""
    names, matrix = result["cross_placement"]["names"], result["cross_placement"]["matrix"]
    unsettled = [name for name, row in zip(names, matrix, strict=True) if row is None]
    faulty = [name for name in names if name in (*faulty, *unsettled)]
    if faulty:
        return (
            f"Mend or leave out {' and '.join(faulty)} and run this again: nothing trained or "
            "measured there is to be trusted."
        )
    error = result["summary"]["mean_absolute_error"]
    if error is None:
        return "No fit settled: see mukca check on what the data lack."
    rows_beside = [[v for j, v in enumerate(row) if j != i] for i, row in enumerate(matrix)]
    means = [sum(row) / len(row) for row in rows_beside]
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


def show(result: Mapping[str, Any], terminal: cli.Terminal) -> None:
    """Print the errors left out, and the matrix, in mm; and the advice."""
    spreads = {row["name"]: row["standard_deviation"] for row in result.get("bootstrap", [])}
    heads = ["placement", *calibration.HEADS[2:], "MAE of the URDF alone"]
    heads += ["MAE over bootstrap fits to all"] if spreads else []
    rows: list[list[str]] = []
    mean: dict[str, Any] = {"name": "= mean", **result["summary"]}
    for row in (*result["left_out"], mean):
        cells = [millimetres(row[name]) for name in _NOTHING]
        cells.append(millimetres(row["loaded"]["mean_absolute_error"]))
        spread = spreads.get(row["name"])
        cells += ["" if spread is None else f"+- {millimetres(spread)}"] if spreads else []
        rows.append([row["name"], *cells])
    title = "errors in mm of each placement, trained on all others"
    terminal.tabulate(title, heads, rows)
    names, matrix = result["cross_placement"]["names"], result["cross_placement"]["matrix"]
    rows = []
    for i, (name, errors) in enumerate(zip(names, matrix, strict=True)):
        cells = [millimetres(error) for error in errors or [None] * len(names)]
        cells[i] = f"({cells[i]})"
        rows.append([f"{i + 1} {name}", *cells])
    title = "MAE in mm: trained on the row's placement alone, measured on the column's"
    numbers = map(str, range(1, len(names) + 1))
    terminal.tabulate(title, ["", *numbers], rows)
    heads = ["placement", "it and all others", "its odd and even samples"]
    rows = []
    for row in result["apart"]:
        cells = map(assessment.apart_words, (row["others"], row["halves"]))
        rows.append([row["name"], *cells])
    title = "two models apart in mm, and by chance alone; ! beyond 19 of 20 by chance"
    terminal.tabulate(title, heads, rows)
    terminal.say(result["advice"])

"""``mukca crossval``: one calibration for each placement, shared out over workers."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from statistics import fmean, stdev
from typing import Any

from ....solver import assessment, calibration, diagnostics, results
from ....solver.assessment import millimetres
from ....solver.calibration import SolveOptions, UsageError
from ....solver.identification import data
from ... import cli
from .prediction import in_words, predicted_accuracy

WORTH = 0.05
"""Part of the error that must be gained for more placements to be worth it."""
_NOTHING = {"mean_absolute_error": None, "max_error": None, "distance_error": None}


class _CrossvalOptions(cli.RobotOptions, cli.WorkerOptions, cli.JsonOption):
    data: Sequence[Path] = cli.argument("placements, 2 or more", "DATA")
    bootstrap: int = cli.option(
        0, "fit N times to samples drawn anew, for the spread of the errors", "N"
    )
    settings: SolveOptions = cli.part(
        SolveOptions,
        "method distance known distance_deviation zeros payload gravity repeatability_mm",
    )


def run_crossval(options: _CrossvalOptions, terminal: cli.Terminal) -> int:
    """Run all fits, and show the errors left out, and the matrix of the paper's Fig. 6."""
    robot = options.load_robot()
    settings = options.settings.validated()
    if options.bootstrap == 1 or options.bootstrap < 0:
        raise UsageError(
            f"--bootstrap {options.bootstrap}: a spread needs 2 fits or more"
        )
    placements, premises = cli.measured_of(options.data, robot, settings)
    if len(placements) < 2:
        raise UsageError("crossval needs two placements or more; there is one")
    survey = diagnostics.inspect_all(robot, placements, **premises)
    terminal.warn(*map(str, survey.diagnostics))
    problem = calibration.CalibrationProblem(
        robot, placements, settings.load, options=settings
    )
    fit = partial(calibration.run_job, problem)
    work = calibration.jobs(len(placements), options.bootstrap)
    with terminal.progress(len(work)) as progress:
        kinds = [job.kind.replace("_", " ") for job in work]
        fits = options.workers.map(fit, work, lambda i: progress(kinds[i]))
    metrics = [fit and fit.errors for fit in fits]
    result: dict[str, Any] = {"robot": options.robot, "method": settings.method}
    result |= summary([m.name for m in placements], work, metrics)
    result["apart"] = apart(problem, work, fits)
    faulty = [
        inspection.measured.name
        for inspection in survey.placements
        if not inspection.sound
    ]
    further = "" if faulty else accuracy_in_words(problem)
    result["advice"] = f"{advice(result, faulty)} {further}".strip()
    show(result, terminal)
    terminal.emit(result)
    return 0


def summary(
    names: list[str],
    work: "list[calibration.Job]",
    metrics: "list[list[results.PlacementErrors] | None]",
) -> dict[str, Any]:
    """Errors with each placement left out, matrix, and spread; None where a fit did not settle."""
    rows_by_kind: dict[str, list[list[results.PlacementErrors] | None]] = defaultdict(
        list
    )
    for job, row in zip(work, metrics, strict=True):
        rows_by_kind[job.kind].append(row)
    errors = [row[i] if row else None for i, row in enumerate(rows_by_kind["left_out"])]
    left_out: list[dict[str, Any]] = []
    for name, row in zip(names, errors, strict=True):
        figures = _figures(row and row.calibrated)
        left_out.append(
            {"name": name, **figures, "loaded": _figures(row and row.loaded)}
        )
    settled = [row for row in errors if row is not None]
    loaded = _mean([row.loaded for row in settled])
    matrix = [row and _means(row) for row in rows_by_kind["alone"]]
    result: dict[str, Any] = {
        "left_out": left_out,
        "summary": {**_mean([row.calibrated for row in settled]), "loaded": loaded},
        "cross_placement": {"names": names, "matrix": matrix},
    }
    drawn = [_means(row) for row in rows_by_kind["bootstrap"] if row is not None]
    if len(drawn) > 1:
        spreads = map(stdev, zip(*drawn, strict=True))
        pairs = zip(names, spreads, strict=True)
        result["bootstrap"] = [
            {"name": n, "standard_deviation": spread} for n, spread in pairs
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
    everything = tuple(range(len(problem.measurements)))
    rows: list[dict[str, Any]] = []
    for i, measured in enumerate(problem.measurements):
        alone = (i,)
        others = everything[:i] + everything[i + 1 :]
        row: dict[str, Any] = {"name": measured.name, "others": None, "halves": None}
        for name, a, b in (
            ("others", ("left_out", others), ("alone", alone)),
            ("halves", ("odd", alone), ("even", alone)),
        ):
            first = posteriors.get(a)
            second = posteriors.get(b)
            if first is not None and second is not None:
                row[name] = calibration.Comparison(first, second, problem.load).at(
                    measured
                )
        rows.append(row)
    return rows


def _means(errors: "list[results.PlacementErrors]") -> list[float]:
    return [row.calibrated.mean_absolute_error for row in errors]


def _figures(metrics: "data.Metrics | None") -> Mapping[str, float | None]:
    return metrics.as_dict() if metrics else _NOTHING


def _mean(metrics: "Sequence[data.Metrics]") -> Mapping[str, float | None]:
    return _figures(data.mean_metrics(metrics) if metrics else None)


def advice(result: Mapping[str, Any], faulty: Sequence[str]) -> str:
    """Advice in one sentence; ``faulty`` names the placements with errors."""
    names = result["cross_placement"]["names"]
    matrix = result["cross_placement"]["matrix"]
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
    others = [fmean(row[:i] + row[i + 1 :]) for i, row in enumerate(matrix)]
    least, best = min(zip(others, names, strict=True))
    gain = 1 - error / least
    if gain > WORTH:
        return (
            f"Train on all: one left out is then off by {1e3 * error:.3f} mm, {100 * gain:.0f} % "
            f"less than by the best alone, {best} ({1e3 * least:.3f} mm)."
        )
    return (
        f"At these places training on all gains little: {best} alone leaves {1e3 * least:.3f} "
        f"mm in the others, all but one together {1e3 * error:.3f} mm."
    )


def accuracy_in_words(problem: "calibration.CalibrationProblem") -> str:
    """Return whether another placement is needed, as ``mukca check`` does; empty if unknown."""
    accuracy = predicted_accuracy(problem)
    if accuracy is None:
        return ""
    return f"Calibrated on all, {in_words(accuracy, problem)}."


def show(result: Mapping[str, Any], terminal: cli.Terminal) -> None:
    """Print the errors left out, and the matrix, in mm; and the advice."""
    spreads = {
        row["name"]: row["standard_deviation"] for row in result.get("bootstrap", [])
    }
    heads = ["placement", *calibration.HEADS[2:], "MAE of the URDF alone"]
    heads += ["MAE over bootstrap fits to all"] if spreads else []
    rows: list[list[str]] = []
    mean: dict[str, Any] = {"name": "= mean", **result["summary"]}
    for row in (*result["left_out"], mean):
        lengths: list[float | None] = [row[name] for name in _NOTHING]
        lengths.append(row["loaded"]["mean_absolute_error"])
        cells = [row["name"], *map(millimetres, lengths)]
        if spreads:
            spread = spreads.get(row["name"])
            cells.append("" if spread is None else f"+- {millimetres(spread)}")
        rows.append(cells)
    terminal.tabulate(
        "errors in mm of each placement, trained on all others", heads, rows
    )
    names = result["cross_placement"]["names"]
    nothing = [None] * len(names)
    rows = []
    for i, errors in enumerate(result["cross_placement"]["matrix"]):
        cells = [f"{i + 1} {names[i]}", *map(millimetres, errors or nothing)]
        cells[i + 1] = f"({cells[i + 1]})"
        rows.append(cells)
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

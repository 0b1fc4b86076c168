"""Plots of single samples: round their sockets, flat and in space, and in their order."""

import numpy as np

from ....solver.assessment import ModelName, SampleErrors, nice_above
from ..figures import FAR, ReportDocument
from .figure import Axis, Panel
from .plot import MODELS, Plot, lengths, names_of, plot

WINDOW = 7
"""Samples in a running centre."""
FINE = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)
"""Round numbers of the axes, to be filled well."""


def errors_in_3d(report: ReportDocument) -> Plot:
    """Every sample round its socket, nominal and calibrated side by side, to one scale."""
    largest = [float(lengths(report, m).max(initial=0.0)) for m in MODELS]
    half = nice_above(max(*largest, 1e-6), FINE)
    placements = [(i, row.name) for i, row in enumerate(report.placements)]
    return plot(
        "errors-3d",
        layout="scenes",
        scene="errors",
        controls={"placements": placements, "half": half},
        width=2e3 * half,
        count=len(report.samples),
        largest=largest,
        limit=report.limits.mean_absolute_error.value,
    )


def errors_in_2d(report: ReportDocument) -> Plot:
    """Every sample round its socket, seen along two axes; for paper."""
    large, small = (
        nice_above(1e3 * float(lengths(report, model).max(initial=1e-6)), FINE) for model in MODELS
    )
    limit = 1e3 * (report.limits.mean_absolute_error.value or 0)
    if 0 < limit < 1.4 * small:  # it is drawn, all of it
        small = max(small, nice_above(limit, FINE))
    large = max(large, small)
    times = float(f"{large / small:.2g}")
    views: tuple[tuple[ModelName, float, str], ...] = (
        ("nominal", large, "nominal"),
        ("calibrated", large, "calibrated"),
        ("calibrated", small, f"calibrated x {times:g}"),
    )
    return plot(
        "errors-2d",
        *(
            _plane(report, model, axes, half, f"{view}: {title}")
            for axes, view in (("xy", "from above"), ("xz", "from the side"))
            for model, half, title in views
        ),
        layout="thirds",
        quantiles=report.summary.judged[1].quantiles,
        limit=report.limits.mean_absolute_error.value,
        times=times,
        half=small,
    )


def _plane(report: ReportDocument, model: ModelName, axes: str, half: float, title: str) -> Panel:
    """Return the samples along two axes, up to half the panel's width [mm]."""
    x, y = (Axis(-half, half, f"{axis}, mm", ticks=(-half, 0.0, half)) for axis in axes)
    panel = Panel(title, x, y, width=248, height=276, left=44).grid()
    for row in report.samples:
        a, b = (1e3 * row.of(model)["xyz".index(axis)] for axis in axes)
        panel.dot(a, b, f"{model} {report.placements[row.placement].role}", size=2)
    limit = 1e3 * (report.limits.mean_absolute_error.value or 0)
    if 0 < limit <= half:
        radius = limit * (panel.right - panel.left) / (2 * half)
        panel.dot(0, 0, "threshold", size=radius)
    return panel


def order(report: ReportDocument) -> Plot:
    """The calibrated error of each sample in the order of recording, and the running centre."""
    means = [row.calibrated.mean_absolute_error for row in report.placements]
    errors = lengths(report, "calibrated")
    top = 1.08e3 * max(float(errors.max(initial=1e-6)), FAR * max(means))
    own = np.array([means[row.placement] for row in report.samples])
    return plot(
        "order",
        *(_order_panel(report, i, name, top) for i, name in enumerate(names_of(report))),
        worst=report.answers.data.worst[0],
        beyond=int(np.sum(errors / np.maximum(own, 1e-12) > FAR)),
        count=len(errors),
        far=FAR,
        window=WINDOW,
        weighted=any(map(_doubted, report.samples)),
    )


def _doubted(sample: SampleErrors) -> bool:
    """Return True where the fit gave a sample less than half of its weight."""
    return sample.weight is not None and sample.weight < 0.5


def _order_panel(report: ReportDocument, i: int, name: str, top: float) -> Panel:
    place = report.placements[i]
    rows = [row for row in report.samples if row.placement == i]
    panel = Panel(name, Axis(0, len(rows) + 1, ticks=()), Axis(0, top, "mm"), height=170).grid()
    mean = 1e3 * place.calibrated.mean_absolute_error
    panel.threshold(f"{FAR:g} x mean", y=FAR * mean)
    first = 0
    for socket in dict.fromkeys(row.socket for row in rows):
        part = np.array([row.calibrated for row in rows if row.socket == socket])
        if first:
            panel.rule("divide", x=first + 0.5)
        panel.text(panel.x(first + 0.5) + 6, panel.bottom + 15, f"socket {socket}", "tick")
        panel.line(enumerate(_running_centre(1e3 * part), first + 1), "running")
        first += len(part)
    for k, row in enumerate(rows, 1):
        error = 1e3 * row.error()
        mark = "flagged" if _doubted(row) else f"calibrated {place.role}"
        panel.dot(k, error, mark, f"{row.where}: {error:.3f} mm")
    return panel


def _running_centre(deviations: np.ndarray) -> list[float]:
    """Return the length of the mean deviation of the samples round each one."""
    half, count = WINDOW // 2, len(deviations)
    means = [deviations[max(0, k - half) : k + half + 1].mean(axis=0) for k in range(count)]
    return np.linalg.norm(means, axis=1).tolist()

"""Plots of the samples: each round its socket, in their order, and the shares within an error."""

from itertools import product
from typing import NamedTuple

import numpy as np

from ....solver.assessment import SampleErrors, nice_above
from ....solver.results import ROLES, ModelName, Role
from ..figures import FAR, ReportDocument
from .axis import MM, Axis
from .figure import LOADED, Plot, plot
from .panel import Panel

WINDOW = 7
"""Samples in a running centre."""
FINE = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)
"""Round numbers of the axes, to be filled well."""
DOUBTED = 0.5
"""A weight below this is marked."""


def _lengths(
    report: ReportDocument,
    model: ModelName,
    role: Role | None = None,
) -> np.ndarray:
    """Return the error of each sample [m], of one role or of all, shape (N,)."""
    roles = [row.role for row in report.placements]
    rows = [row for row in report.samples if role in (None, roles[row.placement])]
    return np.array([row.error(model) for row in rows])


def errors_in_3d(report: ReportDocument) -> Plot:
    """Every sample round its socket, nominal and calibrated side by side, to one scale."""
    largest = _largest(report)
    names = [row.name for row in report.placements]
    return plot(
        "errors-3d",
        layout="scenes",
        scene="errors",
        controls={
            "placements": list(enumerate(names)),
            "half": nice_above(max(*largest, 1e-6), FINE),
        },
        report=report,
        largest=largest,
    )


def _largest(report: ReportDocument) -> list[float]:
    """Return the largest error of a sample, by the nominal model and as loaded [m]."""
    return [float(_lengths(report, m).max(initial=0.0)) for m, _ in LOADED]


class _View(NamedTuple):
    """Errors of a model as far as they are within half the panel's width [m], under a title."""

    model: ModelName
    half: float
    title: str


def errors_in_2d(report: ReportDocument) -> Plot:
    """Every sample round its socket, seen along two axes."""
    halves = [nice_above(max(error, 1e-9), FINE) for error in _largest(report)]
    large, small = halves
    limit = report.limits.mean_absolute_error.value
    if limit and limit < 1.4 * small:  # it is drawn, all of it
        small = max(small, nice_above(limit, FINE))
    large = max(large, small)
    times = float(f"{large / small:.2g}")
    views = (
        _View("nominal", large, "nominal"),
        _View("geometric", large, "calibrated"),
        _View("geometric", small, f"calibrated x {times:g}"),
    )
    sides = (("xy", "from above"), ("xz", "from the side"))
    panels = [
        _plane(report, view, axes, f"{side}: {view.title}")
        for (axes, side), view in product(sides, views)
    ]
    half = MM * small
    return plot(
        "errors-2d", *panels, layout="thirds", report=report, times=times, half=half
    )


def _plane(report: ReportDocument, view: _View, axes: str, title: str) -> Panel:
    """Return the samples along two axes, and the limit where it is within the panel."""
    half = view.half
    ticks = (0.0, half)
    scales = [Axis(-half, half, f"{axis}, mm", MM, ticks=ticks) for axis in axes]
    panel = Panel(title, *scales, width=248, height=276, margin=44).grid()
    mark = dict(LOADED)[view.model]
    i, j = map("xyz".index, axes)
    for row in report.samples:
        deviation = row.of(view.model)
        role = report.placements[row.placement].role
        panel.dot(deviation[i], deviation[j], f"{mark} {role}", size=2)
    limit = report.limits.mean_absolute_error.value
    if limit and limit <= half:
        panel.dot(0, 0, "threshold", size=panel.x(limit) - panel.x(0))
    return panel


def order(report: ReportDocument) -> Plot:
    """The calibrated error of each sample in the order of recording, and the running centre."""
    means = [row.calibrated.mean_absolute_error for row in report.placements]
    errors = _lengths(report, "calibrated")
    largest = float(errors.max(initial=1e-6))
    top = 1.08 * max(largest, FAR * max(means))
    uses = enumerate(report.answers.use.rows)
    panels = [_order_panel(report, i, use.name, top) for i, use in uses]
    mean_at_sample = np.array([means[row.placement] for row in report.samples])
    ratios = errors / np.maximum(mean_at_sample, 1e-12)
    return plot(
        "order",
        *panels,
        report=report,
        beyond=int(np.sum(ratios > FAR)),
        far=FAR,
        window=WINDOW,
        weighted=any(map(_is_doubted, report.samples)),
    )


def _is_doubted(sample: SampleErrors) -> bool:
    """Return True where the fit gave a sample less than half of its weight."""
    return sample.weight is not None and sample.weight < DOUBTED


def _order_panel(report: ReportDocument, i: int, name: str, top: float) -> Panel:
    """Return a placement's errors, socket by socket, each with its running centre."""
    place = report.placements[i]
    rows = [row for row in report.samples if row.placement == i]
    numbers = Axis(0, len(rows) + 1, ticks=())
    panel = Panel(name, numbers, Axis(0, top, "mm", MM), height=170).grid()
    limit = FAR * place.calibrated.mean_absolute_error
    panel.threshold(f"{FAR:g} x mean", y=limit)
    first = 0
    for socket in dict.fromkeys(row.socket for row in rows):
        deviations = np.array([row.calibrated for row in rows if row.socket == socket])
        if first:
            panel.rule("divide", x=first + 0.5)
        x = panel.x(first + 0.5) + 6
        panel.text(x, panel.bottom + 15, f"socket {socket}", "tick")
        panel.line(enumerate(_running_centre(deviations), first + 1), "running")
        first += len(deviations)
    for k, row in enumerate(rows, 1):
        mark = "flagged" if _is_doubted(row) else f"calibrated {place.role}"
        panel.dot(k, row.error(), mark, f"{row.where}: {MM * row.error():.3f} mm")
    return panel


def _running_centre(deviations: np.ndarray) -> list[float]:
    """Return the length of the mean deviation of the samples round each one."""
    half = WINDOW // 2
    samples = range(len(deviations))
    windows = [deviations[max(0, k - half) : k + half + 1] for k in samples]
    return [float(np.linalg.norm(window.mean(axis=0))) for window in windows]


def shares(report: ReportDocument) -> Plot:
    """Share of the samples within an error, and the task's tolerance."""
    role, _ = report.summary.judged
    words = ROLES[role].replace(" ", "-")
    errors = {mark: np.sort(_lengths(report, model, role)) for model, mark in LOADED}
    every_length = np.concatenate(list(errors.values()))
    x = Axis.logarithmic([report.task, *every_length], "error, mm", MM)
    y = Axis(0, 100, "% of samples")
    panel = Panel(f"{words} samples within an error", x, y).grid()
    for mark, lengths in errors.items():
        percents = np.linspace(0, 100, len(lengths) + 1)
        ends = [x.low, *lengths, x.high]
        curve = np.column_stack([ends, [*percents, 100]])
        panel.line(curve.tolist(), f"curve {mark}")
    panel.threshold("{} mm", x=report.task)
    return plot(
        "shares",
        panel,
        layout="half",
        report=report,
        words=words,
    )

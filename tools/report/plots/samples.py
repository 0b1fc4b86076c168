"""Plots of single samples: round their sockets, and in the order of recording."""

from collections.abc import Iterator

import numpy as np

from ....solver.assessment import ModelName, SampleErrors, mm, nice_above
from ..figures import FAR, ReportDocument
from .figure import Axis, Panel
from .plot import BOTH, HOLLOW, MODELS, Plot, lengths, names_of

WINDOW = 7
"""Samples in a running centre."""
FINE = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)


def errors_in_2d(report: ReportDocument) -> Plot:
    """Every sample round its socket, seen along two axes; for paper."""
    _, judged = report.summary.judged
    limit = report.limits.mean_absolute_error.value
    large, small = (
        nice_above(1e3 * float(lengths(report, model).max(initial=1e-6)), FINE) for model in MODELS
    )
    large = max(large, small)
    times = float(f"{large / small:.2g}")
    views: tuple[tuple[ModelName, float, str], ...] = (
        ("nominal", large, "nominal"),
        ("calibrated", large, "calibrated"),
        ("calibrated", small, f"calibrated x {times:g}"),
    )
    panels = [
        _plane(report, model, axes, half, f"{view}: {title}", limit)
        for axes, view in (((0, 1), "from above"), ((0, 2), "from the side"))
        for model, half, title in views
    ]
    medians = [judged.quantiles.of(model).median for model in MODELS]
    side = "inside" if limit and medians[1] <= limit else "outside"
    ring = f", {side} the dashed limit of {mm(limit)}" if limit else ""
    sentence = (
        f"The cloud round the sockets' centres shrinks from a median radius of {mm(medians[0])} to "
        f"{mm(medians[1])}{ring}; enlarged {times:g} times, all of it is within "
        f"{small:g} mm of the centre."
    )
    return Plot(
        "errors-2d",
        "The error of every sample, flat",
        sentence,
        tuple(panels),
        (*BOTH, HOLLOW),
        "thirds",
    )


def _plane(
    report: ReportDocument,
    model: ModelName,
    axes: tuple[int, int],
    half: float,
    title: str,
    limit: float | None,
) -> Panel:
    ticks = (-half, 0.0, half)
    names = ["x", "y", "z"]
    panel = Panel(
        title,
        Axis(-half, half, f"{names[axes[0]]}, mm", ticks=ticks),
        Axis(-half, half, f"{names[axes[1]]}, mm", ticks=ticks),
        width=248,
        height=276,
        left=44,
    ).grid()
    for row in report.samples:
        a, b = (1e3 * row.of(model)[k] for k in axes)
        role = report.placements[row.placement].role
        panel.dot(a, b, f"{model} {role}", size=2)
    if limit:
        radius = 1e3 * limit * (panel.right - panel.left) / (2 * half)
        if radius < 0.7 * (panel.right - panel.left):
            panel.add("circle", cx=panel.x(0), cy=panel.y(0), r=radius, class_="threshold")
    return panel


def order(report: ReportDocument) -> Plot:
    """The calibrated error of each sample in the order of recording, and the running centre."""
    largest = float(lengths(report, "calibrated").max(initial=1e-6))
    means = [row.calibrated.mean_absolute_error for row in report.placements]
    top = 1.08e3 * max(largest, FAR * max(means))
    panels = [_order_panel(report, i, name, top) for i, name in enumerate(names_of(report))]
    worst = report.answers.data.worst[0]
    ratios = list(_ratios(report))
    beyond = sum(ratio > FAR for ratio in ratios)
    sentence = (
        f"The farthest sample is {worst.where}, {mm(worst.error)} from its socket and "
        f"{worst.ratio:.1f} times its placement's mean; {beyond or 'none'} of {len(ratios)} "
        f"{'is' if beyond == 1 else 'are'} beyond the dashed {FAR:g} times the mean, and a moved "
        "base would lift the line of the running centre."
    )
    marks = (("calibrated", "error"), ("running", f"centre of {WINDOW} samples, from the socket's"))
    weighted = any(map(_doubted, report.samples))
    return Plot(
        "order",
        "In the order of recording",
        sentence,
        tuple(panels),
        (*marks, ("flagged", "weight below a half")) if weighted else marks,
    )


def _ratios(report: ReportDocument) -> Iterator[float]:
    """Yield each sample's calibrated error by the mean error of its placement."""
    for row in report.samples:
        mean = report.placements[row.placement].calibrated.mean_absolute_error
        yield row.error() / max(mean, 1e-12)


def _doubted(sample: SampleErrors) -> bool:
    """Return True where the fit gave a sample less than half of its weight."""
    return sample.weight is not None and sample.weight < 0.5


def _order_panel(report: ReportDocument, i: int, name: str, top: float) -> Panel:
    place = report.placements[i]
    rows = [row for row in report.samples if row.placement == i]
    panel = Panel(name, Axis(0, len(rows) + 1, ticks=()), Axis(0, top, "mm"), height=170)
    panel.grid(vertical=False)
    mean = 1e3 * place.calibrated.mean_absolute_error
    panel.threshold(FAR * mean, f"{FAR:g} x mean")
    first = 0
    for socket in dict.fromkeys(row.socket for row in rows):
        part = np.array([row.calibrated for row in rows if row.socket == socket])
        if first:
            panel.vertical(first + 0.5, "divide")
        panel.text(panel.x(first + 0.5) + 6, panel.bottom + 15, f"socket {socket}", "tick")
        centres = 1e3 * np.sqrt(np.sum(_running_centre(part) ** 2, axis=1))
        panel.line([(first + 1 + k, v) for k, v in enumerate(centres.tolist())], "running")
        first += len(part)
    for k, row in enumerate(rows, 1):
        error = 1e3 * row.error()
        mark = "flagged" if _doubted(row) else f"calibrated {place.role}"
        panel.dot(k, error, mark, f"{row.where}: {error:.3f} mm")
    return panel


def _running_centre(deviations: np.ndarray) -> np.ndarray:
    """Return the mean deviation of the samples round each one, shape (N, 3)."""
    half = WINDOW // 2
    count = len(deviations)
    return np.array(
        [deviations[max(0, k - half) : k + half + 1].mean(axis=0) for k in range(count)]
    )

"""Plots of the fit: training curves, cross-placement matrix, known distances, prediction."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ....solver.assessment import short_names
from ..figures import ReportDocument
from .axis import MM, Axis
from .figure import LINE, LOADED, Panel, Plot, named_rows, plot

_SMALLEST = 1e-6
"""Below this the curves are not followed [m]."""
_LARGEST_CELL = 46
"""Of the cross-placement matrix, in the panel's units; it is as wide as 290 at most."""
Curve = list[tuple[int, float]]
"""Iteration, and root of a term of Eq. (5) [m]."""


def history(report: ReportDocument) -> Plot | None:
    """Inconsistency and distortion over the iterations, as lengths, on a logarithmic scale."""
    rows = report.history
    if not rows:
        return None
    held_out = rows[0].test is not None
    roles = ("train", "test") if held_out else ("train",)
    repeatability = report.limits.repeatability

    def curve(term: str, role: str) -> Curve:
        parts = [(row.iteration, getattr(row, role)) for row in rows]
        squares = [(k, getattr(part, term)) for k, part in parts if part is not None]
        return [(k, max(square**0.5, _SMALLEST)) for k, square in squares]

    panels: list[Panel] = []
    ends: list[tuple[str, float, float]] = []
    for term in ("inconsistency", "distortion"):
        curves = {role: curve(term, role) for role in roles}
        panels.append(_curves_panel(term, curves, repeatability))
        last_curve = curves[roles[-1]]
        ends.append((term, MM * last_curve[0][1], MM * last_curve[-1][1]))
    return plot(
        "history",
        *panels,
        report=report,
        ends=ends,
        held_out=held_out,
    )


def _curves_panel(
    term: str, curves: Mapping[str, Curve], repeatability: float | None
) -> Panel:
    """Return the curves of a term, and the arm's repeatability [m] where it is known."""
    values = [value for curve in curves.values() for _, value in curve]
    last = max(curves["train"][-1][0], 1)
    ticks = tuple(range(0, last + 1, max(1, last // 6)))
    iterations = Axis(0, last, "iteration", ticks=ticks)
    lengths = Axis.logarithmic([*values, repeatability], "mm", MM)
    panel = Panel(f"{term}, root mean square", iterations, lengths).grid()
    for role, curve in curves.items():
        panel.line(curve, f"curve {role}")
        size = 3.0 if len(curve) < 12 else 1.5
        for iteration, value in curve:
            panel.dot(
                iteration, value, f"curve-dot {role}", f"{MM * value:.4f} mm", size
            )
    if repeatability:
        ratios = [curve[-1][1] / repeatability for curve in curves.values()]
        nearest = min(ratios, key=lambda ratio: abs(math.log(ratio)))
        words = "the arm's repeatability, {} mm"
        panel.threshold(words, y=repeatability, below=nearest > 1)
    return panel


def cross_placement(report: ReportDocument) -> Plot | None:
    """Error at each placement after training on one alone: the paper's Fig. 6."""
    matrix = report.cross_placement
    if matrix is None or not any(matrix.matrix):
        return None
    names = short_names(matrix.names)
    errors = {i: row for i, row in enumerate(matrix.matrix) if row is not None}
    means: list[tuple[float, str]] = []
    for i, row in errors.items():
        others = np.delete(row, i)
        means.append((float(np.mean(others)), names[i]))
    limit = report.limits.mean_absolute_error.value
    return plot(
        "cross-placement",
        _matrix_panel(names, errors, limit or math.inf),
        layout="half",
        report=report,
        means=means,
        failed=len(names) - len(means),
    )


def _matrix_panel(
    names: Sequence[str], errors: Mapping[int, Sequence[float]], limit: float
) -> Panel:
    """Return a cell for each pair of placements, the darker the larger the error [m]."""
    size = min(float(_LARGEST_CELL), 290.0 / len(names))
    title = "rows: trained on; columns: error there, mm"
    panel = named_rows(title, names, Axis(0, 1), pitch=size, without_axis=True)
    logs = np.log(np.maximum(list(errors.values()), 1e-9))
    shades = (logs - logs.min()) / max(np.ptp(logs), 1e-9)
    for (i, row), row_of_shades in zip(errors.items(), shades.tolist(), strict=True):
        y = panel.y(i)
        for j, (value, shade) in enumerate(zip(row, row_of_shades, strict=True)):
            x = panel.left + (j + 0.5) * size
            number = MM * value
            hint = f"trained on {names[i]}, error at {names[j]}: {number:.3f} mm"
            opacity = 0.06 + 0.8 * shade
            panel.square(x, y, size, hint, class_="cell", fill_opacity=opacity)
            if i == j:
                panel.square(x, y, size, fill="url(#hatch)")
            if value > limit:
                panel.square(x, y, size - 4, class_="threshold")
            if size > 24:
                inverse = "light" if shade > 0.6 else ""
                panel.text(x, y + 4, f"{number:.2f}", f"number middle {inverse}")
    step = math.ceil(LINE / (size * math.sin(math.radians(24))))
    y = panel.bottom + 12
    for j in range(0, len(names), step):
        x = panel.left + (j + 0.5) * size - 6
        panel.text(x, y, names[j][:14], "tick", transform=f"rotate(24 {x} {y})")
    return panel


def known_distances(report: ReportDocument) -> Plot | None:
    """Errors of distances that were measured from outside, and the limit."""
    rows = report.between
    if not rows:
        return None
    ends = short_names([end for row in rows for end in (row.a, row.b)])
    names = [f"{a} to {b}" for a, b in zip(ends[::2], ends[1::2], strict=True)]
    errors = {mark: [row.errors.of(model) for row in rows] for model, mark in LOADED}
    limit = report.limits.between_placements.value
    values = [*errors["nominal"], *errors["calibrated"], limit]
    axis = Axis.around_zero(values, "mm", MM, smallest=1e-5)
    panel = named_rows("predicted less known distance", names, axis, pitch=22)
    panel.rule("zero", x=0)
    for mark, lengths in errors.items():
        panel.dots(lengths, f"{mark} test", mark, "+.3f", size=4)
    panel.thresholds("limit {} mm", limit)
    return plot(
        "known-distances",
        panel,
        layout="half",
        report=report,
        means=[float(np.mean(np.abs(lengths))) for lengths in errors.values()],
        worst=max(
            zip(errors["calibrated"], names, strict=True), key=lambda row: abs(row[0])
        ),
    )


def predicted_and_found(report: ReportDocument) -> Plot | None:
    """The spread predicted at each placement beside the one found there."""
    rows = [
        row
        for row in report.placements
        if row.predicted_deviation and row.found_deviation
    ]
    if not rows:
        return None
    names = short_names([row.name for row in rows])
    predicted = [row.predicted_deviation or 0.0 for row in rows]
    found = [row.found_deviation or 0.0 for row in rows]
    repeatability = report.limits.repeatability
    axis = Axis.from_zero([*predicted, *found, repeatability], "mm, 1 sigma", MM, 1.15)
    panel = named_rows("spread of the ball's positions", names, axis, pitch=28)
    panel.bars(predicted, found, "link")
    panel.dots(predicted, "predicted", "predicted")
    panel.dots(found, [f"calibrated {row.role}" for row in rows], "found")
    panel.threshold("the arm repeats to {} mm", x=repeatability)
    ratios = np.divide(found, predicted).tolist()
    return plot(
        "predicted-found",
        panel,
        layout="half",
        report=report,
        ratios=list(zip(ratios, names, strict=True)),
    )

"""Plots of the fit: training curves, cross-placement matrix, known distances, prediction."""

import math
from collections.abc import Mapping, Sequence
from itertools import chain, product
from typing import Any

import numpy as np

from ....solver.assessment import short_names
from ..figures import ReportDocument
from .axis import Axis
from .figure import LINE, LOADED, Panel, Plot, full_model, in_mm, named_rows, plot

_SMALLEST = 1e-3
"""Below this the curves are not followed [mm]."""
_LARGEST_CELL = 46
"""Of the cross-placement matrix, in the panel's units; it is as wide as 290 at most."""
_TERMS = ("inconsistency", "distortion")
"""Of Eq. (5)."""
Curve = list[tuple[float, float]]
"""Iteration, and root of a term [mm]."""


def history(report: ReportDocument) -> Plot | None:
    """Inconsistency and distortion over the iterations, as lengths, on a logarithmic scale."""
    rows = report.history
    if not rows:
        return None
    roles = ["train"] if rows[0].test is None else ["train", "test"]

    def curve(term: str, role: str) -> Curve:
        parts = [(float(row.iteration), getattr(row, role)) for row in rows]
        squares = [(k, getattr(part, term)) for k, part in parts if part is not None]
        return [(k, max(1e3 * square**0.5, _SMALLEST)) for k, square in squares]

    repeatability = in_mm(report.limits.repeatability)
    panels: list[Panel] = []
    ends: list[tuple[str, float, float]] = []
    for term in _TERMS:
        curves = {role: curve(term, role) for role in roles}
        panels.append(_curves_panel(term, curves, repeatability))
        values = [value for _, value in curves[roles[-1]]]
        ends.append((term, values[0], values[-1]))
    return plot(
        "history",
        *panels,
        model=full_model(report),
        iterations=rows[-1].iteration,
        ends=ends,
        held_out=rows[0].test is not None,
        repeatability=repeatability,
    )


def _curves_panel(term: str, curves: Mapping[str, Curve], repeatability: float) -> Panel:
    """Return the curves of a term, and the arm's repeatability [mm] where it is known."""
    values = [value for _, value in chain(*curves.values())]
    values += [repeatability] if repeatability else []
    last = max(curves["train"][-1][0], 1.0)
    ticks = tuple(float(k) for k in range(0, int(last) + 1, max(1, int(last) // 6)))
    iterations = Axis(0, last, "iteration", ticks=ticks)
    panel = Panel(f"{term}, root mean square", iterations, Axis.logarithmic(values, "mm")).grid()
    for role, curve in curves.items():
        panel.line(curve, f"curve {role}")
        for iteration, value in curve:
            size = 3.0 if len(curve) < 12 else 1.5
            panel.dot(iteration, value, f"curve-dot {role}", f"{value:.4f} mm", size)
    if repeatability:
        ratios = [curve[-1][1] / repeatability for curve in curves.values()]
        nearest = min(ratios, key=lambda ratio: abs(math.log(ratio)))
        words = f"the arm's repeatability, {repeatability:g} mm"
        panel.threshold(words, y=repeatability, below=nearest > 1)
    return panel


def cross_placement(report: ReportDocument) -> Plot | None:
    """Error at each placement after training on one alone: the paper's Fig. 6."""
    matrix = report.cross_placement
    if matrix is None or not any(matrix.matrix):
        return None
    names = short_names(matrix.names)
    rows = {i: row for i, row in enumerate(matrix.matrix) if row is not None}
    errors = {i: [max(1e3 * error, 1e-6) for error in row] for i, row in rows.items()}
    means = [(float(np.mean(np.delete(row, i))), names[i]) for i, row in errors.items()]
    limit = 1e3 * (report.limits.mean_absolute_error.value or math.inf)
    panel = _matrix_panel(names, errors, limit)
    values: dict[str, Any] = {"means": means, "failed": len(names) - len(means), "limit": limit}
    return plot("cross-placement", panel, layout="half", method=matrix.method, **values)


def _matrix_panel(
    names: Sequence[str], errors: Mapping[int, Sequence[float]], limit: float
) -> Panel:
    """Return a cell for each pair of placements, the darker the larger the error [mm]."""
    size = min(float(_LARGEST_CELL), 290.0 / len(names))
    title = "rows: trained on; columns: error there, mm"
    panel = named_rows(title, names, Axis(0, 1), pitch=size, without_axis=True)
    logs = np.log(list(errors.values()))
    low = logs.min()
    span = max(np.ptp(logs), 1e-9)
    for i, j in product(errors, range(len(names))):
        value = errors[i][j]
        shade = float((math.log(value) - low) / span)
        x = panel.left + j * size
        y = panel.y(i)
        box = {"x": x, "y": y - size / 2, "width": size, "height": size}
        hint = f"trained on {names[i]}, error at {names[j]}: {value:.3f} mm"
        panel.add("rect", hint, **box, class_="cell", fill_opacity=0.06 + 0.8 * shade)
        if i == j:
            panel.add("rect", **box, fill="url(#hatch)")
        if value > limit:
            inner = {"x": x + 2, "y": y - size / 2 + 2, "width": size - 4, "height": size - 4}
            panel.add("rect", **inner, class_="threshold")
        if size > 24:
            inverse = "light" if shade > 0.6 else ""
            panel.text(x + size / 2, y + 4, f"{value:.2f}", f"number middle {inverse}")
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
    ends = short_names(list(chain.from_iterable((row.a, row.b) for row in rows)))
    names = [f"{a} to {b}" for a, b in zip(ends[::2], ends[1::2], strict=True)]
    errors = {mark: [1e3 * row.errors.of(model) for row in rows] for model, mark in LOADED}
    limit = in_mm(report.limits.between_placements.value)
    axis = Axis.around_zero([*errors["nominal"], *errors["calibrated"], limit], "mm", smallest=0.01)
    panel = named_rows("predicted less known distance", names, axis, pitch=22)
    panel.rule("zero", x=0)
    for mark, values in errors.items():
        panel.dots(values, f"{mark} test", mark, "+.3f", size=4)
    panel.thresholds(f"limit {limit:g} mm", limit)
    means = [float(np.mean(np.abs(values))) for values in errors.values()]
    worst = max(zip(errors["calibrated"], names, strict=True), key=lambda row: abs(row[0]))
    return plot("known-distances", panel, layout="half", count=len(rows), means=means, worst=worst)


def predicted_and_found(report: ReportDocument) -> Plot | None:
    """The spread predicted at each placement beside the one found there."""
    rows = [row for row in report.placements if row.predicted_deviation and row.found_deviation]
    if not rows:
        return None
    names = short_names([row.name for row in rows])
    predicted = [in_mm(row.predicted_deviation) for row in rows]
    errors = [in_mm(row.found_deviation) for row in rows]
    repeatability = in_mm(report.limits.repeatability)
    axis = Axis(0, 1.15 * max(*predicted, *errors, repeatability), "mm, 1 sigma")
    panel = named_rows("spread of the ball's positions", names, axis, pitch=28)
    panel.bars(predicted, errors, "link")
    panel.dots(predicted, "predicted", "predicted")
    panel.dots(errors, [f"calibrated {row.role}" for row in rows], "found")
    panel.threshold(f"the arm repeats to {repeatability:g} mm", x=repeatability or None)
    ratios = [(b / a, name) for a, b, name in zip(predicted, errors, names, strict=True)]
    values: dict[str, Any] = {"ratios": ratios, "repeatability": repeatability}
    return plot("predicted-found", panel, layout="half", model=full_model(report), **values)

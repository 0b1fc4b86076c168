"""Plots of the fit: training curves, cross-placement matrix, known distances, prediction."""

import math
from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np

from ....solver.assessment import short_names
from ..figures import CrossPlacement, ReportDocument
from .axis import MM, Axis
from .figure import LINE, LOADED, Plot, named_rows, plot
from .panel import Panel

_SMALLEST = 1e-6
"""Below this the curves are not followed [m]."""
_LARGEST_CELL = 46.0
"""Of the cross-placement matrix, in the panel's units."""
_WIDEST = 290.0
"""The whole matrix."""
_TILT = 24
"""Of the names below its columns [degrees]."""
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
    panels: list[Panel] = []
    ends: list[tuple[str, float, float]] = []
    for term in ("inconsistency", "distortion"):
        curves = {role: _curve(report, term, role) for role in roles}
        panels.append(_curves_panel(term, curves, repeatability))
        judged = curves[roles[-1]]
        ends.append((term, MM * judged[0][1], MM * judged[-1][1]))
    return plot(
        "history",
        *panels,
        report=report,
        ends=ends,
        held_out=held_out,
    )


def _curve(report: ReportDocument, term: str, role: str) -> Curve:
    """Return the root of a term over the iterations, on the placements of a role."""
    parts = [(row.iteration, getattr(row, role)) for row in report.history]
    return [
        (iteration, max(getattr(part, term), _SMALLEST**2) ** 0.5)
        for iteration, part in parts
        if part
    ]


def _curves_panel(
    term: str,
    curves: Mapping[str, Curve],
    repeatability: float | None,
) -> Panel:
    """Return the curves of a term, and the arm's repeatability [m] where it is known."""
    values = [value for _, value in chain(*curves.values())]
    last = max(curves["train"][-1][0], 1)
    ticks = tuple(range(0, last + 1, max(1, last // 6)))
    iterations = Axis(0, last, "iteration", ticks=ticks)
    lengths = Axis.logarithmic([*values, repeatability], "mm", MM)
    panel = Panel(f"{term}, root mean square", iterations, lengths).grid()
    for role, curve in curves.items():
        panel.line(curve, f"curve {role}")
        size = 3.0 if len(curve) < 12 else 1.5
        for iteration, value in curve:
            mark = f"curve-dot {role}"
            panel.dot(
                iteration,
                value,
                mark,
                f"{MM * value:.4f} mm",
                size,
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
    means = [
        (float(np.mean(np.delete(row, i))), names[i])
        for i, row in enumerate(matrix.matrix)
        if row is not None
    ]
    limit = report.limits.mean_absolute_error.value
    return plot(
        "cross-placement",
        _matrix_panel(matrix, limit or math.inf),
        layout="half",
        report=report,
        means=means,
        failed=len(names) - len(means),
    )


def _matrix_panel(matrix: CrossPlacement, limit: float) -> Panel:
    """Return a cell for each pair of placements, the darker the larger the error [m]."""
    names = short_names(matrix.names)
    size = min(_LARGEST_CELL, _WIDEST / len(names))
    title = "rows: trained on; columns: error there, mm"
    panel = named_rows(
        title,
        names,
        Axis(0, 1),
        pitch=size,
        without_axis=True,
    )
    errors = {i: row for i, row in enumerate(matrix.matrix) if row is not None}
    logs = np.log(np.maximum(list(errors.values()), 1e-9))
    shades = (logs - logs.min()) / max(np.ptp(logs), 1e-9)
    for (i, row), row_of_shades in zip(errors.items(), shades.tolist(), strict=True):
        for j, (error, shade) in enumerate(zip(row, row_of_shades, strict=True)):
            hint = f"trained on {names[i]}, error at {names[j]}: {MM * error:.3f} mm"
            x = panel.left + (j + 0.5) * size
            y = panel.y(i)
            opacity = 0.06 + 0.8 * shade
            panel.square(
                x,
                y,
                size,
                hint,
                class_="cell",
                fill_opacity=opacity,
            )
            if i == j:
                panel.square(x, y, size, fill="url(#hatch)")
            if error > limit:
                panel.square(x, y, size - 4, class_="threshold")
            if size > 24:
                inverse = "light" if shade > 0.6 else ""
                panel.text(x, y + 4, f"{MM * error:.2f}", f"number middle {inverse}")
    _name_columns(panel, names, size)
    return panel


def _name_columns(panel: Panel, names: Sequence[str], size: float) -> None:
    """Write the names of columns of a width below them, tilted, as many as there is room for."""
    step = math.ceil(LINE / (size * math.sin(math.radians(_TILT))))
    y = panel.bottom + 12
    for j in range(0, len(names), step):
        x = panel.left + (j + 0.5) * size - 6
        turn = f"rotate({_TILT} {x} {y})"
        panel.text(x, y, names[j][:14], "tick", transform=turn)


def known_distances(report: ReportDocument) -> Plot | None:
    """Errors of distances that were measured from outside, and the limit."""
    rows = report.between
    if not rows:
        return None
    ends = short_names(list(chain.from_iterable((row.a, row.b) for row in rows)))
    pairs = zip(ends[::2], ends[1::2], strict=True)
    names = [f"{a} to {b}" for a, b in pairs]
    errors = {mark: [row.errors.of(model) for row in rows] for model, mark in LOADED}
    limit = report.limits.between_placements.value
    values = [*errors["nominal"], *errors["calibrated"], limit]
    axis = Axis.around_zero(values, "mm", MM, smallest=1e-5)
    panel = named_rows("predicted less known distance", names, axis, pitch=22)
    panel.rule("zero", x=0)
    for mark, lengths in errors.items():
        panel.dots(
            lengths,
            f"{mark} test",
            mark,
            "+.3f",
            size=4,
        )
    panel.thresholds("limit {} mm", limit)
    calibrated = zip(errors["calibrated"], names, strict=True)
    means = [float(np.mean(np.abs(lengths))) for lengths in errors.values()]
    return plot(
        "known-distances",
        panel,
        layout="half",
        report=report,
        means=means,
        worst=max(calibrated, key=lambda row: abs(row[0])),
    )


def predicted_and_found(report: ReportDocument) -> Plot | None:
    """The spread predicted at each placement beside the one found there."""
    rows = [
        (row, row.predicted_deviation, row.found_deviation)
        for row in report.placements
        if row.predicted_deviation and row.found_deviation
    ]
    if not rows:
        return None
    placements, predicted, observed = zip(*rows, strict=True)
    names = short_names([row.name for row in placements])
    repeatability = report.limits.repeatability
    lengths = [*predicted, *observed, repeatability]
    axis = Axis.from_zero(lengths, "mm, 1 sigma", MM, 1.15)
    panel = named_rows("spread of the ball's positions", names, axis, pitch=28)
    panel.bars(predicted, observed, "link")
    panel.dots(predicted, "predicted", "predicted")
    panel.dots(observed, [f"calibrated {row.role}" for row in placements], "found")
    panel.threshold("the arm repeats to {} mm", x=repeatability)
    ratios = list(zip(np.divide(observed, predicted).tolist(), names, strict=True))
    return plot(
        "predicted-found",
        panel,
        layout="half",
        report=report,
        ratios=ratios,
    )

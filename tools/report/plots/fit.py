"""Plots of the fit: training curves, cross-placement matrix, known distances, prediction."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np

from ....solver.assessment import joined, mm, plural, short_names
from ....solver.results import Iteration, Role
from ..figures import CrossPlacement, ReportDocument
from .figure import LINE, Axis, Panel, Rows, element
from .plot import BOTH, HOLLOW, MODELS, Plot

_SMALLEST = 1e-3
"""Below this the curves are not followed [mm]."""
Term = Literal["inconsistency", "distortion"]
_TERMS: tuple[Term, Term] = ("inconsistency", "distortion")
_ROLES: tuple[Role, Role] = ("train", "test")


def history(report: ReportDocument) -> Plot | None:
    """Inconsistency and distortion over the iterations, as lengths, on a logarithmic scale."""
    rows = report.history
    if not rows:
        return None
    repeatability = report.limits.repeatability
    panels = [_curves(rows, term, repeatability) for term in _TERMS]
    return Plot(
        "history",
        "Training curves",
        _history_sentence(rows, repeatability),
        tuple(panels),
        (("line train", "trained on"), ("line test", "held out")),
    )


def _lengths(rows: Sequence[Iteration], role: Role, term: Term) -> list[tuple[float, float]]:
    """Return iteration and root of a term of Eq. (5) [mm]."""
    roles = [(float(row.iteration), row.train if role == "train" else row.test) for row in rows]
    return [(k, 1e3 * getattr(terms, term) ** 0.5) for k, terms in roles if terms is not None]


def _curves(rows: Sequence[Iteration], term: Term, repeatability: float | None) -> Panel:
    curves = {
        role: [(k, max(value, _SMALLEST)) for k, value in _lengths(rows, role, term)]
        for role in _ROLES
    }
    values = [value for curve in curves.values() for _, value in curve]
    if repeatability:
        values.append(1e3 * repeatability)
    last = max(float(rows[-1].iteration), 1.0)
    ticks = tuple(float(k) for k in range(0, int(last) + 1, max(1, int(last) // 6)))
    panel = Panel(
        f"{term}, root mean square",
        Axis(0, last, "iteration", ticks=ticks),
        Axis(min(values) / 1.5, max(values) * 1.5, "mm", log=True),
    ).grid()
    dot = 3.0 if len(rows) < 12 else 1.5
    for role, curve in curves.items():
        if curve:
            panel.line(curve, f"curve {role}")
            for iteration, value in curve:
                panel.dot(iteration, value, f"curve-dot {role}", f"{value:.4f} mm", size=dot)
    if repeatability:
        words = f"the arm's repeatability, {1e3 * repeatability:g} mm"
        ends = [curve[-1][1] / (1e3 * repeatability) for curve in curves.values() if curve]
        nearest = min(ends, key=lambda ratio: abs(np.log(ratio)))
        panel.threshold(1e3 * repeatability, words, below=nearest > 1)
    return panel


def _history_sentence(rows: Sequence[Iteration], repeatability: float | None) -> str:
    held_out = rows[0].test is not None
    words = "held out" if held_out else "trained on"
    curves = {term: _lengths(rows, "test" if held_out else "train", term) for term in _TERMS}
    parts = [
        f"{term} falls from {curve[0][1]:.2f} to {curve[-1][1]:.2f} mm"
        for term, curve in curves.items()
    ]
    tail = ""
    if repeatability:
        times = curves["inconsistency"][-1][1] / (1e3 * repeatability)
        tail = f"; what stays is {times:.1f} times the arm's repeatability (dashed)"
    steps = plural(rows[-1].iteration, "iteration")
    return f"Over {steps} the {joined(parts)} on the placements {words}{tail}."


def cross_placement(report: ReportDocument) -> Plot | None:
    """Trained on which placement alone, error where: the paper's Fig. 6."""
    matrix = report.cross_placement
    if matrix is None:
        return None
    names = short_names(matrix.names)
    rows = [(i, row) for i, row in enumerate(matrix.matrix) if row is not None]
    cells = {(i, j): max(1e3 * error, 1e-6) for i, row in rows for j, error in enumerate(row)}
    if not cells:
        return None
    return Plot(
        "cross-placement",
        "Trained on one, tried on the others",
        _matrix_sentence(matrix, names, cells, [i for i, _ in rows]),
        (_cells(names, cells),),
        (("hatched", "hatched: trained on"),),
        "half",
    )


def _matrix_sentence(
    matrix: CrossPlacement,
    names: Sequence[str],
    cells: dict[tuple[int, int], float],
    fitted: Sequence[int],
) -> str:
    means = {i: float(np.mean([cells[i, j] for j in range(len(names)) if j != i])) for i in fitted}
    best, worst = min(means, key=lambda i: means[i]), max(means, key=lambda i: means[i])
    failed = len(names) - len(fitted)
    tail = f"; {plural(failed, 'placement')} cannot be fitted alone" if failed else ""
    return (
        f"By {matrix.method} on one placement alone, {names[best]} teaches most about the "
        f"others ({means[best]:.2f} mm on average) and {names[worst]} least "
        f"({means[worst]:.2f} mm){tail}."
    )


def _cells(names: Sequence[str], cells: dict[tuple[int, int], float]) -> Panel:
    size = min(46.0, 290.0 / len(names))
    panel = Rows(
        "rows: trained on; columns: error there, mm", names, Axis(0, 1), pitch=size, bare=True
    )
    low, high = min(cells.values()), max(cells.values())
    for (i, j), value in cells.items():
        shade = float((np.log(value) - np.log(low)) / max(np.log(high / low), 1e-9))
        x, y = panel.left + j * size, panel.row(i) - size / 2
        hint = f"trained on {names[i]}, error at {names[j]}: {value:.3f} mm"
        box = {"x": x, "y": y, "width": size, "height": size}
        panel.add("rect", hint, **box, class_="cell", fill_opacity=0.06 + 0.8 * shade)
        if i == j:
            panel.add("rect", **box, fill="url(#hatch)")
        if size > 24:
            inverse = "light" if shade > 0.6 else ""
            panel.text(x + size / 2, y + size / 2 + 4, f"{value:.2f}", f"number middle {inverse}")
    every = math.ceil(LINE / (size * math.sin(math.radians(24))))
    for j, name in list(enumerate(names))[::every]:
        x, y = panel.left + (j + 0.5) * size - 6, panel.bottom + 12
        turned = f"rotate(24 {x} {y})"
        panel.parts.append(element("text", name[:14], x=x, y=y, class_="tick", transform=turned))
    return panel


def known_distances(report: ReportDocument) -> Plot | None:
    """Errors of distances that were measured from outside, and the limit."""
    rows = report.between
    if not rows:
        return None
    ends = short_names([end for row in rows for end in (row.a, row.b)])
    names = [f"{a} to {b}" for a, b in zip(ends[::2], ends[1::2], strict=True)]
    errors = [1e3 * row.error(model) for row in rows for model in MODELS]
    limit = report.limits.between_placements.value
    half = 1.1 * max(*(abs(e) for e in errors), 1e3 * (limit or 0), 0.01)
    panel = Rows("predicted less known distance", names, Axis(-half, half, "mm"), pitch=22)
    panel.vertical(0, "zero")
    for i, row in enumerate(rows):
        for model in MODELS:
            value = 1e3 * row.error(model)
            hint = f"{names[i]}, {model}: {value:+.3f} mm"
            panel.mark(i, value, f"{model} test", hint, size=4)
    for side in (-1, 1):
        if limit:
            words = f"limit {1e3 * limit:g} mm" if side > 0 else ""
            panel.upright_threshold(side * 1e3 * limit, words)
    means = [mm(float(np.mean([abs(row.error(m)) for row in rows]))) for m in MODELS]
    i = int(np.argmax([abs(row.calibrated_error) for row in rows]))
    return Plot(
        "known-distances",
        "Distances between placements",
        f"Over {plural(len(rows), 'known distance')} the mean error falls from {means[0]} to "
        f"{means[1]}; the worst is {names[i]}, off by {mm(rows[i].calibrated_error)}.",
        (panel,),
        BOTH,
        "half",
    )


def predicted_and_found(report: ReportDocument) -> Plot | None:
    """The spread predicted at each placement beside the one found there."""
    rows = [
        (row, 1e3 * row.predicted_deviation, 1e3 * row.found_deviation)
        for row in report.placements
        if row.predicted_deviation and row.found_deviation
    ]
    if not rows:
        return None
    names = short_names([row.name for row, _, _ in rows])
    high = 1.15 * max(max(predicted, measured) for _, predicted, measured in rows)
    panel = Rows("spread of the ball's positions", names, Axis(0, high, "mm, 1 sigma"), pitch=28)
    for i, (row, predicted, measured) in enumerate(rows):
        panel.span(i, predicted, measured, "link")
        panel.mark(i, predicted, "predicted", f"predicted {predicted:.3f} mm")
        hint = f"found {measured:.3f} mm"
        panel.mark(i, measured, f"calibrated {row.role}", hint)
    ratios = {
        name: measured / predicted
        for name, (_, predicted, measured) in zip(names, rows, strict=True)
    }
    worst = max(ratios, key=lambda name: ratios[name])
    return Plot(
        "predicted-found",
        "Predicted and found",
        f"What was found is {min(ratios.values()):.1f} to {max(ratios.values()):.1f} times what "
        f"the calibration predicts of itself, most at {worst}.",
        (panel,),
        (("predicted", "predicted"), ("calibrated", "found"), HOLLOW),
        "half",
    )

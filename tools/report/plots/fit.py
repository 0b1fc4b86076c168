"""Plots of the fit: training curves, cross-placement matrix, known distances, prediction."""

import math
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from ....solver.assessment import joined, mm, plural, short_names
from ....solver.results import Iteration, Role
from ..figures import CrossPlacement, ReportDocument
from .figure import LINE, Axis, Panel, named_rows
from .plot import BOTH, HOLLOW, MODELS, Plot

_SMALLEST = 1e-3
"""Below this the curves are not followed [mm]."""
_LARGEST_CELL = 46
"""Of the cross-placement matrix, in the panel's units; it is as wide as 290 at most."""
Term = Literal["inconsistency", "distortion"]
Curve = list[tuple[float, float]]
"""Iteration, and root of a term of Eq. (5) [mm]."""


def history(report: ReportDocument) -> Plot | None:
    """Inconsistency and distortion over the iterations, as lengths, on a logarithmic scale."""
    rows = report.history
    if not rows:
        return None
    terms: tuple[Term, Term] = ("inconsistency", "distortion")
    curves = {term: {"train": _curve(rows, "train", term)} for term in terms}
    if rows[0].test is not None:
        for term in terms:
            curves[term]["test"] = _curve(rows, "test", term)
    judged, words = ("train", "trained on") if rows[0].test is None else ("test", "held out")
    ends = {term: (curves[term][judged][0][1], curves[term][judged][-1][1]) for term in terms}
    falls = [f"{term} falls from {a:.2f} to {b:.2f} mm" for term, (a, b) in ends.items()]
    repeatability = 1e3 * (report.limits.repeatability or 0)
    tail = ""
    if repeatability:
        times = ends["inconsistency"][1] / repeatability
        tail = f"; what stays is {times:.1f} times the arm's repeatability (dashed)"
    return Plot(
        "history",
        "Training curves",
        f"Over {plural(rows[-1].iteration, 'iteration')} the {joined(falls)} on the placements "
        f"{words}{tail}.",
        tuple(_curves_panel(term, curves[term], repeatability) for term in terms),
        (("line train", "trained on"), ("line test", "held out")),
    )


def _curve(rows: Sequence[Iteration], role: Role, term: Term) -> Curve:
    terms = [(float(row.iteration), row.train if role == "train" else row.test) for row in rows]
    return [(k, 1e3 * getattr(one, term) ** 0.5) for k, one in terms if one is not None]


def _curves_panel(term: Term, curves: Mapping[str, Curve], repeatability: float) -> Panel:
    """Return the curves of a term, and the arm's repeatability [mm] where it is known."""
    shown = {role: [(k, max(v, _SMALLEST)) for k, v in c] for role, c in curves.items()}
    values = [value for curve in shown.values() for _, value in curve]
    values += [repeatability] if repeatability else []
    last = max(curves["train"][-1][0], 1.0)
    ticks = tuple(float(k) for k in range(0, int(last) + 1, max(1, int(last) // 6)))
    panel = Panel(
        f"{term}, root mean square",
        Axis(0, last, "iteration", ticks=ticks),
        Axis.logarithmic(values, "mm"),
    ).grid()
    for role, curve in shown.items():
        panel.line(curve, f"curve {role}")
        for iteration, value in curve:
            size = 3.0 if len(curve) < 12 else 1.5
            panel.dot(iteration, value, f"curve-dot {role}", f"{value:.4f} mm", size)
    if repeatability:
        ratios = [curve[-1][1] / repeatability for curve in shown.values()]
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
    errors = {
        i: [max(1e3 * error, 1e-6) for error in row]
        for i, row in enumerate(matrix.matrix)
        if row is not None
    }
    return Plot(
        "cross-placement",
        "Trained on one, tried on the others",
        _matrix_sentence(matrix, names, errors),
        (_matrix_panel(names, errors),),
        (("hatched", "hatched: trained on"),),
        "half",
    )


def _matrix_sentence(
    matrix: CrossPlacement, names: Sequence[str], errors: Mapping[int, Sequence[float]]
) -> str:
    means = {
        i: float(np.mean([error for j, error in enumerate(row) if j != i]))
        for i, row in errors.items()
    }
    best, worst = min(means, key=lambda i: means[i]), max(means, key=lambda i: means[i])
    failed = len(names) - len(means)
    tail = f"; {plural(failed, 'placement')} cannot be fitted alone" if failed else ""
    return (
        f"By {matrix.method} on one placement alone, {names[best]} teaches most about the "
        f"others ({means[best]:.2f} mm on average) and {names[worst]} least "
        f"({means[worst]:.2f} mm){tail}."
    )


def _matrix_panel(names: Sequence[str], errors: Mapping[int, Sequence[float]]) -> Panel:
    """Return a cell for each pair of placements, the darker the larger the error [mm]."""
    size = min(float(_LARGEST_CELL), 290.0 / len(names))
    title = "rows: trained on; columns: error there, mm"
    panel = named_rows(title, names, Axis(0, 1), pitch=size, bare=True)
    low = math.log(min(min(row) for row in errors.values()))
    span = max(math.log(max(max(row) for row in errors.values())) - low, 1e-9)
    for i, j, value in ((i, j, value) for i, row in errors.items() for j, value in enumerate(row)):
        shade = (math.log(value) - low) / span
        x, y = panel.left + j * size, panel.y(i)
        box = {"x": x, "y": y - size / 2, "width": size, "height": size}
        hint = f"trained on {names[i]}, error at {names[j]}: {value:.3f} mm"
        panel.add("rect", hint, **box, class_="cell", fill_opacity=0.06 + 0.8 * shade)
        if i == j:
            panel.add("rect", **box, fill="url(#hatch)")
        if size > 24:
            inverse = "light" if shade > 0.6 else ""
            panel.text(x + size / 2, y + 4, f"{value:.2f}", f"number middle {inverse}")
    every = math.ceil(LINE / (size * math.sin(math.radians(24))))
    for j, name in list(enumerate(names))[::every]:
        x, y = panel.left + (j + 0.5) * size - 6, panel.bottom + 12
        panel.text(x, y, name[:14], "tick", transform=f"rotate(24 {x} {y})")
    return panel


def known_distances(report: ReportDocument) -> Plot | None:
    """Errors of distances that were measured from outside, and the limit."""
    rows = report.between
    if not rows:
        return None
    ends = short_names([end for row in rows for end in (row.a, row.b)])
    names = [f"{a} to {b}" for a, b in zip(ends[::2], ends[1::2], strict=True)]
    errors = [1e3 * row.error(model) for row in rows for model in MODELS]
    limit = 1e3 * (report.limits.between_placements.value or 0)
    axis = Axis.around_zero([*errors, limit], "mm", least=0.01)
    panel = named_rows("predicted less known distance", names, axis, pitch=22)
    panel.rule("zero", x=0)
    for i, row in enumerate(rows):
        for model in MODELS:
            value = 1e3 * row.error(model)
            hint = f"{names[i]}, {model}: {value:+.3f} mm"
            panel.dot(value, i, f"{model} test", hint, size=4)
    if limit:
        panel.threshold("", x=-limit)
        panel.threshold(f"limit {limit:g} mm", x=limit)
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
    axis = Axis(0, 1.15 * max(max(row[1:]) for row in rows), "mm, 1 sigma")
    panel = named_rows("spread of the ball's positions", names, axis, pitch=28)
    for i, (row, predicted, found) in enumerate(rows):
        panel.bar(i, predicted, found, "link")
        panel.dot(predicted, i, "predicted", f"predicted {predicted:.3f} mm", size=5.5)
        panel.dot(found, i, f"calibrated {row.role}", f"found {found:.3f} mm", size=5.5)
    ratios = [found / predicted for _, predicted, found in rows]
    return Plot(
        "predicted-found",
        "Predicted and found",
        f"What was found is {min(ratios):.1f} to {max(ratios):.1f} times what "
        f"the calibration predicts of itself, most at {names[int(np.argmax(ratios))]}.",
        (panel,),
        (("predicted", "predicted"), ("calibrated", "found"), HOLLOW),
        "half",
    )

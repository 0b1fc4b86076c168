"""Plots of the fit: training curves, cross-placement matrix, known distances, prediction."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .markup import tag
from .plot import Figures, Plot
from .svg import Axis, Panel, Rows
from .words import joined, mm, plural, short_names

__all__ = ["cross_placement", "history", "known_distances", "predicted_and_found"]

_SMALLEST = 1e-3
"""Below this the curves are not followed [mm]."""
_ROLES = (("train", "trained on"), ("test", "held out"))


def history(figures: Figures) -> Plot | None:
    """Inconsistency and distortion over the iterations, as lengths, on a logarithmic scale."""
    rows = figures["history"]
    if not rows:
        return None
    repeatability = figures["limits"]["repeatability"]
    panels = [_curves(rows, term, repeatability) for term in ("inconsistency", "distortion")]
    return Plot(
        "history",
        "Training curves",
        _history_sentence(figures, repeatability),
        tuple(panels),
        (("line train", "trained on"), ("line test", "held out")),
    )


def _lengths(rows: Sequence[Figures], role: str, term: str) -> list[tuple[float, float]]:
    """Return iteration and root of a term of Eq. (5) [mm]."""
    return [
        (float(row["iteration"]), max(1e3 * row[role][term] ** 0.5, _SMALLEST))
        for row in rows
        if row.get(role)
    ]


def _curves(rows: Sequence[Figures], term: str, repeatability: float | None) -> Any:
    curves = {role: _lengths(rows, role, term) for role, _ in _ROLES}
    values = [value for curve in curves.values() for _, value in curve]
    if repeatability:
        values.append(1e3 * repeatability)
    last = max(float(rows[-1]["iteration"]), 1.0)
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
    return panel.root


def _history_sentence(figures: Figures, repeatability: float | None) -> str:
    rows = figures["history"]
    role, words = _ROLES[1] if rows[0].get("test") else _ROLES[0]
    ends = {
        term: [1e3 * rows[k][role][term] ** 0.5 for k in (0, -1)]
        for term in ("inconsistency", "distortion")
    }
    parts = [f"{term} falls from {a:.2f} to {b:.2f} mm" for term, (a, b) in ends.items()]
    tail = ""
    if repeatability:
        times = ends["inconsistency"][1] / (1e3 * repeatability)
        tail = f"; what stays is {times:.1f} times the arm's repeatability (dashed)"
    steps = plural(int(rows[-1]["iteration"]), "iteration")
    return f"Over {steps} the {joined(parts)} on the placements {words}{tail}."


def cross_placement(figures: Figures) -> Plot | None:
    """Trained on which placement alone, error where: the paper's Fig. 6."""
    matrix = figures["cross_placement"]
    if matrix is None:
        return None
    names = short_names(matrix["names"])
    fitted = [i for i, row in enumerate(matrix["matrix"]) if row is not None]
    cells = {
        (i, j): max(1e3 * matrix["matrix"][i][j], 1e-6) for i in fitted for j in range(len(names))
    }
    if not cells:
        return None
    return Plot(
        "cross-placement",
        "Trained on one, tried on the others",
        _matrix_sentence(matrix, names, cells, fitted),
        (_cells(names, cells),),
        (("hatched", "hatched: trained on"),),
        "half",
    )


def _matrix_sentence(
    matrix: Figures, names: list[str], cells: dict[tuple[int, int], float], fitted: list[int]
) -> str:
    means = {i: float(np.mean([cells[i, j] for j in range(len(names)) if j != i])) for i in fitted}
    best, worst = min(means, key=lambda i: means[i]), max(means, key=lambda i: means[i])
    failed = len(names) - len(fitted)
    tail = f"; {plural(failed, 'placement')} cannot be fitted alone" if failed else ""
    return (
        f"By {matrix['method']} on one placement alone, {names[best]} teaches most about the "
        f"others ({means[best]:.2f} mm on average) and {names[worst]} least "
        f"({means[worst]:.2f} mm){tail}."
    )


def _cells(names: list[str], cells: dict[tuple[int, int], float]) -> Any:
    size = min(46.0, 290.0 / len(names))
    panel = Rows(
        "rows: trained on; columns: error there, mm", names, Axis(0, 1), pitch=size, bare=True
    )
    low, high = min(cells.values()), max(cells.values())
    for (i, j), value in cells.items():
        shade = float((np.log(value) - np.log(low)) / max(np.log(high / low), 1e-9))
        x, y = panel.left + j * size, panel.row(i) - size / 2
        hint = tag("title", f"trained on {names[i]}, error at {names[j]}: {value:.3f} mm")
        box = {"x": x, "y": y, "width": size, "height": size}
        panel.add("rect", hint, **box, class_="cell", fill_opacity=0.06 + 0.8 * shade)
        if i == j:
            panel.add("rect", **box, fill="url(#hatch)")
        if size > 24:
            inverse = "light" if shade > 0.6 else ""
            panel.text(x + size / 2, y + size / 2 + 4, f"{value:.2f}", f"number middle {inverse}")
    for j, name in enumerate(names):
        x, y = panel.left + (j + 0.5) * size - 6, panel.bottom + 12
        panel.add("text", name[:14], x=x, y=y, class_="tick", transform=f"rotate(24 {x} {y})")
    return panel.root


def known_distances(figures: Figures) -> Plot | None:
    """Errors of distances that were measured from outside, and the limit."""
    rows = figures["between"]
    if not rows:
        return None
    ends = short_names([row[end] for row in rows for end in ("a", "b")])
    names = [f"{a} to {b}" for a, b in zip(ends[::2], ends[1::2], strict=True)]
    errors = [1e3 * row[f"{m}_error"] for row in rows for m in ("nominal", "calibrated")]
    limit = figures["limits"]["between_placements"]["value"]
    half = 1.1 * max(*(abs(e) for e in errors), 1e3 * (limit or 0), 0.01)
    panel = Rows("predicted less known distance", names, Axis(-half, half, "mm"), pitch=22)
    panel.vertical(0, "zero")
    for i, row in enumerate(rows):
        for model in ("nominal", "calibrated"):
            value = 1e3 * row[f"{model}_error"]
            panel.mark(i, value, f"{model} test", f"{names[i]}, {model}: {value:+.3f} mm")
    for side in (-1, 1):
        if limit:
            words = f"limit {1e3 * limit:g} mm" if side > 0 else ""
            panel.threshold(side * 1e3 * limit, words, vertical=True)
    means = [
        mm(float(np.mean([abs(row[f"{m}_error"]) for row in rows])))
        for m in ("nominal", "calibrated")
    ]
    i = int(np.argmax([abs(row["calibrated_error"]) for row in rows]))
    return Plot(
        "known-distances",
        "Distances between placements",
        f"Over {plural(len(rows), 'known distance')} the mean error falls from {means[0]} to "
        f"{means[1]}; the worst is {names[i]}, off by {mm(rows[i]['calibrated_error'])}.",
        (panel.root,),
        (("nominal", "nominal"), ("calibrated", "calibrated")),
        "half",
    )


def predicted_and_found(figures: Figures) -> Plot | None:
    """The spread predicted at each placement beside the one found there."""
    rows = [row for row in figures["placements"] if row.get("predicted_deviation")]
    rows = [row for row in rows if row.get("found_deviation")]
    if not rows:
        return None
    names = short_names([row["name"] for row in rows])
    keys = ("predicted_deviation", "found_deviation")
    high = 1.15e3 * max(row[key] for row in rows for key in keys)
    panel = Rows("spread of the ball's positions", names, Axis(0, high, "mm, 1 sigma"), pitch=28)
    for i, row in enumerate(rows):
        predicted, found = (1e3 * row[key] for key in keys)
        panel.span(i, predicted, found, "link")
        panel.mark(i, predicted, "predicted", f"predicted {predicted:.3f} mm", size=5.5)
        panel.mark(i, found, f"calibrated {row['role']}", f"found {found:.3f} mm", size=5.5)
    ratios = {
        name: row["found_deviation"] / row["predicted_deviation"]
        for name, row in zip(names, rows, strict=True)
    }
    worst = max(ratios, key=lambda name: ratios[name])
    return Plot(
        "predicted-found",
        "Predicted and found",
        f"What was found is {min(ratios.values()):.1f} to {max(ratios.values()):.1f} times what "
        f"the calibration predicts of itself, most at {worst}.",
        (panel.root,),
        (("predicted", "predicted"), ("calibrated", "found"), ("hollow", "hollow: trained on")),
        "half",
    )

"""Plots of the errors: by placement, on the table, by sample."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from .advice import FAR
from .markup import tag
from .plot import Figures, Plot
from .svg import Axis, Panel, Rows, nice_above
from .words import area, joined, mm, percent, short_names

__all__ = ["errors_by_placement", "errors_in_2d", "order", "shares", "table_map"]

BOTH = (("nominal", "nominal"), ("calibrated", "calibrated"))


def judged_role(figures: Figures) -> tuple[str, str]:
    """Return the role that figures rest on, and what to call it."""
    return ("test", "held-out") if figures["summary"]["test"] else ("train", "trained-on")


def names_of(figures: Figures) -> list[str]:
    """Return the placements' names, as short as they can be."""
    return short_names([row["name"] for row in figures["placements"]])


def lengths(figures: Figures, model: str, role: str | None = None) -> Any:
    """Return the error of each sample [m], of one role or of all."""
    found = [
        float(np.linalg.norm(row[model]))
        for row in figures["samples"]
        if role is None or figures["placements"][row["placement"]]["role"] == role
    ]
    return np.array(found)


def errors_by_placement(figures: Figures) -> Plot:
    """Mean absolute error before and after at each placement, and the limit."""
    rows, names = figures["placements"], names_of(figures)
    values = [1e3 * row[m]["mean_absolute_error"] for row in rows for m, _ in BOTH]
    x = Axis(*_log_range(values), label="mean absolute error, mm", log=True)
    panel = Rows("error at each placement", names, x, pitch=28)
    for i, row in enumerate(rows):
        a, b = (1e3 * row[m]["mean_absolute_error"] for m, _ in BOTH)
        panel.span(i, a, b, "link")
        for model, value in (("nominal", a), ("calibrated", b)):
            mark = f"{model} {row['role']}"
            panel.mark(i, value, mark, f"{names[i]}, {model}: {value:.3f} mm", size=5.5)
    limit = figures["limits"]["mean_absolute_error"]["value"]
    if limit is not None:
        panel.threshold(1e3 * limit, f"limit {1e3 * limit:g} mm", vertical=True)
    return Plot(
        "errors-by-placement",
        "Before and after, placement by placement",
        _placement_sentence(figures, names),
        (panel.root,),
        (*BOTH, ("hollow", "hollow: trained on")),
        "wide",
    )


def _placement_sentence(figures: Figures, names: list[str]) -> str:
    role, words = judged_role(figures)
    rows = [(n, r) for n, r in zip(names, figures["placements"], strict=True) if r["role"] == role]
    name, worst = max(rows, key=lambda row: row[1]["calibrated"]["mean_absolute_error"])
    before, after = (mm(worst[m]["mean_absolute_error"]) for m, _ in BOTH)
    limit = figures["limits"]["mean_absolute_error"]["value"]
    tail = ""
    if limit is not None:
        beyond = [n for n, r in rows if r["calibrated"]["mean_absolute_error"] > limit]
        tail = f"; beyond the limit of {mm(limit)}: {joined(beyond) or 'none'}"
    return f"The {words} placement with the largest error is {name}, {before} before and {after} after{tail}."


def _log_range(values: list[float]) -> tuple[float, float]:
    """Return a range with some room around positive values; one around 1 where there are none."""
    positive = [value for value in values if value > 1e-6] or [1.0]
    return min(positive) / 1.5, max(positive) * 1.5


def table_map(figures: Figures) -> Plot:
    """The placements as the robot sees them from above, coloured by the answer for the task."""
    rows, names = figures["placements"], names_of(figures)
    place = figures["answers"]["next"]["place"]
    points = np.array([[0.0, 0.0], *(row["position"][:2] for row in rows), place[:2]])
    ahead, left = points[:, 0], points[:, 1]
    # The robot's left is the picture's left; both axes have the same scale.
    y = Axis(float(ahead.min()) - 0.12, float(ahead.max()) + 0.12)
    middle, half = (left.max() + left.min()) / 2, (left.max() - left.min()) / 2 + 0.16
    across = Axis(float(-middle - half), float(-middle + half))
    scale = min(370 / (across.high - across.low), 420 / (y.high - y.low))
    room = 185 / scale
    across = Axis(float(-middle - room), float(-middle + room), label="m to the robot's right")
    y = Axis(y.low, y.high, label="m ahead of the robot's base")
    panel = Panel(
        "the table from above", across, y, height=72 + scale * (y.high - y.low)
    ).grid()
    panel.dot(0, 0, "base", "the robot's base", size=9)
    panel.text(panel.x(0) + 13, panel.y(0) + 4, "robot", "tick")
    for i, row in enumerate(rows):
        _placement_mark(panel, i, row, names[i], figures["answers"]["use"]["rows"][i]["answer"])
    panel.dot(-place[1], place[0], "next", f"record next: {area(place)}", size=11)
    panel.text(panel.x(-place[1]), panel.y(place[0]) + 4, "next", "tick middle")
    return Plot(
        "table-map",
        "Where it was tried",
        _map_sentence(figures),
        (panel.root,),
        (
            ("answer yes", "yes"),
            ("answer mostly", "mostly"),
            ("answer no", "no"),
            ("answer trained", "trained on"),
            ("next", "record next"),
        ),
        "wide",
    )


def _placement_mark(panel: Panel, i: int, row: Figures, name: str, answer: str) -> None:
    x, y = -row["position"][1], row["position"][0]
    class_ = f"answer {answer.split(' ')[0]}"
    hint = tag("title", f"{name}: {area(row['position'])}")
    panel.add("circle", hint, cx=panel.x(x), cy=panel.y(y), r=9, class_=class_, data_placement=i)
    for socket in row["sockets"]:
        panel.dot(-socket["centre"][1], socket["centre"][0], "socket", size=2)
    panel.text(panel.x(x), panel.y(y) - 13, name, "tick middle strong")


def _map_sentence(figures: Figures) -> str:
    rows = [
        row
        for row, told in zip(
            figures["placements"], figures["answers"]["use"]["rows"], strict=True
        )
        if told["answer"] == "yes"
    ]
    role, _ = judged_role(figures)
    total = sum(row["role"] == role for row in figures["placements"])
    span = [row["position"] for row in figures["placements"]]
    heights = [p[2] for p in span]
    level = f"between {min(heights):.2f} and {max(heights):.2f} m above its base"
    if role == "train":
        return f"Nothing was held out among these {total} placements, {level}, so no place is proven."
    return (
        f"An error of {1e3 * figures['tolerance']:g} mm was never exceeded at {len(rows)} of the "
        f"{total} held-out places, all {level}, and elsewhere nothing was measured."
    )


def shares(figures: Figures) -> Plot:
    """Share of the samples within an error, and the task's tolerance."""
    role, words = judged_role(figures)
    values = {model: np.sort(1e3 * lengths(figures, model, role)) for model, _ in BOTH}
    low, high = _log_range([v for found in values.values() for v in found.tolist()])
    tolerance = figures["tolerance"]
    x = Axis(min(low, 1e3 * tolerance / 1.5), max(high, 1.5e3 * tolerance), "error, mm", log=True)
    panel = Panel(f"{words} samples within an error", x, Axis(0, 100, "% of samples"))
    panel.grid()
    for model, found in values.items():
        steps = np.linspace(0, 100, len(found) + 1)[1:]
        path = [(x.low, 0.0), *zip(found.tolist(), steps.tolist(), strict=True), (x.high, 100.0)]
        panel.line(path, f"curve {model}")
    panel.threshold(1e3 * tolerance, f"{1e3 * tolerance:g} mm", vertical=True)
    found = figures["summary"][role]
    inside = {model: percent(found["within_tolerance"][model]) for model, _ in BOTH}
    half = {model: mm(found["quantiles"][model]["median"]) for model, _ in BOTH}
    sentence = (
        f"Within {1e3 * tolerance:g} mm of their socket's centre lie {inside['calibrated']} of the "
        f"{words} samples by the calibrated model and {inside['nominal']} by the nominal one, and "
        f"half of them within {half['calibrated']} and {half['nominal']}."
    )
    return Plot("shares", "How often within what", sentence, (panel.root,), BOTH, "wide")


def errors_in_2d(figures: Figures) -> Plot:
    """Every sample round its socket, seen along two axes; for paper."""
    role, _ = judged_role(figures)
    limit = figures["limits"]["mean_absolute_error"]["value"]
    large = nice_above(1e3 * float(lengths(figures, "nominal").max(initial=1e-6)))
    small = nice_above(1e3 * float(lengths(figures, "calibrated").max(initial=1e-6)))
    panels = [
        _plane(figures, model, axes, half, f"{model}, {view}{note}", limit)
        for axes, view in (((0, 1), "from above"), ((0, 2), "from the side"))
        for model, half, note in (
            ("nominal", large, ""),
            ("calibrated", large, ""),
            ("calibrated", small, ", enlarged"),
        )
    ]
    found = figures["summary"][role]["quantiles"]
    medians = [found[model]["median"] for model, _ in BOTH]
    side = "inside" if limit and medians[1] <= limit else "outside"
    ring = f", {side} the dashed limit of {mm(limit)}" if limit else ""
    sentence = (
        f"The cloud round the sockets' centres shrinks from a median radius of {mm(medians[0])} to "
        f"{mm(medians[1])}{ring}; enlarged {large / small:.3g} times it fills {small:g} mm each way."
    )
    return Plot(
        "errors-2d",
        "The error of every sample, flat",
        sentence,
        tuple(panel.root for panel in panels),
        (*BOTH, ("hollow", "hollow: trained on")),
        "thirds",
    )


def _plane(
    figures: Figures,
    model: str,
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
        height=262,
        left=44,
    ).grid()
    for row in figures["samples"]:
        a, b = (1e3 * row[model][k] for k in axes)
        role = figures["placements"][row["placement"]]["role"]
        panel.dot(a, b, f"{model} {role}", size=2)
    if limit:
        radius = 1e3 * limit * (panel.right - panel.left) / (2 * half)
        if radius < 0.7 * (panel.right - panel.left):
            panel.add("circle", cx=panel.x(0), cy=panel.y(0), r=radius, class_="threshold")
    return panel


def order(figures: Figures) -> Plot:
    """The calibrated error of each sample in the order of recording."""
    names = names_of(figures)
    top = 1.08e3 * float(lengths(figures, "calibrated").max(initial=1e-6))
    panels = [_order_panel(figures, i, name, top) for i, name in enumerate(names)]
    worst = figures["answers"]["data"]["worst"][0]
    rows = list(_ratios(figures))
    beyond = sum(ratio > FAR for ratio in rows)
    sentence = (
        f"The farthest sample is {worst['where']}, {mm(worst['error'])} from its socket and "
        f"{worst['ratio']:.1f} times its placement's mean; {beyond or 'none'} of {len(rows)} "
        f"{'is' if beyond == 1 else 'are'} beyond the dashed {FAR:g} times the mean, and a step in "
        "the running mean would tell of a moved base."
    )
    return Plot(
        "order",
        "In the order of recording",
        sentence,
        tuple(panels),
        (("calibrated", "error"), ("running", "running mean of 5"), ("flagged", "downweighted")),
    )


def _ratios(figures: Figures) -> Iterator[float]:
    for row in figures["samples"]:
        mean = figures["placements"][row["placement"]]["calibrated"]["mean_absolute_error"]
        yield float(np.linalg.norm(row["calibrated"])) / max(mean, 1e-12)


def _order_panel(figures: Figures, i: int, name: str, top: float) -> Any:
    place = figures["placements"][i]
    rows = [row for row in figures["samples"] if row["placement"] == i]
    x = Axis(0, len(rows) + 1, "sample", ticks=())
    panel = Panel(name, x, Axis(0, top, "mm"), height=170)
    panel.grid(vertical=False)
    errors = [1e3 * float(np.linalg.norm(row["calibrated"])) for row in rows]
    first = 0
    for socket in dict.fromkeys(row["socket"] for row in rows):
        count = sum(row["socket"] == socket for row in rows)
        if first:
            panel.vertical(first + 0.5, "divide")
        panel.text(panel.x(first + 0.5) + 6, panel.bottom + 15, f"socket {socket}", "tick")
        part = errors[first : first + count]
        running = [float(np.mean(part[max(0, k - 2) : k + 3])) for k in range(count)]
        panel.line([(first + 1 + k, value) for k, value in enumerate(running)], "running")
        first += count
    for k, (row, error) in enumerate(zip(rows, errors, strict=True), 1):
        mark = "flagged" if row.get("weight", 1.0) < 0.5 else f"calibrated {place['role']}"
        panel.dot(k, error, mark, f"{row['where']}: {error:.3f} mm")
    mean = 1e3 * place["calibrated"]["mean_absolute_error"]
    panel.threshold(FAR * mean, f"{FAR:g} x mean")
    return panel.root

"""Plots for the question whether the arm may be used: by placement, on the table, how often."""

from typing import Any

import numpy as np

from .markup import Element, tag
from .plot import BOTH, Figures, Plot, judged_role, lengths, names_of
from .svg import Axis, Panel, Rows
from .words import area, joined, mm, percent

__all__ = ["errors_by_placement", "shares", "table_map"]

HALF = 0.16
"""Room beside the outermost mark of the map [m]."""


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
        "half",
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
    return (
        f"The {words} placement with the largest error is {name}, {before} before and {after} "
        f"after{tail}."
    )


def _log_range(values: list[float]) -> tuple[float, float]:
    """Return a range with some room around positive values; one around 1 where there are none."""
    positive = [value for value in values if value > 1e-6] or [1.0]
    return min(positive) / 1.5, max(positive) * 1.5


def table_map(figures: Figures) -> Plot:
    """The placements as the robot sees them from above, coloured by the answer for the task."""
    rows, names = figures["placements"], names_of(figures)
    place = figures["answers"]["next"]["place"]
    panel = _map_panel([[0.0, 0.0, 0.0], *(row["position"] for row in rows), place])
    panel.dot(0, 0, "base", "the robot's base", size=9)
    panel.text(panel.x(0) + 13, panel.y(0) + 4, "robot", "tick")
    panel.dot(-place[1], place[0], "next", f"record next: {area(place)}", size=9)
    panel.text(panel.x(-place[1]), panel.y(place[0]) + 22, "next", "tick middle")
    told = [row["answer"] for row in figures["answers"]["use"]["rows"]]
    for i, row in enumerate(rows):
        _placement_mark(panel, i, row, names[i], told[i])
    return Plot(
        "table-map",
        "Where it was tried",
        _map_sentence(figures, told),
        (panel.root, _map_key(names, told)),
        (
            ("answer yes", "yes"),
            ("answer mostly", "mostly"),
            ("answer no", "no"),
            ("answer trained", "trained on"),
            ("next", "record next"),
        ),
        "beside",
    )


def _map_panel(points: list[Any]) -> Panel:
    """Return axes round points; the robot's left is the picture's left, to one scale."""
    spread = np.array(points)
    ahead, right = spread[:, 0], -spread[:, 1]
    y = Axis(float(ahead.min()) - HALF, float(ahead.max()) + HALF, "m ahead of the robot's base")
    middle, half = (right.max() + right.min()) / 2, (right.max() - right.min()) / 2 + HALF
    scale = min(370 / (2 * half), 420 / (y.high - y.low))
    room = 185 / scale
    x = Axis(float(middle - room), float(middle + room), "m to the robot's right")
    return Panel("", x, y, height=86 + scale * (y.high - y.low)).grid()


def _placement_mark(panel: Panel, i: int, row: Figures, name: str, answer: str) -> None:
    x, y = panel.x(-row["position"][1]), panel.y(row["position"][0])
    class_ = f"answer {answer.split(' ')[0]}"
    hint = tag("title", f"{name}: {area(row['position'])}")
    panel.add("circle", hint, cx=x, cy=y, r=10, class_=class_, data_placement=i)
    panel.text(x, y + 4, str(i + 1), "number middle light")


def _map_key(names: list[str], told: list[str]) -> Element:
    """Return the numbered names beside the map."""
    return tag(
        "ol",
        [
            tag(
                "li",
                name,
                " ",
                tag("span", answer, class_=f"badge {answer.split(' ')[0]}", data_answer=i),
            )
            for i, (name, answer) in enumerate(zip(names, told, strict=True))
        ],
        class_="map-key",
    )


def _map_sentence(figures: Figures, told: list[str]) -> str:
    role, _ = judged_role(figures)
    total = sum(row["role"] == role for row in figures["placements"])
    heights = [row["position"][2] for row in figures["placements"]]
    low, high = min(heights), max(heights)
    level = f"{low:.2f} m" if high - low < 0.01 else f"between {low:.2f} and {high:.2f} m"
    if role == "train":
        return (
            f"Nothing was held out among {total} trained on, at a height of {level}, so no place "
            "on the table is proven."
        )
    return (
        f"An error of {1e3 * figures['tolerance']:g} mm was never exceeded at {told.count('yes')} "
        f"of the {total} held-out places, at a height of {level} above the robot's base, and "
        "elsewhere nothing was measured."
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
    return Plot("shares", "How often within what", sentence, (panel.root,), BOTH, "half")

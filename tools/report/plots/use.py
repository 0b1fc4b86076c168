"""Plots for the question whether the arm may be used: by placement, on the table, how often."""

from collections.abc import Sequence

import numpy as np

from ....solver.assessment import area
from ..figures import Answer, ReportDocument, text
from .figure import Axis, Panel, named_rows, to_scale
from .plot import MODELS, Plot, lengths, names_of, plot

HALF = 0.16
"""Room beside the outermost mark of the map [m]."""


def errors_by_placement(report: ReportDocument) -> Plot:
    """Mean absolute error before and after at each placement, and the limit."""
    rows, names = report.placements, names_of(report)
    before = [1e3 * row.nominal.mean_absolute_error for row in rows]
    after = [1e3 * row.calibrated.mean_absolute_error for row in rows]
    x = Axis.logarithmic([*before, *after], "mean absolute error, mm")
    panel = named_rows("error at each placement", names, x, pitch=28)
    panel.bars(before, after, "link")
    for model, values in zip(MODELS, (before, after), strict=True):
        panel.dots(values, [f"{model} {row.role}" for row in rows], model)
    limit = report.limits.mean_absolute_error.value
    if limit is not None:
        panel.threshold(f"limit {1e3 * limit:g} mm", x=1e3 * limit)
    role = report.summary.judged[0]
    each = zip(after, before, names, [row.role for row in rows], strict=True)
    judged = [one for one in each if one[-1] == role]
    return plot("errors-by-placement", panel, layout="half", role=role, judged=judged, limit=limit)


def table_map(report: ReportDocument) -> Plot:
    """The placements as the robot sees them from above, coloured by the answer for the task."""
    rows, place = report.placements, report.answers.next.place
    ahead, left, _ = np.array([(0.0, 0.0, 0.0), *(row.position for row in rows), place]).T
    labels = ("m to the robot's right", "m ahead of the robot's base")
    panel = to_scale("", np.stack([-left, ahead], axis=1), labels, room=HALF)
    panel.dot(0, 0, "base", "the robot's base", size=9)
    panel.text(panel.x(0) + 13, panel.y(0) + 4, "robot", "tick")
    panel.dot(-place[1], place[0], "next", f"record next: {area(place)}", size=9)
    panel.text(panel.x(-place[1]), panel.y(place[0]) + 22, "next", "tick middle")
    answers: list[Answer] = [row.answer for row in report.answers.use.rows]
    named = list(zip(names_of(report), answers, strict=True))
    for i, (row, (name, answer)) in enumerate(zip(rows, named, strict=True)):
        x, y = panel.x(-row.position[1]), panel.y(row.position[0])
        mark = {"class_": f"answer {answer.split(' ')[0]}", "data_placement": i}
        panel.add("circle", f"{name}: {area(row.position)}", cx=x, cy=y, r=10, **mark)
        panel.text(x, y + 4, str(i + 1), "number middle light")
    sentence = map_sentence(report, answers, f"{1e3 * report.tolerance:g}")
    return plot("table-map", panel, layout="beside", controls={"answers": named}, text=sentence)


def map_sentence(report: ReportDocument, answers: Sequence[Answer], allowed: str) -> str:
    """Return at how many places the task can be done, with the error that it allows in words."""
    heights = [row.position[2] for row in report.placements]
    role = report.summary.judged[0]
    return text(
        "captions.txt.j2",
        "map_sentence",
        role=role,
        total=sum(row.role == role for row in report.placements),
        allowed=allowed,
        proven=answers.count("yes"),
        low=min(heights),
        high=max(heights),
    )


def shares(report: ReportDocument) -> Plot:
    """Share of the samples within an error, and the task's tolerance."""
    role, judged = report.summary.judged
    words = "held-out" if role == "test" else "trained-on"
    values = {model: np.sort(1e3 * lengths(report, model, role)) for model in MODELS}
    tolerance = 1e3 * report.tolerance
    x = Axis.logarithmic([tolerance, *np.concatenate(list(values.values()))], "error, mm")
    panel = Panel(f"{words} samples within an error", x, Axis(0, 100, "% of samples")).grid()
    for model, errors in values.items():
        steps = np.linspace(0, 100, len(errors) + 1)[1:]
        path = [(x.low, 0.0), *zip(errors.tolist(), steps.tolist(), strict=True), (x.high, 100.0)]
        panel.line(path, f"curve {model}")
    panel.threshold(f"{tolerance:g} mm", x=tolerance)
    return plot("shares", panel, layout="half", words=words, judged=judged, tolerance=tolerance)

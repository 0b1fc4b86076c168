"""Plots for the question whether the arm may be used: by placement, on the table, how often."""

from collections.abc import Sequence

import numpy as np

from ....solver.assessment import area, joined, mm, percent
from ..figures import Answer, ReportDocument
from .figure import Axis, Panel, named_rows, to_scale
from .plot import BOTH, HOLLOW, MODELS, Plot, judged_role, lengths, names_of

HALF = 0.16
"""Room beside the outermost mark of the map [m]."""


def errors_by_placement(report: ReportDocument) -> Plot:
    """Mean absolute error before and after at each placement, and the limit."""
    names = names_of(report)
    errors = [
        (1e3 * row.nominal.mean_absolute_error, 1e3 * row.calibrated.mean_absolute_error)
        for row in report.placements
    ]
    x = Axis.logarithmic((e for pair in errors for e in pair), "mean absolute error, mm")
    panel = named_rows("error at each placement", names, x, pitch=28)
    for i, row in enumerate(report.placements):
        panel.bar(i, *errors[i], "link")
        for model, value in zip(MODELS, errors[i], strict=True):
            hint = f"{names[i]}, {model}: {value:.3f} mm"
            panel.dot(value, i, f"{model} {row.role}", hint, size=5.5)
    limit = report.limits.mean_absolute_error.value
    if limit is not None:
        panel.threshold(f"limit {1e3 * limit:g} mm", x=1e3 * limit)
    return Plot(
        "errors-by-placement",
        "Before and after, placement by placement",
        _placement_sentence(report, names),
        (panel,),
        (*BOTH, HOLLOW),
        "half",
    )


def _placement_sentence(report: ReportDocument, names: list[str]) -> str:
    role, words = judged_role(report)
    rows = [(n, r) for n, r in zip(names, report.placements, strict=True) if r.role == role]
    name, worst = max(rows, key=lambda row: row[1].calibrated.mean_absolute_error)
    limit = report.limits.mean_absolute_error.value
    tail = ""
    if limit is not None:
        beyond = [n for n, r in rows if r.calibrated.mean_absolute_error > limit]
        tail = f"; beyond the limit of {mm(limit)}: {joined(beyond) or 'none'}"
    return (
        f"The {words} placement with the largest error is {name}, "
        f"{mm(worst.nominal.mean_absolute_error)} before and "
        f"{mm(worst.calibrated.mean_absolute_error)} after{tail}."
    )


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
    return Plot(
        "table-map",
        "Where it was tried",
        map_sentence(report, answers, f"{1e3 * report.tolerance:g}"),
        (panel,),
        (
            ("answer yes", "yes"),
            ("answer mostly", "mostly"),
            ("answer no", "no"),
            ("answer trained", "trained on"),
            ("next", "record next"),
        ),
        "beside",
        controls={"answers": named},
    )


def map_sentence(report: ReportDocument, answers: Sequence[Answer], allowed: str) -> str:
    """Return at how many places the task can be done.

    Args:
        report: The figures.
        answers: The answer at each placement.
        allowed: The error that the task allows, in words.
    """
    role, _ = judged_role(report)
    total = sum(row.role == role for row in report.placements)
    heights = [row.position[2] for row in report.placements]
    low, high = min(heights), max(heights)
    level = f"{low:.2f} m" if high - low < 0.01 else f"between {low:.2f} and {high:.2f} m"
    if role == "train":
        return (
            f"Nothing was held out among {total} trained on, at a height of {level}, so no place "
            "on the table is proven."
        )
    return (
        f"An error of {allowed} mm was never exceeded at {answers.count('yes')} of the {total} "
        f"held-out places, at a height of {level} above the robot's base, and elsewhere nothing "
        "was measured."
    )


def shares(report: ReportDocument) -> Plot:
    """Share of the samples within an error, and the task's tolerance."""
    role, words = judged_role(report)
    values = {model: np.sort(1e3 * lengths(report, model, role)) for model in MODELS}
    tolerance = 1e3 * report.tolerance
    x = Axis.logarithmic([tolerance, *np.concatenate(list(values.values()))], "error, mm")
    panel = Panel(f"{words} samples within an error", x, Axis(0, 100, "% of samples")).grid()
    for model, errors in values.items():
        steps = np.linspace(0, 100, len(errors) + 1)[1:]
        path = [(x.low, 0.0), *zip(errors.tolist(), steps.tolist(), strict=True), (x.high, 100.0)]
        panel.line(path, f"curve {model}")
    panel.threshold(f"{tolerance:g} mm", x=tolerance)
    _, judged = report.summary.judged
    inside, quantiles = judged.within_tolerance, judged.quantiles
    sentence = (
        f"Within {tolerance:g} mm of their socket's centre lie {percent(inside.calibrated)} "
        f"of the {words} samples by the calibrated model and {percent(inside.nominal)} by the "
        f"nominal one, and half of them within {mm(quantiles.calibrated.median)} and "
        f"{mm(quantiles.nominal.median)}."
    )
    return Plot("shares", "How often within what", sentence, (panel,), BOTH, "half")

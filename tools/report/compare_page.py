"""The comparison of calibrations, as a page: what is better where, and by how much."""

from collections.abc import Mapping
from typing import Any

from .cells import figure, table
from .markup import Element, tag
from .page import frame
from .plot import Plot
from .svg import Axis, Rows
from .words import joined, mm, plural, short_names

__all__ = ["comparison_page", "comparison_plots", "sentence"]

Figures = Mapping[str, Any]
COLOURS = 6
"""Marks that the style sheet has; more models take them again."""


def sentence(figures: Figures, pair: Mapping[str, Any]) -> str:
    """Return in words which of two models is better, where, and by how much beyond the noise."""
    a, b = (figures["models"][pair[key]]["name"] for key in ("a", "b"))
    summary = pair["summary"]
    if summary is None:
        return f"{b} against {a}: every placement was trained on by one of the models, so no word."
    count = plural(len(figures["fair"]), "placement")
    where = f"over {count} that none was trained on"
    noise = f"noise \N{PLUS-MINUS SIGN}{mm(summary['noise'], 3)}, 95 %"
    if not summary["beyond_noise"]:
        gap = mm(abs(summary["mean"]), 3)
        return f"{b} and {a} differ by {gap} {where}, which is within the noise ({noise})."
    better, worse = (b, a) if summary["mean"] < 0 else (a, b)
    rows = [pair["placements"][i] for i in figures["fair"]]
    wins = sum(row["beyond_noise"] and row["mean"] * summary["mean"] > 0 for row in rows)
    return (
        f"{better} is better than {worse} by {mm(abs(summary['mean']), 3)} {where}, beyond the "
        f"noise ({noise}) on the whole and at {wins} of them."
    )


def comparison_plots(figures: Figures) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(figures), _differences(figures), _distances(figures))
    return [plot for plot in made if plot is not None]


def _names(figures: Figures) -> tuple[list[str], list[str]]:
    """Return the names of the placements and of the models."""
    places = short_names([row["name"] for row in figures["placements"]])
    return places, [row["name"] for row in figures["models"]]


def _legend(models: list[str]) -> tuple[tuple[str, str], ...]:
    return tuple((f"model-{k % COLOURS}", name) for k, name in enumerate(models))


def _errors(figures: Figures) -> Plot:
    places, models = _names(figures)
    values = [
        1e3 * model["mean_absolute_error"]
        for row in figures["placements"]
        for model in row["models"]
    ]
    low, high = max(min(values), 1e-6) / 1.4, max(*values, 1e-6) * 1.4
    panel = Rows("error at each placement", places, Axis(low, high, "MAE, mm", log=True), pitch=28)
    for i, row in enumerate(figures["placements"]):
        for k, model in enumerate(row["models"]):
            value = 1e3 * model["mean_absolute_error"]
            hint = f"{places[i]}, {models[k]}: {value:.3f} mm"
            panel.mark(i, value, _mark(k, model), hint, size=5.5)
    ranked: list[tuple[float, str]] = sorted(
        (float(row["summary"]["mean_absolute_error"]), str(row["name"]))
        for row in figures["models"]
        if row["summary"]
    )
    words = "Every placement was trained on by one of the models, so none of these errors is fair."
    if ranked:
        best, worst = ranked[0], ranked[-1]
        words = (
            f"Where none was trained, {best[1]} is best with {mm(best[0], 3)} on average, and "
            f"{worst[1]} is worst with {mm(worst[0], 3)}."
        )
    marks = (*_legend(models), ("hollow", "hollow: trained on"))
    return Plot("errors", "Error by placement", words, (panel.root,), marks, "half")


def _differences(figures: Figures) -> Plot:
    places, models = _names(figures)
    pair = figures["pairs"][-1]
    a, b = (models[int(pair[key])] for key in ("a", "b"))
    rows = pair["placements"]
    reach = [1e3 * (abs(r["mean"]) + r["noise"]) for r in rows]
    half = 1.1 * max(*reach, 1e-6)
    panel = Rows(f"{b} less {a}", places, Axis(-half, half, "mm, with 95 % noise"), pitch=28)
    panel.threshold(0, f"{b} better < 0 < worse", vertical=True)
    for i, row in enumerate(rows):
        mean, noise = 1e3 * row["mean"], 1e3 * row["noise"]
        trained = any(figures["placements"][i]["models"][pair[k]]["trained_on"] for k in ("a", "b"))
        panel.span(i, mean - noise, mean + noise, "link", thick=5)
        mark = f"model-{pair['b'] % COLOURS}" + (" train" if trained else "")
        panel.mark(i, mean, mark, f"{places[i]}: {mean:+.3f} mm", size=5.5)
    return Plot(
        "differences",
        "Difference of the last two",
        sentence(figures, pair),
        (panel.root,),
        (("hollow", "hollow: one was trained on it"),),
        "half",
    )


def _distances(figures: Figures) -> Plot | None:
    places, models = _names(figures)
    errors = [
        [None if (e := model["distance_error"]) is None else 1e3 * e for model in row["models"]]
        for row in figures["placements"]
    ]
    values = [abs(value) for row in errors for value in row if value is not None]
    if not values:
        return None
    half = 1.1 * max(*values, 1e-6)
    title = "socket distance, predicted less measured"
    panel = Rows(title, places, Axis(-half, half, "mm"), pitch=28)
    panel.vertical(0, "zero")
    for i, row in enumerate(figures["placements"]):
        for k, value in enumerate(errors[i]):
            if value is not None:
                mark = _mark(k, row["models"][k])
                panel.mark(i, value, mark, f"{places[i]}, {models[k]}: {value:+.3f} mm", size=5.5)
    worst = [
        f"{max(abs(row[k] or 0.0) for row in errors):.3f} mm by {name}"
        for k, name in enumerate(models)
    ]
    words = f"The sockets' distance is off by at most {joined(worst)}."
    return Plot("distances", "Socket distance", words, (panel.root,), _legend(models), "half")


def _mark(k: int, model: Mapping[str, Any]) -> str:
    return f"model-{k % COLOURS}" + (" train" if model["trained_on"] else "")


def comparison_page(figures: Figures) -> str:
    """Return the comparison as HTML."""
    sentences = [tag("li", sentence(figures, pair)) for pair in figures["pairs"]]
    last = figures["pairs"][-1]
    a, b = (figures["models"][last[key]]["name"] for key in ("a", "b"))
    apart = (
        f"Moved onto each other, {a} and {b} put the ball {mm(last['apart']['mean'])} apart on "
        f"average and {mm(last['apart']['max'])} at most."
    )
    body = [
        tag(
            "header",
            tag("p", "Comparison of calibrations", class_="kicker"),
            tag("h1", figures["robot_name"]),
        ),
        tag(
            "section",
            tag("h2", "What is better"),
            tag("ul", sentences),
            tag("p", apart),
            _summary(figures),
        ),
        tag(
            "section",
            tag("h2", "Where"),
            [plot.element() for plot in comparison_plots(figures)],
            class_="plots",
        ),
        _placements(figures),
    ]
    return frame(f"Comparison, {figures['robot_name']}", body, figures)


def _summary(figures: Figures) -> Element:
    rows: list[list[Any]] = []
    for k, row in enumerate(figures["models"]):
        path = f"models.{k}.summary"
        keys = ("mean_absolute_error", "p95", "max", "distance_error")
        cells = [figure(figures, f"{path}.{key}") if row["summary"] else "-" for key in keys]
        rows.append([row["name"], *cells])
    heads = ["model", "MAE, mm", "95 %, mm", "largest, mm", "socket distance error, mm"]
    count = plural(len(figures["fair"]), "placement")
    return tag("div", table(heads, rows), tag("p", f"On {count} that none of them was trained on."))


def _placements(figures: Figures) -> Element:
    places, models = _names(figures)
    rows: list[list[Any]] = []
    for i, row in enumerate(figures["placements"]):
        cells: list[Any] = [
            tag("span", places[i], class_="named"),
            "+".join(map(str, row["samples"])),
        ]
        for k, model in enumerate(row["models"]):
            shown = figure(figures, f"placements.{i}.models.{k}.mean_absolute_error")
            cells.append([shown, " (trained on)"] if model["trained_on"] else shown)
        rows.append(cells)
    heads = ["placement", "samples", *models]
    return tag("section", tag("h2", "MAE by placement, mm"), table(heads, rows, "cards"))

"""The comparison of calibrations, as a page: what is better where, and by how much."""

from collections.abc import Sequence

from ....solver.assessment import joined, mm, plural, short_names
from ....solver.results import encode
from ..figures import ComparedPair, ComparisonDocument, ErrorsAtPlacement
from ..plots import Axis, Plot, Rows
from .html import Cell, Element, figure, table, tag
from .html.frame import frame

COLOURS = 6
"""Marks that the style sheet has; more models take them again."""


def sentence(result: ComparisonDocument, pair: ComparedPair) -> str:
    """Return in words which of two models is better, where, and by how much beyond the noise."""
    a, b = result.models[pair.a].name, result.models[pair.b].name
    summary = pair.summary
    if summary is None:
        return f"{b} against {a}: every placement was trained on by one of the models, so no word."
    count = plural(len(result.fair), "placement")
    where = f"over {count} that none was trained on"
    noise = f"noise \N{PLUS-MINUS SIGN}{mm(summary.noise, 3)}, 95 %"
    if not summary.beyond_noise:
        gap = mm(abs(summary.mean), 3)
        return f"{b} and {a} differ by {gap} {where}, which is within the noise ({noise})."
    better, worse = (b, a) if summary.mean < 0 else (a, b)
    rows = [pair.placements[i] for i in result.fair]
    wins = sum(row.beyond_noise and row.mean * summary.mean > 0 for row in rows)
    return (
        f"{better} is better than {worse} by {mm(abs(summary.mean), 3)} {where}, beyond the "
        f"noise ({noise}) on the whole and at {wins} of them."
    )


def comparison_plots(result: ComparisonDocument) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(result), _differences(result), _distances(result))
    return [plot for plot in made if plot is not None]


def _names(result: ComparisonDocument) -> tuple[list[str], list[str]]:
    """Return the names of the placements and of the models."""
    places = short_names([row.name for row in result.placements])
    return places, [row.name for row in result.models]


def _legend(models: Sequence[str]) -> tuple[tuple[str, str], ...]:
    return tuple((f"model-{k % COLOURS}", name) for k, name in enumerate(models))


def _errors(result: ComparisonDocument) -> Plot:
    places, models = _names(result)
    values = [1e3 * model.mean_absolute_error for row in result.placements for model in row.models]
    low, high = max(min(values), 1e-6) / 1.4, max(*values, 1e-6) * 1.4
    panel = Rows("error at each placement", places, Axis(low, high, "MAE, mm", log=True), pitch=28)
    for i, row in enumerate(result.placements):
        for k, model in enumerate(row.models):
            value = 1e3 * model.mean_absolute_error
            hint = f"{places[i]}, {models[k]}: {value:.3f} mm"
            panel.mark(i, value, _mark(k, model), hint, size=5.5)
    ranked = sorted(
        (row.summary.mean_absolute_error, row.name) for row in result.models if row.summary
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


def _differences(result: ComparisonDocument) -> Plot:
    places, models = _names(result)
    pair = result.pairs[-1]
    a, b = models[pair.a], models[pair.b]
    rows = pair.placements
    reach = [1e3 * (abs(row.mean) + row.noise) for row in rows]
    half = 1.1 * max(*reach, 1e-6)
    panel = Rows(f"{b} less {a}", places, Axis(-half, half, "mm, with 95 % noise"), pitch=28)
    panel.threshold(0, f"{b} better < 0 < worse", vertical=True)
    for i, row in enumerate(rows):
        mean, noise = 1e3 * row.mean, 1e3 * row.noise
        both = result.placements[i].models
        trained = both[pair.a].trained_on or both[pair.b].trained_on
        panel.span(i, mean - noise, mean + noise, "link", thick=5)
        mark = f"model-{pair.b % COLOURS}" + (" train" if trained else "")
        panel.mark(i, mean, mark, f"{places[i]}: {mean:+.3f} mm", size=5.5)
    return Plot(
        "differences",
        "Difference of the last two",
        sentence(result, pair),
        (panel.root,),
        (("hollow", "hollow: one was trained on it"),),
        "half",
    )


def _distances(result: ComparisonDocument) -> Plot | None:
    places, models = _names(result)
    errors = [
        [None if (e := model.distance_error) is None else 1e3 * e for model in row.models]
        for row in result.placements
    ]
    values = [abs(value) for row in errors for value in row if value is not None]
    if not values:
        return None
    half = 1.1 * max(*values, 1e-6)
    title = "socket distance, predicted less measured"
    panel = Rows(title, places, Axis(-half, half, "mm"), pitch=28)
    panel.vertical(0, "zero")
    for i, row in enumerate(result.placements):
        for k, value in enumerate(errors[i]):
            if value is not None:
                mark = _mark(k, row.models[k])
                panel.mark(i, value, mark, f"{places[i]}, {models[k]}: {value:+.3f} mm", size=5.5)
    worst = [
        f"{max(abs(row[k] or 0.0) for row in errors):.3f} mm by {name}"
        for k, name in enumerate(models)
    ]
    words = f"The sockets' distance is off by at most {joined(worst)}."
    return Plot("distances", "Socket distance", words, (panel.root,), _legend(models), "half")


def _mark(k: int, model: ErrorsAtPlacement) -> str:
    return f"model-{k % COLOURS}" + (" train" if model.trained_on else "")


def comparison_page(result: ComparisonDocument) -> str:
    """Return the comparison as HTML."""
    sentences = [tag("li", sentence(result, pair)) for pair in result.pairs]
    last = result.pairs[-1]
    a, b = result.models[last.a].name, result.models[last.b].name
    apart = (
        f"Moved onto each other, {a} and {b} put the ball {mm(last.apart.mean)} apart on "
        f"average and {mm(last.apart.max)} at most."
    )
    body = [
        tag(
            "header",
            tag("p", "Comparison of calibrations", class_="kicker"),
            tag("h1", result.robot_name),
        ),
        tag(
            "section",
            tag("h2", "What is better"),
            tag("ul", sentences),
            tag("p", apart),
            _summary(result),
        ),
        tag(
            "section",
            tag("h2", "Where"),
            [plot.element() for plot in comparison_plots(result)],
            class_="plots",
        ),
        _placements(result),
    ]
    data = {"figures": encode(result, compact=True)}
    return frame(f"Comparison, {result.robot_name}", body, data)


def _summary(result: ComparisonDocument) -> Element:
    rows: list[list[Cell]] = []
    for k, row in enumerate(result.models):
        path = f"models.{k}.summary"
        keys = ("mean_absolute_error", "p95", "max", "distance_error")
        cells = [figure(result, f"{path}.{key}") if row.summary else "-" for key in keys]
        rows.append([row.name, *cells])
    heads = ["model", "MAE, mm", "95 %, mm", "largest, mm", "socket distance error, mm"]
    count = plural(len(result.fair), "placement")
    return tag("div", table(heads, rows), tag("p", f"On {count} that none of them was trained on."))


def _placements(result: ComparisonDocument) -> Element:
    places, models = _names(result)
    rows: list[list[Cell]] = []
    for i, row in enumerate(result.placements):
        cells: list[Cell] = [
            tag("span", places[i], class_="named"),
            "+".join(map(str, row.samples)),
        ]
        for k, model in enumerate(row.models):
            shown = figure(result, f"placements.{i}.models.{k}.mean_absolute_error")
            cells.append([shown, " (trained on)"] if model.trained_on else shown)
        rows.append(cells)
    heads = ["placement", "samples", *models]
    return tag("section", tag("h2", "MAE by placement, mm"), table(heads, rows, "cards"))

"""Plots of a comparison of calibrations: errors, differences and distances by placement."""

from ....solver.assessment import joined, mm, short_names
from ..figures import ComparisonDocument, ErrorsAtPlacement, comparison_sentence
from .figure import Axis, Rows
from .plot import COLOURS, HOLLOW, Plot


def comparison_plots(result: ComparisonDocument) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(result), _differences(result), _distances(result))
    return [plot for plot in made if plot is not None]


def _names(result: ComparisonDocument) -> tuple[list[str], list[str]]:
    """Return the names of the placements and of the models."""
    places = short_names([row.name for row in result.placements])
    return places, [row.name for row in result.models]


def _mark(k: int, model: ErrorsAtPlacement | None = None) -> str:
    trained = model is not None and model.trained_on
    return f"model-{k % COLOURS}" + (" train" if trained else "")


def _errors(result: ComparisonDocument) -> Plot:
    places, models = _names(result)
    values = [1e3 * model.mean_absolute_error for row in result.placements for model in row.models]
    low, high = max(min(values), 1e-6) / 1.4, max(*values, 1e-6) * 1.4
    panel = Rows("error at each placement", places, Axis(low, high, "MAE, mm", log=True), pitch=28)
    for i, row in enumerate(result.placements):
        for k, model in enumerate(row.models):
            value = 1e3 * model.mean_absolute_error
            panel.mark(i, value, _mark(k, model), f"{places[i]}, {models[k]}: {value:.3f} mm")
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
    legend = (*((_mark(k), name) for k, name in enumerate(models)), HOLLOW)
    return Plot("errors", "Error by placement", words, (panel,), legend, "half")


def _differences(result: ComparisonDocument) -> Plot:
    places, models = _names(result)
    pair = result.pairs[-1]
    a, b = models[pair.a], models[pair.b]
    half = 1.1e3 * max(*(abs(row.mean) + row.noise for row in pair.placements), 1e-9)
    panel = Rows(f"{b} less {a}", places, Axis(-half, half, "mm, with 95 % noise"), pitch=28)
    panel.upright_threshold(0, f"{b} better < 0 < worse")
    for i, row in enumerate(pair.placements):
        mean, noise = 1e3 * row.mean, 1e3 * row.noise
        one, other = (result.placements[i].models[k] for k in (pair.a, pair.b))
        panel.span(i, mean - noise, mean + noise, "link", thick=5)
        mark = _mark(pair.b, one if one.trained_on else other)
        panel.mark(i, mean, mark, f"{places[i]}: {mean:+.3f} mm")
    return Plot(
        "differences",
        "Difference of the last two",
        comparison_sentence(result, pair),
        (panel,),
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
                hint = f"{places[i]}, {models[k]}: {value:+.3f} mm"
                panel.mark(i, value, _mark(k, row.models[k]), hint)
    worst = [
        f"{max(abs(row[k] or 0.0) for row in errors):.3f} mm by {name}"
        for k, name in enumerate(models)
    ]
    words = f"The sockets' distance is off by at most {joined(worst)}."
    legend = tuple((_mark(k), name) for k, name in enumerate(models))
    return Plot("distances", "Socket distance", words, (panel,), legend, "half")

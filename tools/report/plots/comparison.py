"""Plots of a comparison of calibrations: errors, differences and distances by placement."""

from collections.abc import Callable

from ....solver.assessment import joined, mm, short_names
from ..figures import ComparisonDocument, ErrorsAtPlacement, comparison_sentence
from .figure import Axis, Panel, named_rows
from .plot import COLOURS, HOLLOW, Plot


def comparison_plots(result: ComparisonDocument) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(result), _differences(result), _distances(result))
    return [plot for plot in made if plot is not None]


def _mark(k: int, model: ErrorsAtPlacement) -> str:
    return f"model-{k % COLOURS}" + (" train" if model.trained_on else "")


def _legend(result: ComparisonDocument) -> tuple[tuple[str, str], ...]:
    return tuple((f"model-{k % COLOURS}", row.name) for k, row in enumerate(result.models))


def _places(result: ComparisonDocument) -> list[str]:
    return short_names([row.name for row in result.placements])


def _by_model(
    result: ComparisonDocument,
    title: str,
    axis: Axis,
    figure: Callable[[ErrorsAtPlacement], float | None],
    form: str,
) -> Panel:
    """Return a panel with a figure of each model at each placement [m]."""
    places = _places(result)
    panel = named_rows(title, places, axis, pitch=28)
    if axis.low < 0:
        panel.rule("zero", x=0)
    for i, row in enumerate(result.placements):
        for k, model in enumerate(row.models):
            if (value := figure(model)) is not None:
                hint = f"{places[i]}, {result.models[k].name}: {1e3 * value:{form}} mm"
                panel.dot(1e3 * value, i, _mark(k, model), hint, size=5.5)
    return panel


def _errors(result: ComparisonDocument) -> Plot:
    models = [model for row in result.placements for model in row.models]
    axis = Axis.logarithmic((1e3 * model.mean_absolute_error for model in models), "MAE, mm", 1.4)
    panel = _by_model(
        result, "error at each placement", axis, lambda model: model.mean_absolute_error, ".3f"
    )
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
    return Plot("errors", "Error by placement", words, (panel,), (*_legend(result), HOLLOW), "half")


def _differences(result: ComparisonDocument) -> Plot:
    places, pair = _places(result), result.pairs[-1]
    a, b = (result.models[k].name for k in (pair.a, pair.b))
    ends = [1e3 * (abs(row.mean) + row.noise) for row in pair.placements]
    axis = Axis.around_zero(ends, "mm, with 95 % noise")
    panel = named_rows(f"{b} less {a}", places, axis, pitch=28)
    panel.threshold(f"{b} better < 0 < worse", x=0)
    for i, row in enumerate(pair.placements):
        mean, noise = 1e3 * row.mean, 1e3 * row.noise
        one, other = (result.placements[i].models[k] for k in (pair.a, pair.b))
        panel.bar(i, mean - noise, mean + noise, "link", thick=5)
        mark = _mark(pair.b, one if one.trained_on else other)
        panel.dot(mean, i, mark, f"{places[i]}: {mean:+.3f} mm", size=5.5)
    return Plot(
        "differences",
        "Difference of the last two",
        comparison_sentence(result, pair),
        (panel,),
        (("hollow", "hollow: one was trained on it"),),
        "half",
    )


def _distances(result: ComparisonDocument) -> Plot | None:
    errors = [[model.distance_error for model in row.models] for row in result.placements]
    known = [1e3 * error for row in errors for error in row if error is not None]
    if not known:
        return None
    axis = Axis.around_zero(known, "mm")
    title = "socket distance, predicted less measured"
    panel = _by_model(result, title, axis, lambda model: model.distance_error, "+.3f")
    worst = [
        f"{1e3 * max(abs(row[k] or 0.0) for row in errors):.3f} mm by {model.name}"
        for k, model in enumerate(result.models)
    ]
    words = f"The sockets' distance is off by at most {joined(worst)}."
    return Plot("distances", "Socket distance", words, (panel,), _legend(result), "half")

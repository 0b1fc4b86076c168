"""Plots of a comparison of calibrations: errors, differences and distances by placement."""

from collections.abc import Callable

from ....solver.assessment import short_names
from ..figures import ComparisonDocument, ErrorsAtPlacement, comparison_sentence
from .figure import Axis, Panel, named_rows
from .plot import COLOURS, Plot, plot


def comparison_plots(result: ComparisonDocument) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(result), _differences(result), _distances(result))
    return [plot for plot in made if plot is not None]


def _mark(k: int, model: ErrorsAtPlacement) -> str:
    return f"model-{k % COLOURS}" + (" train" if model.trained_on else "")


def _by_model(
    result: ComparisonDocument,
    title: str,
    axis: Axis,
    figure: Callable[[ErrorsAtPlacement], float | None],
    form: str,
) -> Panel:
    """Return a panel with a figure of each model at each placement [m]."""
    places = short_names([row.name for row in result.placements])
    panel = named_rows(title, places, axis, pitch=28)
    if axis.low < 0:
        panel.rule("zero", x=0)
    for k, model in enumerate(result.models):
        each = [row.models[k] for row in result.placements]
        values = [None if (one := figure(row)) is None else 1e3 * one for row in each]
        panel.dots(values, [_mark(k, row) for row in each], model.name, form)
    return panel


def _errors(result: ComparisonDocument) -> Plot:
    models = [model for row in result.placements for model in row.models]
    axis = Axis.logarithmic((1e3 * model.mean_absolute_error for model in models), "MAE, mm", 1.4)
    title = "error at each placement"
    panel = _by_model(result, title, axis, lambda model: model.mean_absolute_error, ".3f")
    summaries = [(row.summary, row.name) for row in result.models]
    ranked = sorted((one.mean_absolute_error, name) for one, name in summaries if one is not None)
    models = result.models
    return plot("errors", panel, layout="half", ranked=ranked, models=models, colours=COLOURS)


def _differences(result: ComparisonDocument) -> Plot:
    pair = result.pairs[-1]
    a, b = (result.models[k].name for k in (pair.a, pair.b))
    means = [1e3 * row.mean for row in pair.placements]
    noises = [1e3 * row.noise for row in pair.placements]
    each = list(zip(means, noises, strict=True))
    axis = Axis.around_zero((abs(mean) + noise for mean, noise in each), "mm, with 95 % noise")
    places = short_names([row.name for row in result.placements])
    panel = named_rows(f"{b} less {a}", places, axis, pitch=28)
    panel.threshold(f"{b} better < 0 < worse", x=0)
    lows, highs = zip(*((mean - noise, mean + noise) for mean, noise in each), strict=True)
    panel.bars(lows, highs, "link", thick=5)
    trained = [any(row.models[k].trained_on for k in (pair.a, pair.b)) for row in result.placements]
    colour = f"model-{pair.b % COLOURS}"
    marks = [f"{colour} train" if hollow else colour for hollow in trained]
    panel.dots(means, marks, "difference", "+.3f")
    sentence = comparison_sentence(result, pair)
    return plot("differences", panel, layout="half", sentence=sentence)


def _distances(result: ComparisonDocument) -> Plot | None:
    errors = [[model.distance_error for model in row.models] for row in result.placements]
    known = [1e3 * error for row in errors for error in row if error is not None]
    if not known:
        return None
    axis, title = Axis.around_zero(known, "mm"), "socket distance, predicted less measured"
    panel = _by_model(result, title, axis, lambda model: model.distance_error, "+.3f")
    worst = [
        (1e3 * max(abs(row[k] or 0.0) for row in errors), model.name)
        for k, model in enumerate(result.models)
    ]
    return plot("distances", panel, layout="half", worst=worst, colours=COLOURS)

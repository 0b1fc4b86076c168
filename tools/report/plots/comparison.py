"""Plots of compared calibrations by placement: errors, distances, the last two's difference."""

from collections.abc import Callable
from itertools import chain

import numpy as np

from ....solver.assessment import short_names
from ..figures import ComparisonDocument, ErrorsAtPlacement, comparison_sentence
from .axis import MM, Axis
from .figure import COLOURS, Plot, named_rows, plot
from .panel import Panel

PITCH = 28
"""Height of a placement's row, in the panel's units."""


def comparison_plots(result: ComparisonDocument) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(result), _differences(result), _distances(result))
    return list(filter(None, made))


def mark_of(model: int, *, hollow: bool) -> str:
    """Return the class of a model's marks, by its index."""
    mark = f"model-{model % COLOURS}"
    return f"{mark} train" if hollow else mark


def _by_model(
    result: ComparisonDocument,
    title: str,
    axis: Axis,
    figure: Callable[[ErrorsAtPlacement], float | None],
    form: str,
) -> Panel:
    """Return a panel with a length of each model at each placement."""
    panel = _placement_rows(result, title, axis)
    if axis.low < 0:
        panel.rule("zero", x=0)
    for k, model in enumerate(result.models):
        errors = [row.models[k] for row in result.placements]
        marks = [mark_of(k, hollow=row.trained_on) for row in errors]
        panel.dots(map(figure, errors), marks, model.name, form)
    return panel


def _placement_rows(result: ComparisonDocument, title: str, axis: Axis) -> Panel:
    names = [row.name for row in result.placements]
    return named_rows(title, short_names(names), axis, pitch=PITCH)


def _errors(result: ComparisonDocument) -> Plot:
    rows = chain.from_iterable(row.models for row in result.placements)
    errors = [row.mean_absolute_error for row in rows]
    panel = _by_model(
        result,
        "error at each placement",
        Axis.logarithmic(errors, "MAE, mm", MM, 1.4),
        lambda model: model.mean_absolute_error,
        ".3f",
    )
    ranked = sorted(
        (model.summary.mean_absolute_error, model.name)
        for model in result.models
        if model.summary
    )
    models = result.models
    return plot(
        "errors", panel, layout="half", ranked=ranked, models=models, colours=COLOURS
    )


def _differences(result: ComparisonDocument) -> Plot:
    pair = result.pairs[-1]
    a, b = result.models[pair.a].name, result.models[pair.b].name
    means, noises = np.array([(row.mean, row.noise) for row in pair.placements]).T
    axis = Axis.around_zero(abs(means) + noises, "mm, with 95 % noise", MM)
    panel = _placement_rows(result, f"{b} less {a}", axis)
    panel.threshold(f"{b} better < 0 < worse", x=0)
    panel.bars(means - noises, means + noises, "link", thick=5)
    marks: list[str] = []
    for row in result.placements:
        hollow = row.models[pair.a].trained_on or row.models[pair.b].trained_on
        marks.append(mark_of(pair.b, hollow=hollow))
    panel.dots(means, marks, "difference", "+.3f")
    sentence = comparison_sentence(result, pair)
    return plot("differences", panel, layout="half", sentence=sentence)


def _distances(result: ComparisonDocument) -> Plot | None:
    worst: list[tuple[float, str]] = []
    for k, model in enumerate(result.models):
        errors = [row.models[k].distance_error or 0.0 for row in result.placements]
        worst.append((MM * max(map(abs, errors)), model.name))
    largest, _ = max(worst)
    if not largest:
        return None
    panel = _by_model(
        result,
        "socket distance, predicted less measured",
        Axis.around_zero([largest / MM], "mm", MM),
        lambda model: model.distance_error,
        "+.3f",
    )
    return plot(
        "distances",
        panel,
        layout="half",
        worst=worst,
        colours=COLOURS,
    )

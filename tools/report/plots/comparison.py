"""Plots of compared models: calibrations by placement; pegs and lines of a simulated experiment."""

from collections.abc import Callable
from itertools import chain
from pathlib import Path

import numpy as np

from ....solver.assessment import nice_above, short_names
from ...experiments import ModelTrials, SimulationDocument
from ..figures import ComparisonDocument, ErrorsAtPlacement, comparison_sentence
from .axis import MM, Axis
from .figure import COLOURS, Panel, Plot, named_rows, plot


def comparison_plots(result: ComparisonDocument) -> list[Plot]:
    """Return the plots of a comparison."""
    made = (_errors(result), _differences(result), _distances(result))
    return [picture for picture in made if picture is not None]


def _by_model(
    result: ComparisonDocument,
    title: str,
    axis: Axis,
    figure: Callable[[ErrorsAtPlacement], float | None],
    form: str,
) -> Panel:
    """Return a panel with a length of each model at each placement."""
    places = short_names([row.name for row in result.placements])
    panel = named_rows(title, places, axis, pitch=28)
    if axis.low < 0:
        panel.rule("zero", x=0)
    for k, model in enumerate(result.models):
        errors = [row.models[k] for row in result.placements]
        marks = [_mark(k, hollow=row.trained_on) for row in errors]
        panel.dots(map(figure, errors), marks, model.name, form)
    return panel


def _mark(model: int, *, hollow: bool) -> str:
    return f"model-{model % COLOURS}{' train' * hollow}"


def _errors(result: ComparisonDocument) -> Plot:
    rows = chain.from_iterable(row.models for row in result.placements)
    errors = [row.mean_absolute_error for row in rows]
    axis = Axis.logarithmic(errors, "MAE, mm", MM, 1.4)
    title = "error at each placement"
    panel = _by_model(
        result, title, axis, lambda model: model.mean_absolute_error, ".3f"
    )
    models = result.models
    judged = [
        (row.summary.mean_absolute_error, row.name) for row in models if row.summary
    ]
    return plot(
        "errors",
        panel,
        layout="half",
        ranked=sorted(judged),
        models=models,
        colours=COLOURS,
    )


def _differences(result: ComparisonDocument) -> Plot:
    pair = result.pairs[-1]
    a = result.models[pair.a].name
    b = result.models[pair.b].name
    means = np.array([row.mean for row in pair.placements])
    noises = np.array([row.noise for row in pair.placements])
    axis = Axis.around_zero(abs(means) + noises, "mm, with 95 % noise", MM)
    places = short_names([row.name for row in result.placements])
    panel = named_rows(f"{b} less {a}", places, axis, pitch=28)
    panel.threshold(f"{b} better < 0 < worse", x=0)
    panel.bars(means - noises, means + noises, "link", thick=5)
    marks: list[str] = []
    for row in result.placements:
        hollow = row.models[pair.a].trained_on or row.models[pair.b].trained_on
        marks.append(_mark(pair.b, hollow=hollow))
    panel.dots(means, marks, "difference", "+.3f")
    sentence = comparison_sentence(result, pair)
    return plot("differences", panel, layout="half", sentence=sentence)


def _distances(result: ComparisonDocument) -> Plot | None:
    worst: list[tuple[float, str]] = []
    for k, model in enumerate(result.models):
        errors = [row.models[k].distance_error for row in result.placements]
        worst.append((MM * max(abs(error or 0.0) for error in errors), model.name))
    largest, _ = max(worst)
    if not largest:
        return None
    axis = Axis.around_zero([largest / MM], "mm", MM)
    title = "socket distance, predicted less measured"
    panel = _by_model(result, title, axis, lambda model: model.distance_error, "+.3f")
    return plot("distances", panel, layout="half", worst=worst, colours=COLOURS)


PEG = 0.01
"""Its diameter [m]."""
PAPER = 0.5
"""Position of the drawing's middle along x [m]."""


def simulation_plot(result: SimulationDocument) -> Plot:
    """Return the trials one by one, of each model."""
    models = (result,) if result.beside is None else (result.beside, result)
    if result.drawing is not None:
        return plot("lines", *map(_lines, models))
    clearance = ((result.hole or PEG) - PEG) / 2
    return plot(
        "misses", *(_misses(k, model, clearance) for k, model in enumerate(models))
    )


def _misses(k: int, model: ModelTrials, clearance: float) -> Panel:
    """Return the peg's positions just before it went down, by the true kinematics."""
    trials = [trials.each for trials in (model.centre, model.cross) if trials]
    insertions = list(chain(*trials))
    misses = chain(*(trial.miss[:2] for trial in insertions))
    reach = max(clearance, *map(abs, misses))
    panel = _square(model, nice_above(1.05 * reach), "mm along x", "mm along y")
    panel.dot(0, 0, "threshold", size=panel.x(clearance) - panel.x(0))
    for trial in insertions:
        x, y = trial.miss[:2]
        hint = (
            f"{MM * x:+.2f}, {MM * y:+.2f} mm; {'in' if trial.inserted else 'not in'}"
        )
        panel.dot(x, y, _mark(k, hollow=not trial.inserted), hint, 4)
    return panel


def _lines(model: ModelTrials) -> Panel:
    panel = _square(model, 0.1, "mm to the right", "mm ahead")
    for i, stroke in enumerate(model.drawing.each if model.drawing else ()):
        line = [(-y, x - PAPER) for x, y in stroke.line]
        panel.line(line, f"curve model-{i % COLOURS}")
    return panel


def _square(model: ModelTrials, half: float, x: str, y: str) -> Panel:
    """Return a panel from -half to half [m] both ways, to the same scale."""
    axes = [Axis(-half, half, label, MM) for label in (x, y)]
    return Panel(Path(model.model).name, *axes, height=460).grid()

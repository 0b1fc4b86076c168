"""Page of a simulated experiment: both models side by side, where pegs went down, and lines."""

import base64
from collections.abc import Mapping
from itertools import chain
from pathlib import Path

from ...errors import fixed
from ...solver.assessment import nice_above
from ..report import render
from ..report.plots import COLOURS, MM, Axis, Panel, Plot, mark_of, plot
from .results import ModelTrials, SimulationDocument

PEG = 0.01
"""Its diameter [m]."""
PAPER = 0.5
"""Position of the drawing's middle along x [m]."""


def simulation_page(result: SimulationDocument, pictures: Mapping[str, bytes]) -> str:
    """Return a simulated experiment with both models as HTML, and its pictures by file name."""
    models: list[tuple[str, ModelTrials]] = [("", result)]
    if result.beside is not None:
        models.insert(0, ("beside.", result.beside))
    return render(
        "simulation.html.j2",
        result,
        result=result,
        models=[(Path(model.model).name, path, model) for path, model in models],
        pictures={
            name: f"data:image/{name.rpartition('.')[2]};base64,{base64.b64encode(file).decode()}"
            for name, file in pictures.items()
        },
        plot=_plot(result),
    )


def _plot(result: SimulationDocument) -> Plot:
    """Return the trials one by one, of each model."""
    models = (result,) if result.beside is None else (result.beside, result)
    if result.drawing is not None:
        return plot("lines", *map(_lines, models))
    hole = result.hole or PEG
    clearance = (hole - PEG) / 2
    panels = [_misses(k, model, clearance) for k, model in enumerate(models)]
    return plot("misses", *panels)


def _misses(k: int, model: ModelTrials, clearance: float) -> Panel:
    """Return the peg's positions just before it went down, by the true kinematics."""
    places = [trials for trials in (model.centre, model.cross) if trials]
    insertions = list(chain.from_iterable(trials.each for trials in places))
    offsets = chain.from_iterable(trial.miss[:2] for trial in insertions)
    half = nice_above(1.05 * max(clearance, *map(abs, offsets)))
    panel = _square(model, half, "mm along x", "mm along y")
    panel.dot(0, 0, "threshold", size=panel.x(clearance) - panel.x(0))
    for trial in insertions:
        x, y = trial.miss[:2]
        outcome = "in" if trial.inserted else "not in"
        hint = f"{fixed(MM * x, 2, '+')}, {fixed(MM * y, 2, '+')} mm; {outcome}"
        mark = mark_of(k, hollow=not trial.inserted)
        panel.dot(
            x,
            y,
            mark,
            hint,
            4,
        )
    return panel


def _lines(model: ModelTrials) -> Panel:
    panel = _square(model, 0.1, "mm to the right", "mm ahead")
    strokes = model.drawing.each if model.drawing else ()
    for i, stroke in enumerate(strokes):
        line = [(-y, x - PAPER) for x, y in stroke.line]
        panel.line(line, f"curve model-{i % COLOURS}")
    return panel


def _square(model: ModelTrials, half: float, x: str, y: str) -> Panel:
    """Return a panel from -half to half [m] both ways, to the same scale."""
    name = Path(model.model).name
    across = Axis(-half, half, x, MM)
    up = Axis(-half, half, y, MM)
    return Panel(name, across, up, height=460).grid()

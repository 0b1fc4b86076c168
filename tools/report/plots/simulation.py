"""Plots of a simulated experiment: peg positions above the hole, or drawn lines, by model."""

from pathlib import Path

from ....solver.assessment import nice_above
from ...experiments import ModelTrials, SimulationDocument
from .figure import Axis, Panel
from .plot import COLOURS, Plot, plot

PEG = 0.01
"""Its diameter [m]."""
PAPER = 0.5
"""Position of the drawing's middle along x [m]."""


def simulation_plot(result: SimulationDocument) -> Plot:
    """Return the trials one by one, of each model."""
    models = (result,) if result.beside is None else (result.beside, result)
    if result.drawing is not None:
        return plot("lines", *map(_lines, models))
    clearance = 1e3 * ((result.hole or PEG) - PEG) / 2
    return plot("misses", *(_misses(k, model, clearance) for k, model in enumerate(models)))


def _misses(k: int, model: ModelTrials, clearance: float) -> Panel:
    """Return the peg's positions just before it went down, by the true kinematics."""
    each = [one for trials in (model.centre, model.cross) if trials for one in trials.each]
    reach = max(clearance, *(1e3 * abs(x) for one in each for x in one.miss[:2]))
    panel = _square(model, nice_above(1.05 * reach), "mm along x", "mm along y")
    panel.dot(0, 0, "threshold", size=panel.x(clearance) - panel.x(0))
    for one in each:
        x, y = (1e3 * value for value in one.miss[:2])
        hint = f"{x:+.2f}, {y:+.2f} mm; {'in' if one.inserted else 'not in'}"
        panel.dot(x, y, f"model-{k}" + ("" if one.inserted else " train"), hint, 4)
    return panel


def _lines(model: ModelTrials) -> Panel:
    panel = _square(model, 100, "mm to the right", "mm ahead")
    for i, one in enumerate(model.drawing.each if model.drawing else ()):
        line = [(-1e3 * y, 1e3 * (x - PAPER)) for x, y in one.line]
        panel.line(line, f"curve model-{i % COLOURS}")
    return panel


def _square(model: ModelTrials, half: float, x: str, y: str) -> Panel:
    """Return a panel from -half to half both ways, to the same scale."""
    axes = Axis(-half, half, x), Axis(-half, half, y)
    return Panel(Path(model.model).name, *axes, height=460).grid()

"""Results of a simulated experiment, as ``mukca simulate --json`` prints them, and their page."""

import base64
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from ...errors import fixed
from ...solver.assessment import nice_above
from ...solver.results import Document
from ..report import render
from ..report.plots import COLOURS, MM, Axis, Panel, Plot, mark_of, plot


class Statistics(Document):
    """Mean and range of some trials' values."""

    mean: float
    min: float
    max: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Statistics":
        """Return those of some values."""
        return cls(mean=float(np.mean(values)), min=min(values), max=max(values))


class Motion(Document):
    """One trial."""

    elbow: float
    """Its angle at the start, zero where it is up [rad]."""
    force: float
    """Mean magnitude of the contact force [N]."""
    peak_force: float


class Insertion(Motion):
    """One peg put into a hole, or beside it."""

    hole: tuple[float, ...]
    """True position of its axis on the table [m]."""
    inserted: bool
    depth: float
    """Final depth of the tip below the hole's rim, negative above it [m]."""
    miss: tuple[float, float, float]
    """Offset of the peg above the hole, just before it went down [m]."""


class Retracing(Motion):
    """One line drawn."""

    tracking_error: float
    """Mean distance of the line's points from the demonstrated figure [m]."""
    touching: float
    """Share of the time in which the pen touched the paper."""
    line: tuple[tuple[float, float], ...]
    """The pen's true path over the paper [m]."""


class Trials(Document):
    """All trials with one model at one place."""

    tracking_error: float
    """Mean distance of the tool from where it should be [m]."""
    max_tracking_error: float
    force: Statistics
    """Mean force of each trial [N]."""
    peak_force: Statistics

    @staticmethod
    def of(motions: Sequence[Motion], errors: Sequence[float]) -> "Trials":
        """Return errors and forces of some trials, by their tracking errors [m]."""
        return Trials(
            tracking_error=float(np.mean(errors)),
            max_tracking_error=max(errors),
            force=Statistics.of([motion.force for motion in motions]),
            peak_force=Statistics.of([motion.peak_force for motion in motions]),
        )


class Insertions(Trials):
    """Pegs put into holes."""

    inserted: int
    trials: int
    each: tuple[Insertion, ...]


class Drawing(Trials):
    """Lines drawn one over the other."""

    retracings: int
    spread: float
    """Largest distance between any two lines at one moment, mean over time [m]."""
    max_spread: float
    each: tuple[Retracing, ...]


class ModelTrials(Document):
    """All trials of one model."""

    model: str
    centre: Insertions | None = None
    """At the place where it was taught."""
    cross: Insertions | None = None
    """At other places."""
    drawing: Drawing | None = None


class SimulationDocument(ModelTrials):
    """The whole experiment."""

    experiment: str
    """``insertion`` or ``drawing``."""
    arm: int
    """Seed of the true arm."""
    seed: int
    hole: float | None = None
    """Its diameter, for insertions [m]."""
    beside: ModelTrials | None = None
    """The other model, where two were compared."""
    outputs: dict[str, str] | None = None
    """The files written, by kind."""


PEG = 0.01
"""Its diameter [m]."""
PAPER = 0.5
"""Position of the drawing's middle along x [m]."""


def simulation_page(result: SimulationDocument, pictures: Mapping[str, bytes]) -> str:
    """Return a simulated experiment with both models as HTML, and its pictures by file name."""
    models: list[tuple[str, ModelTrials]] = [("", result)]
    if result.beside:
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
    models = (result.beside, result) if result.beside else (result,)
    if result.drawing:
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
    return Panel(name, across, Axis(-half, half, y, MM), height=460).grid()

"""Results of a simulated experiment, as ``mukca simulate --json`` prints them, in SI units."""

from collections.abc import Sequence

import numpy as np

from ...solver.results import Document


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

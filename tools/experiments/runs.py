"""An experiment with one model: settings, the model that the controller is given, and results."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import read_bytes
from ...recorder import Placement
from ...solver.calibration import calibrate
from ...solver.identification.robot import ModelError, Robot
from ..simulation import SEAT_NOISE, Base, demo_bases, record
from .motion import Cell, Result, Trial
from .results import ModelTrials
from .scene import Scene, urdf_of
from .tasks import (
    drawing_results,
    insert_at_centre,
    insert_on_cross,
    insertion_results,
    retrace,
)

WORDS = ("nominal", "calibrated", "true")
FAR = Base("far", np.array([0.6, 0.0, 0.1]), np.array([1.0, 0.0, 0.0]))
"""Recorded besides the demo's bases."""


@dataclass(frozen=True)
class Settings:
    """An experiment: its trials, and their seed."""

    trials: int
    """Insertions at the centre, or retracings of the drawing."""
    seed: int
    """Of teaching and starts."""
    hole: float | None = None
    """Its diameter [m]; None for a drawing."""
    cross: int = 0
    """Insertions on the X."""

    @property
    def count(self) -> int:
        """Number of motions with one model."""
        return self.trials + self.cross


@dataclass(frozen=True)
class ExperimentRun:
    """An experiment with one model, and its results."""

    results: ModelTrials
    scene: Scene
    trials: Sequence[Trial[Any]]
    """At the centre, or of the drawing."""


def run_experiment(
    settings: Settings,
    arm: Robot,
    name: str,
    urdf: bytes,
    progress: Callable[[str], None],
) -> ExperimentRun:
    """Try a model, by its name and text, on the true arm; progress is told the name each motion.

    Raises:
        ModelError: The model is not one of this arm.
        SimulationError: The arm cannot reach a place.
    """
    try:
        cell = Cell(arm, urdf, settings.hole)
    except ModelError as error:
        raise ModelError(
            f"model {name!r}: {error}; give one solved for this arm"
        ) from None

    def counted(trials: Iterator[Trial[Result]]) -> Iterator[Trial[Result]]:
        for trial in trials:
            progress(name)
            yield trial

    if settings.hole is None:
        lines = list(counted(retrace(cell, settings.trials, settings.seed)))
        results = ModelTrials(model=name, drawing=drawing_results(lines))
        return ExperimentRun(results, cell.scene, lines)
    trials = list(counted(insert_at_centre(cell, settings.trials, settings.seed)))
    cross = None
    if settings.cross:
        on_cross = list(counted(insert_on_cross(cell, settings.cross, settings.seed)))
        cross = insertion_results(on_cross)
    results = ModelTrials(model=name, centre=insertion_results(trials), cross=cross)
    return ExperimentRun(results, cell.scene, trials)


def record_placements(arm: Robot, seed: int) -> list[Placement]:
    """Return four placements recorded with an arm, 30 configurations in each socket."""
    generator = np.random.default_rng([seed, 2])
    bases = (*demo_bases(), FAR)
    return [record(arm, base, generator, noise=SEAT_NOISE) for base in bases]


def model_urdf(word: str, nominal: Robot, arm: Robot, seed: int) -> bytes:
    """Return a model's text: ``nominal``, ``calibrated`` by recordings made now, ``true``, a file.

    The seed is that of the recordings; a file that cannot be read is a ModelError.
    """
    if word == "nominal":
        return nominal.text.data
    if word == "calibrated":
        # In the order of their names, as `mukca solve` reads them from a folder.
        placements = sorted(
            record_placements(arm, seed), key=lambda placement: placement.name
        )
        return calibrate(nominal, placements, no_proof=True).calibrated.urdf()
    if word == "true":
        return urdf_of(arm)
    try:
        return read_bytes(word)
    except OSError as error:
        words = ", ".join(WORDS)
        reason = error.strerror or "cannot be read"
        raise ModelError(
            f"model {word!r}: {reason}; give a URDF file, or {words}"
        ) from None

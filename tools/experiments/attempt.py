"""An experiment as it is asked for, and what came of it with one model."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from ...solver.robot import ModelError, Robot
from .cell import build_cell
from .drawing import Retracing, retrace
from .insertion import Trial, insert_at_centre, insert_on_cross
from .results import drawing_figures, insertion_figures
from .scene import Scene

One = TypeVar("One", Trial, Retracing)


@dataclass(frozen=True)
class Settings:
    """What is tried."""

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
        """How many motions one model makes."""
        return self.trials + self.cross


@dataclass(frozen=True)
class ExperimentRun:
    """What came of it."""

    model: str
    """Name of the model that the controller was given."""
    figures: dict[str, Any]
    """By place, or of the drawing; SI units."""
    scene: Scene
    trials: Sequence[Trial | Retracing]
    """At the centre, or of the drawing."""


def attempt(
    settings: Settings, arm: Robot, name: str, urdf: bytes, progress: Callable[[str], None]
) -> ExperimentRun:
    """Try a model on an arm.

    Args:
        settings: What is tried.
        arm: The arm as it truly is.
        name: Of the model.
        urdf: Its text.
        progress: Told the name after each motion.

    Raises:
        ModelError: The model is not one of this arm.
        SimulationError: The arm cannot reach a place.
    """
    try:
        cell = build_cell(arm, urdf, settings.hole)
    except ModelError as error:
        raise ModelError(f"model {name!r}: {error}; give one solved for this arm") from None
    if settings.hole is None:
        lines = _each(retrace(cell, settings.trials, settings.seed), name, progress)
        return ExperimentRun(name, {"drawing": drawing_figures(lines)}, cell.scene, lines)
    trials = _each(insert_at_centre(cell, settings.trials, settings.seed), name, progress)
    figures = {"centre": insertion_figures(trials)}
    if settings.cross:
        on_cross = insert_on_cross(cell, settings.cross, settings.seed)
        figures["cross"] = insertion_figures(_each(on_cross, name, progress))
    return ExperimentRun(name, figures, cell.scene, trials)


def _each(motions: Iterable[One], name: str, progress: Callable[[str], None]) -> list[One]:
    done: list[One] = []
    for motion in motions:
        progress(name)
        done.append(motion)
    return done

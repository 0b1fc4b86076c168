"""What the experiments measured, as plain numbers in SI units."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .drawing import Retracing, spread
from .insertion import Trial


def insertion_figures(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return counts, tracking errors and forces of some insertions, and each by itself."""
    errors = [trial.tracking_error for trial in trials]
    return {
        "inserted": sum(trial.inserted for trial in trials),
        "trials": len(trials),
        "tracking_error": float(np.mean(errors)),
        "max_tracking_error": max(errors),
        "force": _statistics([float(trial.forces.mean()) for trial in trials]),
        "peak_force": _statistics([float(trial.forces.max()) for trial in trials]),
        "each": [_insertion(trial) for trial in trials],
    }


def _insertion(trial: Trial) -> dict[str, Any]:
    return {
        "hole": trial.hole.tolist(),
        "elbow": trial.elbow,
        "inserted": trial.inserted,
        "depth": trial.depth,
        "miss": trial.miss.tolist(),
        "force": float(trial.forces.mean()),
        "peak_force": float(trial.forces.max()),
    }


def drawing_figures(retracings: Sequence[Retracing]) -> dict[str, Any]:
    """Return how far apart the lines lie, and what each retracing came to."""
    apart = spread(retracings)
    errors = [retracing.tracking_error for retracing in retracings]
    return {
        "retracings": len(retracings),
        "spread": float(apart.mean()),
        "max_spread": float(apart.max()),
        "tracking_error": float(np.mean(errors)),
        "max_tracking_error": max(errors),
        "force": _statistics([float(retracing.forces.mean()) for retracing in retracings]),
        "peak_force": _statistics([float(retracing.forces.max()) for retracing in retracings]),
        "each": [_retracing(retracing) for retracing in retracings],
    }


def _retracing(retracing: Retracing) -> dict[str, Any]:
    return {
        "elbow": retracing.elbow,
        "tracking_error": retracing.tracking_error,
        "touching": float(retracing.touching.mean()),
        "force": float(retracing.forces.mean()),
        "peak_force": float(retracing.forces.max()),
        "line": np.round(retracing.line[::LINE_EVERY], 6).tolist(),
    }


LINE_EVERY = 20
"""Rows of a log from one point of a line to the next."""


def _statistics(values: Sequence[float]) -> dict[str, float]:
    """Return mean, least and largest of some trials' values."""
    numbers: np.ndarray = np.array(values)
    return {
        "mean": float(numbers.mean()),
        "min": float(numbers.min()),
        "max": float(numbers.max()),
    }

"""Decides by the data which extensions of the geometry to keep.

The geometry is fitted first. Then compliance is added, then tilt, then transmission error, each to
what was kept before. An extension is kept if it makes the evidence (see docs/model.md) at least 20
times as large. With three placements or more it must also prove itself: each placement is left out
of the fit once, and the errors there must fall by more than the standard error of that fall.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from ..data.observations import Observations
from ..paper.optimizers import NotConverged
from ..robot.parameters import Parameter
from ..robot.urdf import Robot
from .deflection import COMPLIANCE, TILT, TRANSMISSION
from .estimation import estimate
from .extended_model import extend
from .posterior import Posterior

__all__ = ["STAGES", "Selection", "held_out_error", "select_model"]

STAGES: dict[str, tuple[str, ...]] = {
    "compliance": (COMPLIANCE,),
    "tilt": (TILT,),
    "transmission": TRANSMISSION,
}
"""What is tried, in this order: name, and its extensions."""
GAIN = log(20)
"""By how much an extension must raise the logarithm of the evidence."""
ENOUGH_PLACEMENTS = 3


@dataclass(frozen=True)
class Selection:
    """The models that the data chose."""

    geometric: Posterior
    """The best model without extensions."""
    full: Posterior
    """The model with the extensions that the data support; the same one where there are none."""
    notes: tuple[str, ...]
    """One line for each extension: what became of it, and why."""


def select_model(
    robot: Robot,
    parameters: Sequence[Parameter],
    data: Observations,
    *,
    stages: Sequence[str] = tuple(STAGES),
    joint_noise: bool = True,
    progress: Callable[[str], None] = lambda _: None,
) -> Selection:
    """Calibrate the geometry, then try one extension after the other.

    Args:
        robot: The robot.
        parameters: What of its geometry is free.
        data: Training placements.
        stages: Which of :data:`STAGES` may be tried.
        joint_noise: Whether joint angles may be noisy.
        progress: Called with a word for each model that is fitted.

    Raises:
        NotConverged: The fit of the geometry did not settle.
    """

    def fit(near: Posterior | None, extensions: Sequence[str], observed: Observations) -> Posterior:
        model = extend(robot, parameters, extensions)
        return estimate(model, observed, joint_noise=joint_noise, near=near)

    placements = list(dict.fromkeys(name for name, _ in data.labels))
    progress("geometry")
    geometric = best = fit(None, (), data)
    notes: list[str] = []
    errors: np.ndarray | None = None
    for stage in (name for name in STAGES if name in stages):
        progress(stage)
        extensions = (*best.model.extensions, *STAGES[stage])
        try:
            candidate = fit(best, extensions, data)
        except NotConverged:
            notes.append(f"{stage}: not supported by the data (with it, the fit does not settle)")
            continue
        gain = candidate.log_evidence - best.log_evidence
        if _active(candidate) == _active(best) or gain < GAIN:
            notes.append(f"{stage}: not supported by the data (log evidence {gain:+.1f})")
            continue
        if len(placements) >= ENOUGH_PLACEMENTS:
            try:
                if errors is None:
                    errors = _left_out(fit, best, placements)
                with_it = _left_out(fit, candidate, placements)
            except NotConverged:
                notes.append(f"{stage}: dropped, the fit does not settle without each placement")
                continue
            helps, spread = _paired(errors, with_it)
            line = f"by {1e3 * helps:+.4f} +- {1e3 * spread:.4f} mm where one placement is left out"
            if helps <= spread:
                notes.append(f"{stage}: dropped, it lowers errors only {line}")
                continue
            notes.append(f"{stage}: kept (log evidence {gain:+.1f}), it lowers errors {line}")
            errors = with_it
        else:
            notes.append(f"{stage}: kept (log evidence {gain:+.1f})")
        best = candidate
    return Selection(geometric, best, tuple(notes))


def _active(found: Posterior) -> tuple[str, ...]:
    return tuple(group.name for group in found.groups if group.width)


def _left_out(
    fit: Callable[[Posterior, Sequence[str], Observations], Posterior],
    whole: Posterior,
    placements: Sequence[str],
) -> np.ndarray:
    """Return the mean error in each placement, of a model fitted to all others, shape (P,) [m].

    Args:
        fit: How models are fitted: near a result, with some extensions, to some data.
        whole: The model, fitted to all placements.
        placements: Their names.
    """
    data, extensions = whole.data, whole.model.extensions
    return np.array(
        [
            held_out_error(fit(whole, extensions, data.without(name)), data, name)
            for name in placements
        ]
    )


def held_out_error(found: Posterior, data: Observations, placement: str) -> float:
    """Return the mean absolute error of a model in one placement [m]."""
    distances: list[np.ndarray] = []
    for socket, (name, _) in enumerate(data.labels):
        if name == placement:
            rows = data.sockets == socket
            points = found.predict(data.positions[rows], data.torques[rows])
            distances.append(np.linalg.norm(points - points.mean(axis=0), axis=1))
    return float(np.concatenate(distances).mean())


def _paired(without: np.ndarray, with_it: np.ndarray) -> tuple[float, float]:
    """Return by how much the errors fall on average, and the standard error of that fall [m]."""
    fall = without - with_it
    return float(fall.mean()), float(fall.std(ddof=1) / np.sqrt(len(fall)))

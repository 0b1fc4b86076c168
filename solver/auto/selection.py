"""Decides by the data which extensions of the geometry to keep.

The geometry is fitted first. Then compliance is added, then tilt, then play (with zeros,
that is for servo arms), then transmission error, each to what was kept before. An extension is
kept if it makes the evidence (see docs/model.md) at least 150 times as large. With three placements
or more it must also prove itself: each placement is left out of the fit once, of very many some at
a time, and the errors there must fall by more than the standard error of that fall.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log

import numpy as np

from ..data.frames import FrameError, fit_pose
from ..data.observations import Observations, Scene
from ..paper.optimizers import NotConverged
from ..robot.parameters import Parameter
from ..robot.urdf import Robot
from .arms import Arms, as_scene
from .deflection import COMPLIANCE, PLAY, TILT, TRANSMISSION, ZERO
from .estimation import estimate_all
from .extended_model import extend
from .posterior import Posterior, World
from .zeros import zeros_in_words

__all__ = ["STAGES", "Selected", "Selection", "held_out_error", "select_all", "select_model"]

STAGES: dict[str, tuple[str, ...]] = {
    "compliance": (COMPLIANCE,),
    "tilt": (TILT,),
    "play": (PLAY,),
    "transmission": TRANSMISSION,
}
"""What is tried, in this order: name, and its extensions."""
GAIN = log(150)
"""By how much an extension must raise the logarithm of the evidence. On simulated arms without
elasticity or transmission error, it never rose by more than 2.6; true ones that raise it by less
than 5 made errors elsewhere no smaller."""
ENOUGH_PLACEMENTS = 3
PARTS = 10
"""Into so many parts are placements divided at most, each of which is left out once: the time of
a fit to the others grows with their number, and so would the number of fits."""


@dataclass(frozen=True)
class Selection:
    """The models that the data chose, of one robot."""

    geometric: Posterior
    """The best model without extensions."""
    full: Posterior
    """The model with the extensions that the data support; the same one where there are none."""
    notes: tuple[str, ...]
    """One line for each extension: what became of it, and why."""


@dataclass(frozen=True)
class Selected:
    """The models that the data chose, of all robots."""

    geometric: World
    full: World
    notes: tuple[tuple[str, ...], ...]
    """For each robot, one line for each extension."""


Free = tuple[Robot, Sequence[Parameter]]
"""A robot, and what of its geometry is free."""


def select_model(
    robot: Robot,
    parameters: Sequence[Parameter],
    data: Observations,
    *,
    stages: Sequence[str] = tuple(STAGES),
    joint_noise: bool = True,
    zeros: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Selection:
    """Calibrate the geometry, then try one extension after the other.

    Args:
        robot: The robot.
        parameters: What of its geometry is free.
        data: Training placements.
        stages: Which of :data:`STAGES` may be tried.
        joint_noise: Whether joint angles may be noisy.
        zeros: Whether the joints' zeros may be off by degrees and their gears have play, as in arms
            made of servos.
        progress: Called with a word for each model that is fitted.

    Raises:
        NotConverged: The fit of the geometry did not settle.
    """
    chosen = select_all(
        [(robot, parameters)],
        as_scene(data),
        stages=stages,
        joint_noise=joint_noise,
        zeros=zeros,
        progress=progress,
    )
    full = chosen.full.arms[0]
    same = chosen.full is chosen.geometric
    return Selection(full if same else chosen.geometric.arms[0], full, chosen.notes[0])


def select_all(
    robots: Sequence[Free],
    data: Scene,
    *,
    stages: Sequence[str] = tuple(STAGES),
    joint_noise: bool = True,
    zeros: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Selected:
    """Choose the models of several robots, each extension robot by robot; see above."""

    def fit(near: World | None, extensions: Extensions, observed: Scene) -> World:
        models = [extend(*free, own) for free, own in zip(robots, extensions, strict=True)]
        return estimate_all(Arms(tuple(models)), observed, joint_noise=joint_noise, near=near)

    progress("geometry")
    geometric = best = fit(None, [(ZERO,) if zeros else ()] * len(robots), data)
    notes: list[list[str]] = [[] for _ in robots]
    left_out = _LeftOut(fit)
    tried = [name for name in STAGES if name in stages and (zeros or name != "play")]
    for stage in tried:
        for i, own in enumerate(notes):
            progress(f"{stage} {data.names[i]}".strip())
            candidate, note = _tried(fit, left_out, best, stage, i)
            own.append(f"{stage}: {note}")
            best = best if candidate is None else candidate
    if zeros:
        for own, arm in zip(notes, best.arms, strict=True):
            own.append(zeros_in_words(arm))
    return Selected(geometric, best, tuple(map(tuple, notes)))


Extensions = Sequence[tuple[str, ...]]
"""For each robot, its extensions."""
Fit = Callable[[World | None, Extensions, Scene], World]
"""Fits models of such extensions to data, starting near a result."""


def _tried(
    fit: Fit,
    left_out: "_LeftOut",
    best: World,
    stage: str,
    robot: int,
) -> tuple[World | None, str]:
    """Return the model with one more stage for one robot, None if it is not kept; and why."""
    extensions = [arm.model.extensions for arm in best.arms]
    extensions[robot] = (*extensions[robot], *STAGES[stage])
    try:
        candidate = fit(best, extensions, best.scene)
    except NotConverged:
        return None, "not supported by the data (with it, the fit does not settle)"
    gain = candidate.log_evidence - best.log_evidence
    if _active(candidate) == _active(best) or gain < GAIN:
        return None, f"not supported by the data (log evidence {gain:+.1f})"
    if len(best.scene.placements) < ENOUGH_PLACEMENTS:
        return candidate, f"kept (log evidence {gain:+.1f})"
    try:
        helps, spread = _paired(left_out.errors(best), left_out.errors(candidate))
    except NotConverged:
        return None, "dropped, the fit does not settle without each placement"
    line = f"by {1e3 * helps:+.4f} +- {1e3 * spread:.4f} mm where one placement is left out"
    if helps <= spread:
        return None, f"dropped, it lowers errors only {line}"
    return candidate, f"kept (log evidence {gain:+.1f}), it lowers errors {line}"


def _active(found: World) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(group.name for group in arm.groups if group.width) for arm in found.arms)


class _LeftOut:
    """The errors in each placement, of models fitted to all others."""

    def __init__(self, fit: Fit) -> None:
        self._fit = fit
        self._known: dict[tuple[tuple[str, ...], ...], np.ndarray] = {}

    def errors(self, whole: World) -> np.ndarray:
        """Return the mean error in each placement, shape (P,) [m].

        NaN where nothing ties a robot to the others without that placement.

        Args:
            whole: The model, fitted to all of them.
        """
        key = tuple(arm.model.extensions for arm in whole.arms)
        if key not in self._known:
            names = whole.scene.placements
            errors = np.full(len(names), np.nan)
            for part in range(min(PARTS, len(names))):
                errors[part::PARTS] = self._errors_in(whole, key, names[part::PARTS])
            self._known[key] = errors
        return self._known[key]

    def _errors_in(
        self, whole: World, extensions: Extensions, placements: Sequence[str]
    ) -> list[float]:
        try:
            found = self._fit(whole, extensions, whole.scene.without(placements))
        except FrameError:
            return [float("nan")] * len(placements)
        return [held_out_error(found, whole.scene, placement) for placement in placements]


def held_out_error(found: World, data: Scene, placement: str) -> float:
    """Return the mean absolute error of a model in one placement [m].

    Each robot's balls are compared with their mean in a socket, and those that an instrument
    measured with the best place of its frame.
    """
    distances: list[np.ndarray] = []
    for arm, own in zip(found.arms, data.arms, strict=True):
        for socket, (name, _) in enumerate(own.labels):
            rows = own.sockets == socket
            if name == placement and rows.any():
                points = arm.predict(own.positions[rows], own.torques[rows])
                distances.append(np.linalg.norm(points - points.mean(axis=0), axis=1))
        if own.instrument is not None and placement in own.instrument.placements:
            rows = np.array([name == placement for name in own.instrument.placements])
            points = arm.predict(own.positions[rows], own.torques[rows])
            measured = own.instrument.points[rows]
            placed = fit_pose(measured, points).apply(measured)
            distances.append(np.linalg.norm(points - placed, axis=1))
    return float(np.concatenate(distances).mean())


def _paired(without: np.ndarray, with_it: np.ndarray) -> tuple[float, float]:
    """Return by how much the errors fall on average, and the standard error of that fall [m]."""
    fall = without - with_it
    fall = fall[np.isfinite(fall)]
    return float(fall.mean()), float(fall.std(ddof=1) / np.sqrt(len(fall)))

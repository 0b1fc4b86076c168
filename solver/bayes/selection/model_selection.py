"""Decides by the data which extensions of the geometry to keep, and how much each counts.

The geometry is fitted first. Then compliance is added, then tilt, then play (with zeros,
that is for servo arms), then transmission error, each to the best model so far by its evidence (see
docs/model.md). If the best makes the evidence less than 150 times that of the geometry, the
geometry alone is kept. Otherwise the result is the mean of all these models, each as probable as
its evidence says. What other arms of a type tell is tried beside: each of these models once more,
with all of that. With three placements or more the best must also prove itself: each placement is
left out of the fit once, of very many some at a time, and the errors there must be smaller than the
geometry's by more than the standard error of that.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import log

import numpy as np

from ...data import FrameError, MultiRobotObservations, Observations, fit_pose
from ...paper import NotConverged
from ...robot import Parameter, Robot
from ..inference import JointPosterior, Posterior, estimate_all
from ..model import Expected, MultiRobotModel, as_scene, extend
from ..model.effects import EFFECTS, EXTENSIONS, JOINT_OFFSET
from ..results import joint_offsets_in_words
from .model_averaging import averaged, probabilities

LOG_BAYES_FACTOR = log(150)
"""By how much extensions must raise the logarithm of the evidence together: what is called very
strong (Kass and Raftery 1995). Of 216 simulated arms without any, one raised it by as much; six by
log(20), for which errors of 48 that bend would be 2 % smaller after 10 + 10 samples."""
LIKELY = 0.01
"""Models less probable than this are left out of the mean."""
ENOUGH_PLACEMENTS = 3
PARTS = 5
"""Placements are divided into at most this many parts, and each part is left out of a fit once. One
fit for each placement would take too long where there are many."""


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

    geometric: JointPosterior
    full: JointPosterior
    notes: tuple[tuple[str, ...], ...]
    """For each robot, one line for each extension."""


Free = tuple[Robot, Sequence[Parameter]]
"""A robot, and what of its geometry is free."""


def select_model(
    robot: Robot,
    parameters: Sequence[Parameter],
    data: Observations,
    *,
    stages: Sequence[str] = tuple(EXTENSIONS),
    joint_noise: bool = True,
    zeros: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> Selection:
    """Calibrate the geometry, then try one extension after the other.

    Args:
        robot: The robot.
        parameters: What of its geometry is free.
        data: Training placements.
        stages: Which of :data:`EXTENSIONS` may be tried.
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
    data: MultiRobotObservations,
    *,
    stages: Sequence[str] = tuple(EXTENSIONS),
    joint_noise: bool = True,
    zeros: bool = False,
    types: Sequence[Mapping[str, Expected]] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> Selected:
    """Choose the models of several robots, each extension robot by robot; see above.

    ``types`` are for each robot what is known of the elasticity of other arms of its type, see
    :attr:`.ExtendedModel.of_type`. What was tried is then tried with that, too.
    """

    def fit(
        near: JointPosterior | None, effects: EffectNames, observed: MultiRobotObservations
    ) -> JointPosterior:
        models = [extend(*free, own) for free, own in zip(robots, effects, strict=True)]
        if near is not None:
            known = [arm.model.of_type for arm in near.arms]
            models = [replace(m, of_type=own) for m, own in zip(models, known, strict=True)]
        return estimate_all(
            MultiRobotModel(tuple(models)), observed, joint_noise=joint_noise, near=near
        )

    progress("geometry")
    first = (JOINT_OFFSET.name,) if zeros else ()
    geometric = fit(None, [first] * len(robots), data)
    required = {name: {EFFECTS[e].requires for e in own} for name, own in EXTENSIONS.items()}
    names = [name for name in EXTENSIONS if name in stages and required[name] <= {"", *first}]
    order = [(name, i) for name in names for i in range(len(robots))]
    tryable = {extension for name in names for extension in EXTENSIONS[name]}
    types = [{k: v for k, v in of_type.items() if k in tryable} for of_type in types]
    tried = _search(fit, geometric, order, progress)
    models, words = _judged(fit, [*tried.models, *_by_type(fit, tried.fits, types, progress)])
    shares = probabilities(models)
    notes: list[list[str]] = [[] for _ in robots]
    for (stage, i), gain in tried.gains.items():
        notes[i].append(f"{stage}: {_note(gain, _share(models, shares, stage, i), words)}")
    for i, own in enumerate(notes):
        if any(types) and types[i]:
            by_type = [bool(model.arms[i].model.of_type) for model in models]
            own.append(f"type prior: counts by {100 * float(shares[by_type].sum()):.0f} %")
    full = averaged(models, shares) if len(models) > 1 else models[0]
    if zeros:
        for own, arm in zip(notes, full.arms, strict=True):
            own.append(joint_offsets_in_words(arm))
    return Selected(geometric, full, tuple(map(tuple, notes)))


EffectNames = Sequence[tuple[str, ...]]
"""For each robot, the names of its effects."""
Fit = Callable[[JointPosterior | None, EffectNames, MultiRobotObservations], JointPosterior]
"""Fits models of such effects to data, starting near a result."""


@dataclass(frozen=True)
class _Tried:
    """What was tried, and how it went."""

    models: list[JointPosterior]
    """The models, that of the geometry alone first."""
    gains: dict[tuple[str, int], float | None]
    """By how much each stage of each robot raised the logarithm of the evidence; None where the
    fit does not settle with it."""
    fits: list[JointPosterior]
    """All fits with extensions, also those that came out like another."""


def _search(
    fit: Fit,
    geometric: JointPosterior,
    stages: list[tuple[str, int]],
    progress: Callable[[str], None],
) -> _Tried:
    """Add stage after stage to the best model so far.

    All are tried twice: what did not help at first may do so beside what was kept since.
    """
    best, gains = geometric, dict[tuple[str, int], float | None]()
    models, tried, fits = {_active(best): best}, {_kept(best)}, list[JointPosterior]()
    for stage, robot in 2 * stages:
        own = list(_kept(best))
        own[robot] = own[robot] | {*EXTENSIONS[stage]}
        if tuple(own) in tried:
            continue
        tried.add(tuple(own))
        progress(f"{stage} {best.scene.names[robot]}".strip())
        try:
            candidate = fit(best, [tuple(one) for one in own], best.scene)
        except NotConverged:
            gains.setdefault((stage, robot))
            continue
        fits.append(candidate)
        gain = gains[stage, robot] = candidate.log_evidence - best.log_evidence
        if _active(candidate) not in models:
            models[_active(candidate)] = candidate
            best = candidate if gain > 0 else best
    return _Tried(list(models.values()), gains, fits)


def _by_type(
    fit: Fit,
    fits: Sequence[JointPosterior],
    types: Sequence[Mapping[str, Expected]],
    progress: Callable[[str], None],
) -> list[JointPosterior]:
    """Return the fits again, with all that other arms of a type tell of, as they tell it."""
    models: dict[tuple[frozenset[str], ...], JointPosterior] = {}
    for world in fits if any(types) else ():
        arms = [
            replace(arm, model=replace(arm.model, of_type=of_type))
            for arm, of_type in zip(world.arms, types, strict=True)
        ]
        whole = tuple(frozenset({*a.model.extensions, *a.model.of_type}) for a in arms)
        if whole not in models:
            progress("type prior")
            near = replace(world, arms=tuple(arms))
            with suppress(NotConverged):
                models[whole] = fit(near, [tuple(own) for own in whole], world.scene)
    return list({_active(model): model for model in models.values()}.values())


def _kept(world: JointPosterior) -> tuple[frozenset[str], ...]:
    return tuple(frozenset(arm.model.extensions) for arm in world.arms)


def _judged(fit: Fit, models: list[JointPosterior]) -> tuple[list[JointPosterior], str]:
    """Return the models that count: the geometry alone, or the probable ones; and words on why.

    Args:
        fit: Fits a model.
        models: What was tried, the geometry alone first.
    """
    geometric, best = models[0], max(models, key=lambda model: model.log_evidence)
    if best.log_evidence - geometric.log_evidence < LOG_BAYES_FACTOR:
        return [geometric], ""
    words = ""
    if len(best.scene.placements) >= ENOUGH_PLACEMENTS:
        try:
            helps, spread = _paired(_left_out(fit, geometric), _left_out(fit, best))
        except NotConverged:
            return [geometric], "; the fit does not settle without each placement"
        words = (
            f"; where one placement is left out, all together lower errors by {1e3 * helps:.4f} "
            f"+- {1e3 * spread:.4f} mm"
        )
        if helps <= spread:
            return [geometric], words
    shares = probabilities(models)
    return [model for model, share in zip(models, shares, strict=True) if share > LIKELY], words


def _share(models: Sequence[JointPosterior], shares: np.ndarray, stage: str, robot: int) -> float:
    """Return how probable it is that a stage is there."""
    there = [bool({*EXTENSIONS[stage]} & {*_active(model)[robot]}) for model in models]
    return float(shares[there].sum())


def _note(gain: float | None, share: float, words: str) -> str:
    if gain is None:
        return "not supported by the data (with it, the fit does not settle)"
    evidence = f"(log evidence {gain:+.1f})"
    if not share:
        return f"not supported by the data {evidence}{words}"
    much = "kept" if share > 1 - LIKELY else f"kept by {100 * share:.0f} %"
    return f"{much} {evidence}{words}"


def _active(world: JointPosterior) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(group.name for group in arm.groups if group.width) for arm in world.arms)


def _left_out(fit: Fit, whole: JointPosterior) -> np.ndarray:
    """Return the mean error in each placement of a model fitted to all others, shape (P,) [m].

    NaN where nothing ties a robot to the others without that placement.

    Args:
        fit: Fits a model.
        whole: The model, fitted to all placements.
    """
    extensions = [arm.model.extensions for arm in whole.arms]
    names = whole.scene.placements
    errors = np.full(len(names), np.nan)
    for part in range(min(PARTS, len(names))):
        try:
            world = fit(whole, extensions, whole.scene.without(names[part::PARTS]))
        except FrameError:
            continue
        errors[part::PARTS] = [held_out_error(world, whole.scene, p) for p in names[part::PARTS]]
    return errors


def held_out_error(world: JointPosterior, data: MultiRobotObservations, placement: str) -> float:
    """Return the mean absolute error of a model in one placement [m].

    Each robot's balls are compared with their mean in a socket, and those that an instrument
    measured with the best place of its frame.
    """
    distances: list[np.ndarray] = []
    for arm, own in zip(world.arms, data.arms, strict=True):
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

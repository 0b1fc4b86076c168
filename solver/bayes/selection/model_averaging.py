"""Several models of one arm: their held-out errors, their probabilities, and their mean."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from math import log

import numpy as np

from ...data import FrameError, fit_pose
from ...robot import rotation_vectors
from ..inference import FitPosterior, Objective, linearise, stepped
from ..model import Gaussian, PriorGroup, probabilities
from ..model.effects import EFFECTS

ALSO_TILTS = 4.0
"""Odds that an arm whose joints twist under load also tilts, before the data: all three types of
arms that were measured in three axes did (Panda, FR3, iiwa 14), and Laplace's rule of succession
then expects it of the next in four cases of five."""
HARMONICS_BESIDE_CURVES = log(150)
"""Least rise of the logarithm of the evidence by which harmonics stay beside curves, which are such
themselves: what is called very strong (Kass and Raftery 1995)."""
PARTS = 5
"""Placements are divided into at most this many parts, and each part is left out of a fit once. One
fit for each placement would take too long where there are many."""


def log_odds(model: FitPosterior) -> float:
    """Return the logarithm of a model's odds before the data, by ALSO_TILTS."""
    elastic = {effect.name for effect in EFFECTS.values() if effect.elastic}
    return log(ALSO_TILTS) if elastic <= {*model.active} else 0.0


def model_probabilities(models: Sequence[FitPosterior]) -> np.ndarray:
    """Return the probability of each model by its evidence and odds, shape (len(models),)."""
    evidence = np.array([model.log_evidence + log_odds(model) for model in models])
    return probabilities(evidence)


def beside_curves(
    posterior: FitPosterior, models: Sequence[FitPosterior]
) -> tuple[FitPosterior, float] | None:
    """Return the model that may be more probable beside curves, and the logarithm of its odds."""
    # Errors that nothing explains yet hide elasticity, and harmonics stand for curves.
    elastic = {effect.name for effect in EFFECTS.values() if effect.elastic}
    harmonics = {effect.name for effect in EFFECTS.values() if effect.stands_for_curves}

    def bends_alone(model: FitPosterior) -> bool:
        effects = {*model.active}
        return bool(effects & elastic) and not effects & harmonics

    bent = [model for model in models if bends_alone(model)]
    if not bent or bends_alone(posterior):
        return None
    best = bent[int(np.argmax(model_probabilities(bent)))]
    odds = log_odds(best) - log_odds(posterior)
    has_harmonics = harmonics & {*posterior.active}
    return best, odds + HARMONICS_BESIDE_CURVES if has_harmonics else odds


def averaged(results: Sequence[FitPosterior], shares: np.ndarray) -> FitPosterior:
    """Return the mean of results of models with different extensions, weighted by their shares."""
    best = results[int(np.argmax(shares))]
    extensions = {*chain(*(result.model.extensions for result in results))}
    objective = replace(best.objective, model=best.model.with_effects(extensions))
    groups: dict[str, PriorGroup] = {}
    parts: list[Gaussian] = []
    weights = np.zeros(len(best.weights))
    order: list[int] = np.argsort(shares).tolist()
    for k in order:
        result = results[k]
        rows = _rows(objective, result.objective)
        place = np.concatenate([result.state.x, _places(result, best)])
        parts.append(replace(result.around, mean=place).embedded(rows, objective.size))
        weights += shares[k] * result.weights
        for group in result.state.groups:
            groups[group.name] = replace(group, members=rows[group.members])
    mixture = Gaussian.averaged(parts, shares[order].tolist())
    ordered = tuple(sorted(groups.values(), key=lambda group: int(group.members[0])))
    at_zero = np.zeros(objective.x_size, dtype=bool)
    for group in ordered:
        at_zero[group.members] = not group.width
    origin = replace(
        best.state,
        objective=objective,
        x=np.zeros(len(at_zero)),
        centres=np.zeros_like(best.state.centres),
        groups=ordered,
        at_zero=at_zero,
    )
    state = origin.changed(mixture.mean)
    state = replace(state, linear=linearise(objective, state.x, state.frames))
    before = np.zeros((len(best.iterates), objective.size))
    before[:, _rows(objective, best.objective)[: len(best.state.x)]] = best.iterates
    iterates = [*before[:, : objective.x_size], state.x]
    centred = replace(mixture, mean=np.zeros(objective.size))
    return FitPosterior(state, centred, weights, best.log_evidence, iterates)


def _rows(objective: Objective, part: Objective) -> np.ndarray:
    """Return the places of all unknowns among those of models with more extensions."""
    place = {name: i for i, name in enumerate(objective.model.names)}
    rows = [place[name] for name in part.model.names]
    return np.array(
        [*rows, *range(objective.model.size, objective.size)], dtype=np.int64
    )


def _places(result: FitPosterior, reference: FitPosterior) -> np.ndarray:
    """Return the frames, as changes from another result, and then the sockets."""
    changes: list[np.ndarray] = []
    for pose, frame in zip(result.state.frames, reference.state.frames, strict=True):
        (turn,) = rotation_vectors((pose.rotation @ frame.rotation.T)[None])
        changes += [turn, pose.translation - frame.translation]
    return np.concatenate([*changes, result.state.centres.ravel()])


def mean_fall(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Return the mean fall of held-out errors from model to model, and its standard error [m]."""
    fall = before - after
    fall = fall[np.isfinite(fall)]
    return float(fall.mean()), float(fall.std(ddof=1) / np.sqrt(len(fall)))


def held_out_errors(posterior: FitPosterior) -> np.ndarray:
    """Return each placement's error by a fit to others [m]; NaN where a frame is not tied then."""
    names = posterior.data.placements
    errors = np.full(len(names), np.nan)
    for part in range(min(PARTS, len(names))):
        held_out = names[part::PARTS]
        try:
            state = stepped(posterior, posterior.data.without(held_out))
        except FrameError:
            continue
        errors[part::PARTS] = [
            _mean_error(posterior, state.x, name) for name in held_out
        ]
    return errors


def _mean_error(posterior: FitPosterior, x: np.ndarray, placement: str) -> float:
    """Return the mean distance of balls from their socket's mean or measured place [m]."""
    distances: list[np.ndarray] = []
    model = posterior.model
    data = posterior.data
    rows = data.rows_of(placement)
    samples = data.positions[rows], data.torques[rows], data.clocks[rows]
    points = model.predict(x[: model.size], *samples)
    sockets = data.sockets[rows]
    for socket in np.unique(sockets[sockets >= 0]):
        balls = points[sockets == socket]
        distances.append(np.linalg.norm(balls - balls.mean(axis=0), axis=1))
    if (sockets < 0).any():
        balls = points[sockets < 0]
        measured = data.points[rows][sockets < 0]
        fitted_places = fit_pose(measured, balls).apply(measured)
        distances.append(np.linalg.norm(balls - fitted_places, axis=1))
    return float(np.concatenate(distances).mean())

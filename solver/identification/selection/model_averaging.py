"""Several models of one arm: their probabilities, and their mean."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from math import log

import numpy as np

from ..effects import EFFECTS
from ..inference import FitPosterior, Objective, State
from ..model import Gaussian, PriorGroup, probabilities
from ..robot import rotation_vectors

ALSO_TILTS = 4.0
"""Odds that an arm whose joints twist under load also tilts, before the data: all three types of
arms that were measured in three axes did (Panda, FR3, iiwa 14), and Laplace's rule of succession
then expects it of the next in four cases of five."""
HARMONICS_BESIDE_CURVES = log(150)
"""Least rise of the logarithm of the evidence by which harmonics stay beside curves, which are such
themselves: what is called very strong (Kass and Raftery 1995)."""


def log_odds(model: FitPosterior) -> float:
    """Return the logarithm of a model's odds before the data, by ALSO_TILTS."""
    if _elastic() <= {*model.active}:
        return log(ALSO_TILTS)
    return 0.0


def _elastic() -> set[str]:
    """Return the effects by which joints give way under load."""
    return {effect.name for effect in EFFECTS.values() if effect.elastic}


def model_probabilities(models: Sequence[FitPosterior]) -> np.ndarray:
    """Return the probability of each model by its evidence and odds, shape (len(models),)."""
    logs = [model.log_evidence + log_odds(model) for model in models]
    return probabilities(np.array(logs))


def beside_curves(
    posterior: FitPosterior,
    models: Sequence[FitPosterior],
) -> tuple[FitPosterior, float] | None:
    """Return the model that may be more probable beside curves, and the logarithm of its odds.

    Errors that nothing explains yet hide elasticity, and harmonics stand for curves.
    """
    elastic = [model for model in models if _bends_alone(model)]
    if not elastic or _bends_alone(posterior):
        return None
    most_probable = np.argmax(model_probabilities(elastic))
    best = elastic[int(most_probable)]
    odds = log_odds(best) - log_odds(posterior)
    if _harmonics(posterior):
        odds += HARMONICS_BESIDE_CURVES
    return best, odds


def _bends_alone(model: FitPosterior) -> bool:
    """Return True for a model with elasticity and without harmonics."""
    rigid = _elastic().isdisjoint(model.active)
    return not rigid and not _harmonics(model)


def _harmonics(model: FitPosterior) -> set[str]:
    """Return the effects of a model that stand for curves."""
    harmonics = {effect.name for effect in EFFECTS.values() if effect.stands_for_curves}
    return harmonics.intersection(model.active)


def averaged(results: Sequence[FitPosterior], shares: np.ndarray) -> FitPosterior:
    """Return the mean of results of models with different extensions, weighted by their shares."""
    best = results[int(np.argmax(shares))]
    extensions = [result.model.extensions for result in results]
    model = best.model.with_effects({*chain(*extensions)})
    objective = replace(best.objective, model=model)
    groups: dict[str, PriorGroup] = {}
    parts: list[Gaussian] = []
    weights = np.zeros(len(best.weights))
    order: list[int] = np.argsort(shares).tolist()
    for k in order:
        result = results[k]
        rows = _rows(objective, result.objective)
        state = result.state
        unknowns = np.concatenate([state.x, _places(state, best.state)])
        part = replace(result.around, mean=unknowns)
        parts.append(part.embedded(rows, objective.size))
        weights += shares[k] * result.weights
        for group in state.groups:
            members = rows[group.members]
            groups[group.name] = replace(group, members=members)
    rows_of_best = _rows(objective, best.objective)
    rows_of_x = rows_of_best[: len(best.state.x)]
    iterates = np.zeros((len(best.iterates), objective.x_size))
    iterates[:, rows_of_x] = best.iterates
    mixture = Gaussian.averaged(parts, shares[order].tolist())
    at_origin = FitPosterior(
        state=_origin(best.state, objective, [*groups.values()]),
        around=mixture,
        weights=weights,
        log_evidence=best.log_evidence,
        iterates=[*iterates],
    )
    return at_origin.changed(mixture)


def _origin(state: State, objective: Objective, groups: Sequence[PriorGroup]) -> State:
    """Return the state with an objective and priors, all unknowns but frames zero."""
    ordered = sorted(groups, key=lambda group: int(group.members[0]))
    at_zero = np.zeros(objective.x_size, dtype=bool)
    for group in ordered:
        at_zero[group.members] = not group.width
    return replace(
        state,
        objective=objective,
        x=np.zeros(len(at_zero)),
        centres=np.zeros_like(state.centres),
        groups=tuple(ordered),
        at_zero=at_zero,
    )


def _rows(objective: Objective, part: Objective) -> np.ndarray:
    """Return the places of all unknowns among those of models with more extensions."""
    place = {name: i for i, name in enumerate(objective.model.names)}
    rows = [place[name] for name in part.model.names]
    behind_model = range(objective.model.size, objective.size)
    return np.array([*rows, *behind_model], dtype=np.int64)


def _places(state: State, reference: State) -> np.ndarray:
    """Return the frames, as changes from another state's, and then the sockets."""
    changes: list[np.ndarray] = []
    for pose, frame in zip(state.frames, reference.frames, strict=True):
        R = pose.rotation @ frame.rotation.T
        changes.append(rotation_vectors(R[None])[0])
        changes.append(pose.translation - frame.translation)
    return np.concatenate([*changes, state.centres.ravel()])

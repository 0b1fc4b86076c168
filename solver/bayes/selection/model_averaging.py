"""Several models of one arm: their held-out errors, their probabilities, and their mean."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import log

import numpy as np

from ...data import FrameError, MultiRobotObservations, fit_pose
from ..inference import JointPosterior, Posterior
from ..model import ExtendedModel, MultiRobotModel, PriorGroup, extend
from ..model.effects import COMPLIANCE, HARMONICS, TILT

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

Refit = Callable[[JointPosterior, MultiRobotObservations], JointPosterior]
"""Fits a model again, to other data of the same robots."""


def log_odds(model: JointPosterior) -> float:
    """Return the logarithm of a model's odds before the data, by ALSO_TILTS."""
    pair = {COMPLIANCE.name, TILT.name}
    both = sum(pair <= {g.name for g in arm.groups if g.width} for arm in model.arms)
    return both * log(ALSO_TILTS)


def model_probabilities(models: Sequence[JointPosterior]) -> np.ndarray:
    """Return the probability of each model by its evidence and odds, shape (len(models),)."""
    evidence = np.array([model.log_evidence + log_odds(model) for model in models])
    odds = np.exp(evidence - evidence.max())
    return odds / odds.sum()


def beside_curves(
    found: JointPosterior, models: Sequence[JointPosterior]
) -> tuple[JointPosterior, float] | None:
    """Return the model that may be more probable beside curves, and the logarithm of its odds.

    Errors that nothing explains yet hide elasticity, and harmonics stand for curves.
    """
    elastic, harmonics = {COMPLIANCE.name, TILT.name}, {one.name for one in HARMONICS}
    own, *others = (
        {group.name for arm in one.arms for group in arm.groups if group.width}
        for one in (found, *models)
    )
    pairs = zip(models, others, strict=True)
    bent = [model for model, names in pairs if names & elastic and not names & harmonics]
    if not bent or (own & elastic and not own & harmonics):
        return None
    best = bent[int(np.argmax(model_probabilities(bent)))]
    odds = log_odds(best) - log_odds(found)
    return best, odds + HARMONICS_BESIDE_CURVES if own & harmonics else odds


def averaged(results: Sequence[JointPosterior], probabilities: np.ndarray) -> JointPosterior:
    """Return the mean of results of models with different extensions, weighted by probabilities."""
    best = results[int(np.argmax(probabilities))]
    robots = [[result.arms[i] for result in results] for i in range(len(best.arms))]
    models = MultiRobotModel(tuple(map(_union, robots)))
    size = models.size + len(best.covariance) - best.own[-1].stop
    means, covariance = np.zeros((len(results), size)), np.zeros((size, size))
    for mean, weight, result in zip(means, probabilities, results, strict=True):
        arms = zip(models.own, models.models, result.arms, strict=True)
        rows = [i for own, model, arm in arms for i in _rows(model, arm.model, own.start)]
        rows += range(models.size, size)
        mean[rows] = np.concatenate([*(arm.x for arm in result.arms), _places(result, best)])
        covariance[np.ix_(rows, rows)] += weight * result.covariance
    mean = probabilities @ means
    covariance += ((means - mean).T * probabilities) @ (means - mean)
    count = best.arms[0].centres.size
    turns = mean[models.size : size - count].reshape(-1, 6)
    frames = zip(best.frames.items(), turns, strict=True)
    arms = tuple(
        _of_arm(model, arms, probabilities, mean[own], covariance[picked][:, picked])
        for model, arms, own, picked in zip(
            models.models,
            robots,
            models.own,
            [np.r_[own, size - count : size] for own in models.own],
            strict=True,
        )
    )
    return JointPosterior(
        arms,
        models.own,
        best.scene,
        {name: pose.moved(change) for (name, pose), change in frames},
        covariance,
        best.log_evidence,
        best.movements,
    )


def _union(arms: Sequence[Posterior]) -> ExtendedModel:
    """Return the model with the extensions of all."""
    model = arms[0].model
    kept = {name for arm in arms for name in arm.model.extensions}
    return replace(extend(model.robot, model.parameters, tuple(kept)), given=model.given)


def _rows(whole: ExtendedModel, part: ExtendedModel, begin: int = 0) -> list[int]:
    """Return the places of a model's unknowns among those of one with more extensions."""
    place = {name: i for i, name in enumerate(whole.names, begin)}
    return [place[name] for name in part.names]


def _places(result: JointPosterior, near: JointPosterior) -> np.ndarray:
    """Return the frames, as changes from another result, and then the sockets."""
    changes: list[np.ndarray] = []
    for name, pose in result.frames.items():
        there = near.frames[name]
        R = pose.rotation @ there.rotation.T  # hardly any turn, so its sine is its angle
        turn = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
        changes += [turn, pose.translation - there.translation]
    return np.concatenate([*changes, result.arms[0].centres.ravel()])


def _of_arm(
    model: ExtendedModel,
    arms: Sequence[Posterior],
    probabilities: np.ndarray,
    x: np.ndarray,
    covariance: np.ndarray,
) -> Posterior:
    """Return the mean of one of the robots."""
    best = arms[int(np.argmax(probabilities))]
    groups: dict[str, PriorGroup] = {}
    for _, arm in sorted(zip(probabilities.tolist(), arms, strict=True), key=lambda one: one[0]):
        rows = np.array(_rows(model, arm.model))
        for group in arm.groups:
            groups[group.name] = replace(group, members=rows[group.members])
    padded = np.zeros((len(best.iterates) + 1, model.size))
    padded[:-1, _rows(model, best.model)] = best.iterates
    padded[-1] = x
    return replace(
        best,
        model=model,
        x=x,
        centres=np.tensordot(probabilities, [arm.centres for arm in arms], 1),
        covariance=covariance,
        groups=tuple(sorted(groups.values(), key=lambda group: group.members[0])),
        points=model.predict(x, best.data.positions, best.data.torques),
        weights=probabilities @ [arm.weights for arm in arms],
        iterates=tuple(padded),
    )


def mean_fall(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Return the mean fall of held-out errors from model to model, and its standard error [m]."""
    fall = before - after
    fall = fall[np.isfinite(fall)]
    return float(fall.mean()), float(fall.std(ddof=1) / np.sqrt(len(fall)))


def held_out_errors(refit: Refit, whole: JointPosterior) -> np.ndarray:
    """Return each placement's error by a fit to others [m]; NaN where a robot is not tied then."""
    names = whole.scene.placements
    errors = np.full(len(names), np.nan)
    for part in range(min(PARTS, len(names))):
        try:
            found = refit(whole, whole.scene.without(names[part::PARTS]))
        except FrameError:
            continue
        errors[part::PARTS] = [_mean_error(found, whole.scene, p) for p in names[part::PARTS]]
    return errors


def _mean_error(found: JointPosterior, data: MultiRobotObservations, placement: str) -> float:
    """Return the mean distance of balls from their socket's mean or measured place [m]."""
    distances: list[np.ndarray] = []
    for arm, own in zip(found.arms, data.arms, strict=True):
        for socket, (name, _) in enumerate(own.labels):
            rows = own.sockets == socket
            if name == placement and rows.any():
                points = arm.predict(own.positions[rows], own.torques[rows])
                distances.append(np.linalg.norm(points - points.mean(axis=0), axis=1))
        rows = own.rows_of(placement) & (own.sockets < 0)
        if rows.any():
            points = arm.predict(own.positions[rows], own.torques[rows])
            measured = own.points[rows]
            placed = fit_pose(measured, points).apply(measured)
            distances.append(np.linalg.norm(points - placed, axis=1))
    return float(np.concatenate(distances).mean())

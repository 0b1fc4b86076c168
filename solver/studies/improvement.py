"""Improvement by a calibration: errors of distances by the nominal model, and by what is loaded.

The arm itself is unknown, so it is drawn from what is known of it: from the posterior of the
samples trained on, updated by those that were held out or left out. For each draw the errors of
both models follow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..identification.data import Load, Measurement
from ..identification.inference import Posterior
from ..identification.robot import workspace
from ..results import (
    Better,
    CalibratedRobot,
    Fit,
    Improvement,
    Interval,
    Measurements,
    Place,
    Study,
    Unseen,
    with_ball_at,
)
from .held_out_evidence import updated
from .predicted_errors import neighbourhoods
from .projections import (
    pair_lengths,
)
from .uncertainty import distance_slopes

Points = Callable[[np.ndarray], np.ndarray]
"""Ball centres that a model predicts for joint positions, (N, m) to (N, 3) [m]."""
DRAWS, PAIRS = 400, 400
"""Draws of the arm, and random distances in the workspace."""


@dataclass(frozen=True)
class Models:
    """The models that are compared."""

    nominal: Sequence[Points]
    """With its ball at each place that may be right; the one that errs least counts."""
    loaded: Points
    """``calibrated.urdf``."""
    corrected: bool
    """True if the full model, which corrects joint positions, is another one."""


def better_than_nominal(
    posterior: Posterior,
    load: Load,
    models: Models,
    recorded: Sequence[Measurement],
    unseen: Sequence[Unseen] = (),
) -> Better:
    """Return the errors of distances before and now, and the probability that they are smaller.

    Args:
        posterior: What the samples trained on tell of the arm.
        load: Load of the joints while recording.
        models: The models to compare.
        recorded: The placements.
        unseen: Placements whose samples and distances bear on the arm, too, by fits that have not
            seen them.
    """
    robot = posterior.model.robot
    change = updated(posterior, load, unseen)
    generator = np.random.default_rng(0)
    white = generator.standard_normal((DRAWS, change.root.shape[1]))
    draws = change.mean + white @ change.root.T

    def improvement(q: np.ndarray) -> Improvement:
        poses = load.at(robot, q)
        lengths, slopes = distance_slopes(posterior.model, posterior.x, poses)
        truths = lengths + draws @ slopes.T
        return _improvement(models, q, lengths, truths)

    places = map(improvement, neighbourhoods(robot, recorded))
    return Better(
        workspace=improvement(workspace(robot, 2 * PAIRS)),
        recorded_places=max(places, key=lambda place: place.now.value, default=None),
    )


def _improvement(
    models: Models,
    q: np.ndarray,
    lengths: np.ndarray,
    truths: np.ndarray,
) -> Improvement:
    """Return the errors of distances between pairs of poses, by draws of them (K, N) [m].

    Each draw is of the arm and, with replacement, of the pairs, which are a sample as well.
    """
    generator = np.random.default_rng(1)
    _, count = truths.shape
    pairs = generator.integers(count, size=truths.shape)
    truths_of_pairs = np.take_along_axis(truths, pairs, axis=1)

    def errors(distances: np.ndarray) -> np.ndarray:
        differences = distances[pairs] - truths_of_pairs
        return np.median(np.abs(differences), axis=1)

    by_nominal = [errors(pair_lengths(points(q))) for points in models.nominal]
    loaded = pair_lengths(models.loaded(q))
    before = np.min(by_nominal, axis=0)
    now = errors(loaded)
    corrected: dict[str, Any] = {}
    if models.corrected:
        by_full = errors(lengths)
        corrected["corrected"] = _interval(by_full)
        corrected["corrected_probability"] = _share(by_full < before)
    return Improvement(
        before=_interval(before),
        now=_interval(now),
        probability=_share(now < before),
        **corrected,
    )


def _share(is_better: np.ndarray) -> float:
    """Return a probability by draws, which is never 0 or 1."""
    return (float(np.sum(is_better)) + 0.5) / (len(is_better) + 1)


def _interval(errors: np.ndarray) -> Interval:
    low, middle, high = np.quantile(errors, (0.16, 0.5, 0.84)).tolist()
    return Interval(value=middle, low=low, high=high)


def better(
    fit: Fit,
    measurements: Measurements,
    ball: Place | None,
) -> Better | None:
    """Return the errors of distances before and now.

    Before is the nominal robot with its ball refitted at ``ball``, or with the calibrated one:
    whichever errs less. A model that is wrong elsewhere puts the ball wrong by millimetres.
    """
    assert fit.posterior is not None
    calibrated: CalibratedRobot = fit.calibrated
    nominal = [with_ball_at(calibrated.robot, ball), calibrated.with_ball_alone]
    models = Models(
        [robot.ball for robot in nominal if robot is not None],
        calibrated.geometric_ball,
        corrected=calibrated.exported is not None,
    )
    recorded = [m for _, m in measurements.placements]
    return better_than_nominal(
        fit.posterior, calibrated.load, models, recorded, measurements.unseen(fit)
    )


BETTER = Study("better", better, ("refitted_ball",))

"""Predictions of models for a placement, its target as it may have been put on anew."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..identification.data import (
    FOLDS,
    Measurement,
    Metrics,
    Pose,
    TipSamples,
    evaluate,
    fit_pose,
    nearest_rotation,
    tip_shift,
)
from .calibrated import CalibratedRobot

ANEW = 0.8
"""Share of the error that is left at most where a target was put on anew before a placement."""
LEAST_ANEW = 12
"""Points that tell where frame and target are, nine numbers."""
CALIBRATED = "calibrated"
"""Model by which that is decided."""


class TargetPrediction(NamedTuple):
    """Balls by a model, and what they are held against."""

    points: np.ndarray
    """Shape (N, 3) [m]."""
    rotations: np.ndarray | None
    """Orientations of their link, shape (N, 3, 3); None where none were measured."""
    frames: Mapping[str, Pose] | None
    """Poses of the instruments' frames; None for those that fit the placement itself."""

    def metrics(self, measured: Measurement) -> Metrics:
        """Return the errors."""
        return evaluate(self.points, measured, self.frames, self.rotations)


def target_predictions(
    models: Mapping[str, CalibratedRobot],
    measured: Measurement,
    frames: Mapping[str, Mapping[str, Pose]],
    *,
    put_on: bool = False,
) -> dict[str, TargetPrediction]:
    """Return what models predict for a placement, each with its own poses of frames.

    ``put_on``: of points, the target may have been put on anew. Without it that is taken for true
    where it explains much of the error.
    """
    enough = measured.kind == "points" and len(measured.points) >= LEAST_ANEW
    if not enough or not (put_on or _is_put_on(models, measured, frames)):
        return {
            name: _as_trained(model, measured, frames[name])
            for name, model in models.items()
        }
    return {name: _put_on_anew(model, measured) for name, model in models.items()}


def _is_put_on(
    models: Mapping[str, CalibratedRobot],
    measured: Measurement,
    frames: Mapping[str, Mapping[str, Pose]],
) -> bool:
    """Tell whether a frame and a target of its own explain much of a placement's error."""
    model = models[CALIBRATED]
    as_trained = _as_trained(model, measured, frames.get(CALIBRATED)).metrics(measured)
    anew = _put_on_anew(model, measured).metrics(measured)
    if anew.mean_absolute_error < ANEW * as_trained.mean_absolute_error:
        return True
    angle = as_trained.orientation_error
    return angle is not None and (anew.orientation_error or 0.0) < ANEW * angle


def _as_trained(
    model: CalibratedRobot, measured: Measurement, frames: Mapping[str, Pose] | None
) -> TargetPrediction:
    """Return a prediction with the target where it was on the placements trained on."""
    rotations = model.rotations(measured) if measured.has_orientations else None
    return TargetPrediction(model.predict(measured), rotations, frames)


def _put_on_anew(model: CalibratedRobot, measured: Measurement) -> TargetPrediction:
    """Return a prediction with frame and target as they fit the placement itself.

    Each tenth of the samples has the frame, and the place and turn on the flange, that fit the
    others best. A flange that hardly turns tells neither alone, so a tenth keeps its own of both,
    and is seen from the frame that fits all samples.
    """
    points, rotations, seen = model.tips(measured)
    tips, turns = points.copy(), rotations.copy()
    frame_of_all = fit_pose(seen, points)
    fold = np.arange(len(points)) % FOLDS
    for number in range(FOLDS):
        part, others = fold == number, fold != number
        trained = TipSamples(points[others], rotations[others], seen[others])
        shift = tip_shift([trained])
        frame = fit_pose(trained.measured, trained.points + trained.rotations @ shift)
        change = frame_of_all @ frame.inverse()
        tips[part] = change.apply(points[part] + rotations[part] @ shift)
        if measured.has_orientations:
            true_turns = frame.rotation @ measured.rotations[others]
            turn = np.einsum("nji,njk->ik", trained.rotations, true_turns)
            turns[part] = change.rotation @ rotations[part] @ nearest_rotation(turn)
    return TargetPrediction(tips, turns, None)

"""The models that count for a result, by their evidence and by what they leave elsewhere."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import compress
from math import log

import numpy as np

from ....errors import NotConverged, fixed
from ..data import FrameError, fit_pose
from ..effects import EFFECTS, EXTENSIONS
from ..inference import FitPosterior, stepped
from .model_averaging import averaged, model_probabilities
from .model_search import best_of

LOG_BAYES_FACTOR = log(150)
"""Least rise of the logarithm of the evidence by all extensions together: what is called very
strong (Kass and Raftery 1995). Of 216 simulated arms without any, one raised it by as much; six by
log(20), for which errors of 48 that bend would be 2 % smaller after 10 + 10 samples."""
LIKELY = 0.01
"""Models less probable than this are left out of the mean."""
ENOUGH_PLACEMENTS = 3
PARTS = 5
"""Placements are divided into at most this many parts, and each part is left out of a fit once. One
fit for each placement would take too long where there are many."""
NO_MASSES = "not known without masses in the URDF, or measured torques"


@dataclass(frozen=True)
class ModelChoice:
    """The models that count."""

    models: Sequence[FitPosterior]
    reason: str = ""
    """Reason for which these count, in words."""

    @cached_property
    def probabilities(self) -> np.ndarray:
        """Probability of each model."""
        return model_probabilities(self.models)

    @property
    def mean(self) -> FitPosterior:
        """The mean of the models."""
        models = [model.over_widths for model in self.models]
        if len(models) == 1:
            return models[0]
        return averaged(models, self.probabilities)

    def share(self, counts: Callable[[FitPosterior], bool]) -> float:
        """Return the probability of all models that count."""
        mask = [counts(model) for model in self.models]
        return float(self.probabilities[mask].sum())

    def notes(self, gains: Mapping[str, float | None]) -> list[str]:
        """Return a line for each extension, by how much the evidence rose by it."""
        return [f"{name}: {self._note(name, gain)}" for name, gain in gains.items()]

    def _note(self, extension: str, gain: float | None) -> str:
        """Return what became of an extension by which the evidence rose, in words."""
        effects = EXTENSIONS[extension]
        of_torques = any(EFFECTS[name].elastic for name in effects)
        if of_torques and not self.models[0].data.moments.any():
            return NO_MASSES
        if gain is None:
            return "not supported by the data (with it, the fit does not settle)"
        evidence = f"(log evidence {fixed(gain, 1, '+')})"
        probability = self.share(lambda fit: bool({*effects} & {*fit.active}))
        if not probability:
            return f"not supported by the data {evidence}{self.reason}"
        if probability > 1 - LIKELY:
            return f"kept {evidence}{self.reason}"
        weight = f"{100 * probability:.0f} % probable, averaged in with that weight"
        return f"kept: {weight} {evidence}{self.reason}"


def choose_models(models: Sequence[FitPosterior]) -> ModelChoice:
    """Return the models that count: the geometry alone, which is the first, or the probable ones.

    With three placements the best model has to lower the errors of placements left out, too.
    """
    geometric, best = models[0], best_of(models)
    if best.log_evidence - geometric.log_evidence < LOG_BAYES_FACTOR:
        return ModelChoice([geometric])
    reason = ""
    if len(best.data.placements) >= ENOUGH_PLACEMENTS:
        try:
            falls = _held_out_errors(geometric) - _held_out_errors(best)
        except NotConverged:
            reason = "; the fit does not settle without each placement"
            return ModelChoice([geometric], reason)
        falls = falls[np.isfinite(falls)]
        mean, deviation = falls.mean(), falls.std(ddof=1) / np.sqrt(len(falls))
        reason = (
            f"; where one placement is left out, all together lower errors by "
            f"{1e3 * mean:.4f} +- {1e3 * deviation:.4f} mm"
        )
        if mean <= deviation:
            return ModelChoice([geometric], reason)
    probable = compress(models, model_probabilities(models) > LIKELY)
    return ModelChoice([*probable], reason)


def _held_out_errors(posterior: FitPosterior) -> np.ndarray:
    """Return each placement's error by a fit to others [m]; NaN where a frame is not tied then."""
    names = posterior.data.placements
    errors = np.full(len(names), np.nan)
    for part in range(min(PARTS, len(names))):
        held_out = names[part::PARTS]
        try:
            others = posterior.data.without(held_out)
            x = stepped(posterior, others).x
        except FrameError:
            continue
        for k in range(part, len(names), PARTS):
            errors[k] = _mean_error(posterior, x, names[k])
    return errors


def _mean_error(posterior: FitPosterior, x: np.ndarray, placement: str) -> float:
    """Return the mean distance of balls from their socket's mean or measured place [m]."""
    data = posterior.data
    samples = data.only(data.rows_of(placement))
    points = posterior.model.predict(x, samples)
    sockets = samples.sockets
    errors: list[np.ndarray] = []
    for socket in np.unique(sockets[sockets >= 0]):
        balls = points[sockets == socket]
        errors.append(balls - balls.mean(axis=0))
    by_instrument = sockets < 0
    if by_instrument.any():
        balls = points[by_instrument]
        measured = samples.points[by_instrument]
        pose = fit_pose(measured, balls)
        errors.append(balls - pose.apply(measured))
    distances = np.linalg.norm(np.concatenate(errors), axis=1)
    return float(distances.mean())

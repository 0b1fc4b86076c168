"""The fit of each joint's error curve together with everything else."""

from collections.abc import Callable

import numpy as np

from ...errors import fixed
from ..identification.effects import CURVE
from ..identification.inference import FitPosterior
from ..identification.model import SMALLEST
from .curve_comparison import compare, marginal_fit, random_rows
from .curve_estimate import posterior_with_curves
from .curve_posterior import MOST_SAMPLES
from .curve_prior import CurvePrior, given_curves
from .curve_scales import log_evidence
from .linear_samples import samples_around

LOG_EVIDENCE = 10.0
"""Least rise of the logarithm of the evidence by which curves are kept. On arms without curves,
sockets or points, it rose by 2.4 at most in 60 recordings."""
GIVEN = "kept, as an earlier calibration has them and these data change them"
EXACT = 10.0
"""Noise of less than so many times the least that there may be is that of exact data."""


def _may_have_curves(posterior: FitPosterior) -> bool:
    """Return True where curves are identifiable: by points or two placements, without play."""
    data, state = posterior.data, posterior.state
    least_noise = min(noise.space for noise in state.noises)
    if least_noise <= EXACT * SMALLEST:
        return False
    if any(group.width and group.follows_noise for group in state.groups):
        return False
    if len(data.placements) > 1:
        return True
    return not data.seated.all()


def with_joint_curves(
    posterior: FitPosterior,
    alternative: tuple[FitPosterior, float] | None,
    progress: Callable[[str], None],
) -> tuple[FitPosterior, str]:
    """Return a result with error curves of its joints where the data support them, and why.

    In sockets it takes two placements: at one, geometry explains as much. Joints with play hide
    curves. Where none can be found there are no words. ``alternative`` is the result of another
    model that may be more probable beside curves, and the logarithm of its odds before the data.
    """
    prior = given_curves(posterior.model)
    if prior is None and not _may_have_curves(posterior):
        return posterior, ""
    progress(CURVE.extension)
    try:
        return _with_joint_curves(posterior, alternative, prior)
    except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
        reason = "not supported by the data (with them, the fit does not settle)"
        return posterior, reason


def _with_joint_curves(
    posterior: FitPosterior,
    alternative: tuple[FitPosterior, float] | None,
    prior: CurvePrior | None,
) -> tuple[FitPosterior, str]:
    state, samples = samples_around(posterior.state, posterior.data)
    if prior is not None:
        rows = random_rows(samples, MOST_SAMPLES)
        fit = marginal_fit(state, samples, rows, prior)
        return posterior_with_curves(
            posterior, rows, fit, posterior.log_evidence
        ), GIVEN
    comparison = compare(state, samples)
    if comparison is None:
        reason = "not supported by the data (they would not raise the evidence)"
        return posterior, reason
    evidence = f"(log evidence {fixed(comparison.gain, 1, '+')})"
    if not comparison.gain > LOG_EVIDENCE:
        return posterior, f"not supported by the data {evidence}"
    start, rows = posterior, comparison.rows
    fit, after = comparison.curved, comparison.after
    if alternative is not None:
        other, log_odds = alternative
        rival = comparison.rival(other.state, posterior.data)
        after_of_rival = log_evidence(rival)
        if after_of_rival + log_odds > after:
            start, fit, after = other, rival, after_of_rival
    total = posterior.log_evidence - comparison.before + after
    return posterior_with_curves(start, rows, fit, total), f"kept {evidence}"

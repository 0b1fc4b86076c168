"""The fit of each joint's error curve with everything else, where the evidence is for it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...errors import fixed
from ..identification.effects import CURVE
from ..identification.inference import FitPosterior, State
from ..identification.model import SMALLEST, joint_reach
from .curve_estimate import posterior_with_curves
from .curve_fit import CurveFit
from .curve_posterior import MOST_SAMPLES
from .curve_prior import CurvePrior, given_curves
from .curve_scales import LONGEST, log_evidence, marginalised, promised_gain
from .linear_samples import LinearSamples, samples_around

FIRST_SAMPLES, HINT = 100, 1.0
"""Samples that are looked at first, and the rise below which curves are not sought on."""
MEDIAN_OF_CHI_2 = 2.37
"""Median square of a vector of three standard normal numbers."""
FIRST_LENGTH = 0.08
"""Length at which the search begins [rad]."""


@dataclass(frozen=True)
class Comparison:
    """Fits to some of the samples, each at the scales of its highest evidence."""

    rows: np.ndarray
    """Indices of these samples."""
    flat: CurveFit
    """The fit without curves."""
    curved: CurveFit
    """The fit with them."""

    @cached_property
    def before(self) -> float:
        """Logarithm of the evidence without curves."""
        return log_evidence(self.flat)

    @cached_property
    def after(self) -> float:
        """Logarithm of the evidence with them."""
        return log_evidence(self.curved)

    @property
    def gain(self) -> float:
        """Rise of the logarithm of the evidence by curves."""
        return self.after - self.before

    def rival(self, other: FitPosterior, posterior: FitPosterior) -> CurveFit:
        """Return the fit of another model to the same samples, from the scales with curves."""
        state, samples = samples_around(other.state, posterior.data)
        state = replace(state, noises=self.curved.state.noises)
        fit = replace(
            self.curved,
            state=state,
            samples=samples.only(self.rows),
            weights=self.curved.next_weights,
        )
        return marginalised(fit)


def compare(state: State, samples: LinearSamples) -> Comparison | None:
    """Return the comparison by few samples, or by many if these are in favour; None for no hint."""
    rows = random_rows(samples, FIRST_SAMPLES)
    first = _compared(state, samples, rows)
    is_all = len(rows) == len(samples.sources)
    if first is None or first.gain <= HINT or is_all:
        return first
    rows = random_rows(samples, MOST_SAMPLES)
    return _compared(first.flat.state, samples, rows, first.curved)


def _compared(
    state: State,
    samples: LinearSamples,
    rows: np.ndarray,
    begin: CurveFit | None = None,
) -> Comparison | None:
    """Return the comparison by some rows, from the scales of an earlier fit; None for no hint."""
    flat = marginal_fit(state, samples, rows, CurvePrior(0.0, LONGEST))
    if promised_gain(flat) < HINT:
        return None
    scales = begin or _initial_scales(flat)
    curved = replace(
        flat,
        state=scales.state,
        prior=scales.prior,
        weights=flat.next_weights,
    )
    return Comparison(rows, flat, marginalised(curved))


def marginal_fit(
    state: State,
    samples: LinearSamples,
    rows: np.ndarray,
    prior: CurvePrior,
) -> CurveFit:
    """Return the fit to some samples at the scales of highest evidence."""
    weights = np.ones(len(rows))
    fit = CurveFit(state, samples.only(rows), prior, weights)
    return marginalised(fit)


def random_rows(samples: LinearSamples, count: int) -> np.ndarray:
    """Return the indices of at most so many samples, drawn at random."""
    numbers = np.random.default_rng(0).random(len(samples.sources))
    return np.sort(numbers.argsort()[:count])


def _initial_scales(flat: CurveFit) -> CurveFit:
    """Return scales by which curves explain half of the errors, and noise the rest."""
    samples = flat.samples
    errors = samples.columns[:, :, -1]
    squares = (errors**2).sum(axis=1)
    square = float(np.median(squares)) / MEDIAN_OF_CHI_2
    half = 0.5**0.5
    noises = tuple(
        replace(noise, space=half * noise.space, joint=half * noise.joint)
        for noise in flat.state.noises
    )
    amplitude = half * square**0.5 / joint_reach(samples.slopes)
    return replace(
        flat,
        state=replace(flat.state, noises=noises),
        prior=CurvePrior(amplitude, FIRST_LENGTH),
    )


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
    return len(data.placements) > 1 or not data.seated.all()


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
        rival = comparison.rival(other, posterior)
        after_of_rival = log_evidence(rival)
        if after_of_rival + log_odds > after:
            start, fit, after = other, rival, after_of_rival
    total = posterior.log_evidence - comparison.before + after
    return posterior_with_curves(start, rows, fit, total), f"kept {evidence}"

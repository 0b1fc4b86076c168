"""Doubts about a place on a held chain: a wrong size of the board, a zero that changed.

Each doubt is an explanation of the same samples with an evidence of its own. A place x that follows
with covariance C from an unchanged chain, and x_k with C_k if zero k changed, has the covariance of
the mixture about x, with the probabilities p_k:

    C + sum_k p_k (C_k - C + (x_k - x)(x_k - x)^T)
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from .evidence import (
    TYPICAL,
    Explanation,
    Scatter,
    changes_of,
    linear_about,
    log_evidences,
    log_evidences_of_scatter,
    shares_beside,
)
from .fit import fit
from .system import System
from .zeros import (
    UNIDENTIFIABLE,
    ZERO_CHANGED,
    another_arm,
    fit_with_zeros,
    zero_deviations,
)

WRONG_SIZE, PRIOR_WRONG = 0.05, 0.05
"""Relative deviation of a size that is wrong, and the prior probability that it is."""
NARROW = 0.1
"""Share of that deviation from which on views say too little of the size."""
SCATTER = 2e-2
"""Scatter of views beyond which no size explains them [m]."""
CHANGED, MENTIONED = 0.7, 0.2
"""Probabilities of a changed zero from which it is told, and mentioned."""


def with_right_size(system: System) -> tuple[System, tuple[str, ...], bool]:
    """Return the fit by the size that the evidence prefers, a sentence if another was said.

    And whether the views tell the size: where its posterior is nearly as wide as the prior of
    wrong sizes, it stays as it was said.
    """
    task = system.task
    if task.exact_size:
        return system, (), True
    resized = fit(task.freeing({task.scale.start: WRONG_SIZE}))
    deviation = float(resized.posterior_covariance(task.scale)[0, 0]) ** 0.5
    if deviation > NARROW * WRONG_SIZE:
        return system, (), False
    odds = math.log(PRIOR_WRONG / (1 - PRIOR_WRONG))
    gain = resized.log_evidence() - system.log_evidence()
    if gain + odds < 0 or resized.state.noise.place > SCATTER:
        return system, (), True
    percent = 100 * math.expm1(resized.size)
    smaller = "smaller" if percent < 0 else "larger"
    words = (
        f"The views fit if the board or tag is {abs(percent):.1f} % (+- {100 * deviation:.1f}) "
        f"{smaller} than was said: measure it, and detect it again by what you read. The pose is "
        "by the size that fits."
    )
    return resized, (words,), True


@dataclass(frozen=True)
class ChangedZeros:
    """The chance that a zero changed since the calibration, and what it means for a place."""

    changed: dict[str, float]
    """Probability that each joint's zero changed."""
    covariance: np.ndarray
    """Of the place, whether or not a zero changed, shape (3, 3) [m^2]."""
    scatter: Scatter

    @property
    def probability(self) -> float:
        """Probability that any changed."""
        return sum(self.changed.values())

    @property
    def told(self) -> bool:
        """True where the samples tell that a zero changed."""
        return self.probability > CHANGED

    @property
    def alike(self) -> bool:
        """True where the samples tell that all joints scatter."""
        return self.scatter.probability > CHANGED

    @property
    def likeliest(self) -> str:
        """The joint whose zero changed most probably."""
        return max(self.changed, key=self.changed.__getitem__)

    @property
    def text(self) -> tuple[str, ...]:
        """A sentence on it."""
        if self.alike:
            return (str(self.scatter),)
        if self.probability < MENTIONED:
            return ()
        may = "changed" if self.told else "may have changed"
        alternative = ", or it is another arm's" if self.told else ""
        joint = f"{self.likeliest} {100 * self.changed[self.likeliest]:.0f} %"
        return (
            f"A joint's zero {may} since the calibration ({100 * self.probability:.0f} %; {joint})"
            f"{alternative}: record samples in sockets, and ask mukca rezero.",
        )

    def rival(self, system: System) -> tuple[str, ...]:
        """Return a warning where another arm, or else a changed zero, explains the samples."""
        if self.alike:
            return another_arm(system) or self.text
        if not self.told:
            return another_arm(system)
        joint = system.task.prior.robot.joint_names.index(self.likeliest)
        return another_arm(fit_with_zeros(system.task, [joint])) or self.text


def changed_zeros(system: System, place: np.ndarray) -> ChangedZeros:
    """Return how a zero that may have changed adds to a place, by its unknowns, shape (3,)."""
    task, prior = system.task, system.task.prior
    about, converged = linear_about(task, dict.fromkeys(prior.zeros, max(TYPICAL)))
    if not converged:
        about = system
    identifiable = np.flatnonzero(zero_deviations(about) < UNIDENTIFIABLE)
    candidates = [Explanation("", 1 - ZERO_CHANGED * len(identifiable), {})]
    for j in identifiable:
        candidates += changes_of(
            prior.robot.joint_names[j], ZERO_CHANGED, [prior.zeros[j]]
        )
    shares, scatter = shares_beside(
        log_evidences_of_scatter(about),
        log_evidences(about, candidates),
        task.rows.rounding,
    )
    certain = about.covariance_on_flange(place)
    covariance = system.covariance_on_flange(place)
    changed: dict[str, float] = {}
    for explanation, p in zip(candidates[1:], shares[1:].tolist(), strict=True):
        freed = replace(about, task=task.freeing(explanation.widths))
        shift = (freed.change - about.change)[place]
        widened = freed.covariance_on_flange(place) - certain
        covariance += p * (widened + np.outer(shift, shift))
        changed[explanation.name] = changed.get(explanation.name, 0.0) + p
    return ChangedZeros(changed, covariance, scatter)

"""Doubts about a place on a held chain: a wrong size of the board, a zero that changed.

Each doubt is an explanation of the same samples with an evidence of its own. A place x that follows
with covariance C from an unchanged chain, and x_k with C_k if zero k changed, has the covariance of
the mixture about x, with the probabilities p_k:

    C + sum_k p_k (C_k - C + (x_k - x)(x_k - x)^T)
"""

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ..bayes.model import probabilities
from .evidence import Explanation, linear_about, log_evidences
from .explanations import TYPICAL
from .fit import System, fit
from .zeros import UNIDENTIFIABLE, ZERO_CHANGED, another_arm, fit_with_zeros, zero_deviations

WRONG_SIZE, PRIOR_WRONG = 0.1, 0.05
"""Relative deviation of a size that is wrong, and the prior probability that it is."""
SCATTER = 2e-2
"""Scatter of views beyond which no size explains them [m]."""
CHANGED, MENTIONED = 0.7, 0.2
"""Probabilities of a changed zero from which it is told, and mentioned."""


def with_right_size(system: System) -> tuple[System, tuple[str, ...]]:
    """Return the fit by the size that the evidence prefers, and a sentence if another was said."""
    task = system.task
    loose_fit = fit(replace(task, free=task.free | {task.scale.start: WRONG_SIZE}))
    odds = math.log(PRIOR_WRONG / (1 - PRIOR_WRONG))
    gain = loose_fit.log_evidence(loose_fit.state.noise) - system.log_evidence(system.state.noise)
    if gain + odds < 0 or loose_fit.state.noise.place > SCATTER:
        return system, ()
    index = np.array([task.scale.start])
    percent, deviation = (
        loose_fit.state.size,
        float(loose_fit.posterior_covariance(index)[0, 0]) ** 0.5,
    )
    smaller = "smaller" if percent < 0 else "larger"
    return loose_fit, (
        f"The views fit if the board or tag is {100 * abs(math.expm1(percent)):.1f} % (+- "
        f"{100 * deviation:.1f}) {smaller} than was said: measure it, and detect it again by what "
        "you read. The pose is by the size that fits.",
    )


@dataclass(frozen=True)
class ChangedZeros:
    """The chance that a zero changed since the calibration, and what it means for a place."""

    changed: dict[str, float]
    """Probability that each joint's zero changed."""
    covariance: np.ndarray
    """Of the place, whether or not a zero changed, shape (3, 3) [m^2]."""

    @property
    def probability(self) -> float:
        """Probability that any changed."""
        return sum(self.changed.values())

    @property
    def text(self) -> tuple[str, ...]:
        """What is to be said of it, in words."""
        if self.probability < MENTIONED:
            return ()
        joint = max(self.changed, key=self.changed.__getitem__)
        may = "changed" if self.told else "may have changed"
        alternative = ", or it is another arm's" if self.told else ""
        return (
            f"A joint's zero {may} since the calibration ({100 * self.probability:.0f} %; {joint} "
            f"{100 * self.changed[joint]:.0f} %){alternative}: record samples in sockets, "
            "and ask mukca rezero.",
        )

    def rival(self, system: System) -> tuple[str, ...]:
        """Return a warning where another arm, or else a changed zero, explains the samples."""
        if not self.told:
            return another_arm(system)
        names = system.task.prior.robot.joint_names
        joint = names.index(max(self.changed, key=self.changed.__getitem__))
        return another_arm(fit_with_zeros(system.task, [joint])) or self.text

    @property
    def told(self) -> bool:
        """True where the samples tell that a zero changed."""
        return self.probability > CHANGED


def changed_zeros(system: System, place: np.ndarray) -> ChangedZeros:
    """Return how a zero that may have changed adds to a place, by its unknowns, shape (3,)."""
    task, zeros = system.task, system.task.prior.zeros
    wide = dict.fromkeys(range(zeros.start, zeros.stop), TYPICAL[1])
    about, converged = linear_about(task, wide)
    about = replace(about if converged else system, task=task)
    names = task.prior.robot.joint_names
    identifiable = np.flatnonzero(zero_deviations(about, task) < UNIDENTIFIABLE).tolist()
    unchanged = Explanation("", 1 - ZERO_CHANGED * len(identifiable), task.free)
    changes = [
        Explanation(names[j], ZERO_CHANGED / len(TYPICAL), task.free | {zeros.start + j: width})
        for j, width in product(identifiable, TYPICAL)
    ]
    odds = probabilities(log_evidences(about, [unchanged, *changes]))[1:].tolist()
    certain = about.covariance_on_flange(place)
    covariance = system.covariance_on_flange(place)
    changed: dict[str, float] = {}
    for hypothesis, p in zip(changes, odds, strict=True):
        freed = replace(about, task=replace(task, free=hypothesis.widths))
        shift = (freed.change - about.change)[place]
        covariance += p * (freed.covariance_on_flange(place) - certain + np.outer(shift, shift))
        changed[hypothesis.name] = changed.get(hypothesis.name, 0.0) + p
    return ChangedZeros(changed, covariance)

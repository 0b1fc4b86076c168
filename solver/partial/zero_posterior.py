"""Joints whose zeros changed, by the evidence of each set of them.

How exact the parts of an arm are is an unknown, too: a factor on the deviations of its prior, of
which there are a few. A model that is off in its lengths and angles explains samples as well as
changed zeros do, so the factor decides what can be told. With the probability p_k of factor k, the
offset o_k of a zero by it, and the deviation s_k, the offset and its variance are

    o = sum_k p_k o_k        s^2 = sum_k p_k (s_k^2 + (o_k - o)^2)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, compress

import numpy as np

from ..identification.model import probabilities
from .evidence import Explanation, linear_about, log_evidences, log_evidences_of_scatter
from .prior import ZERO
from .system import System
from .task import Task
from .zeros import (
    UNIDENTIFIABLE,
    ZERO_CHANGED,
    JointZero,
    another_arm,
    fit_with_zeros,
    scatter_words,
    zero_deviations,
)

WIDTHS = (2e-3, 2e-2, ZERO)
"""Typical changes of a joint's zero [rad], [m]."""
MOST_TOGETHER = 128
"""Sets of joints that are compared at most; the smaller sets come first."""
SURE = 0.9
"""Probability from which a joint's zero changed."""


@dataclass(frozen=True)
class ZeroPosterior:
    """Posterior of the zeros of all joints, once samples are seen."""

    system: System
    """The fit by the most probable factor."""
    factor: float
    """The most probable factor on the deviations of the arm's parts."""
    unchanged: float | None
    """Probability that no zero changed; None for joints that were named."""
    joints: tuple[JointZero, ...]
    """All of the arm's, in chain order."""
    blind: tuple[str, ...]
    """Joints whose zeros such samples do not identify, even if the parts are as exact as stated."""
    scattered: float = 0.0
    """Probability that no zero changed, and all joints scatter alike."""
    scatter: float = 0.0
    """Most probable scatter of that kind [rad]."""

    @property
    def scatter_text(self) -> str:
        """A sentence that all joints scatter alike; empty where they do not."""
        if self.scattered < SURE:
            return ""
        return scatter_words(self.scatter, self.scattered)

    @property
    def is_of_another_arm(self) -> bool:
        """True where a different arm explains the samples far better."""
        return bool(another_arm(self.system))


@dataclass(frozen=True)
class ZeroEstimates:
    """Estimates of the zeros of all joints by one factor."""

    system: System
    """The fit, with the zeros that changed among its unknowns."""
    offsets: np.ndarray
    """Shape (m,) [rad], [m]; 0 of zeros that did not change."""
    deviations: np.ndarray
    """Shape (m,) [rad], [m]; of a zero that did not change, were it to be found alone."""

    @staticmethod
    def of(about: System, changed: np.ndarray) -> "ZeroEstimates":
        """Return the estimates of zeros that changed, by their joints' numbers, beside the others.

        The others follow from a system that is linear about a fit.
        """
        system = fit_with_zeros(about.task, changed)
        unknowns = about.task.prior.zeros[changed]
        deviations = zero_deviations(about)
        offsets = np.zeros(len(deviations))
        offsets[changed] = system.shift[unknowns]
        if len(changed):
            covariance = system.posterior_covariance(unknowns)
            deviations[changed] = np.sqrt(np.diag(covariance))
        return ZeroEstimates(system, offsets, deviations)


def find_zeros(
    task: Task, joints: Sequence[int], factors: Mapping[float, float]
) -> ZeroPosterior:
    """Return the posterior with free zeros of the named joints, or of those the evidence names.

    Args:
        task: The samples, and the arm with its parts as exact as its prior states.
        joints: Numbers of the named joints.
        factors: Prior probability of each factor on the deviations of the parts, 1 first.
    """
    names, zeros = task.prior.robot.joint_names, task.prior.zeros
    tasks = [task.tolerating(factor) for factor in factors]
    free = zeros[[*joints]] if joints else zeros
    widest, converged = linear_about(tasks[-1], dict.fromkeys(free, ZERO))
    systems = [replace(widest, task=by_factor) for by_factor in tasks]
    if joints:
        sets = _changes_of([tuple(joints)], task, len(joints))
    else:
        identifiable = zero_deviations(systems[0]) < UNIDENTIFIABLE
        sets = _sets_of_zeros(task, np.flatnonzero(identifiable).tolist())
    weights = np.array([*factors.values()])
    shares = np.zeros((len(tasks), len(sets)))
    by_scatter: dict[float, float] = {}
    if converged:
        logs = np.array([log_evidences(system, sets) for system in systems])
        # What scatters is no zero; of a nominal model, lengths that are off look alike.
        may_scatter = not joints and len(tasks) == 1
        scatters = log_evidences_of_scatter(widest) if may_scatter else {}
        weighted = np.log(weights)[:, None] + logs
        all_shares = probabilities(np.append(weighted, [*scatters.values()]))
        shares = all_shares[: logs.size].reshape(logs.shape)
        by_scatter = dict(zip(scatters, all_shares[logs.size :].tolist(), strict=True))
        weights = shares.sum(axis=1) if len(tasks) > 1 else weights
    by_set = shares.sum(axis=0)
    changed = _probabilities_of_change(by_set, sets, joints, len(zeros))
    numbers = np.flatnonzero(changed > SURE)
    estimates = [ZeroEstimates.of(system, numbers) for system in systems]
    offsets, deviations = _mixture(weights, estimates)
    offsets[deviations >= UNIDENTIFIABLE] = 0.0
    columns = changed.tolist(), offsets.tolist(), deviations.tolist()
    scattered = sum(by_scatter.values())
    unchanged = float(shares[:, : len(WIDTHS)].sum()) + scattered  # of the empty set
    blind = estimates[0].deviations >= UNIDENTIFIABLE
    likeliest = int(np.argmax(weights))
    return ZeroPosterior(
        system=estimates[likeliest].system,
        factor=[*factors][likeliest],
        unchanged=None if joints else unchanged,
        joints=tuple(map(JointZero, names, *columns)),
        blind=tuple(compress(names, blind)),
        scattered=scattered,
        scatter=max(by_scatter, key=by_scatter.__getitem__, default=0.0),
    )


def _sets_of_zeros(task: Task, joints: Sequence[int]) -> list[Explanation]:
    """Return the hypotheses that the zeros of a set of joints changed, the empty set first."""
    sets: list[tuple[int, ...]] = []
    for size in range(len(joints) + 1):
        sets += combinations(joints, size)
        if len(sets) > MOST_TOGETHER:
            break
    return _changes_of(sets, task, len(joints))


def _changes_of(
    sets: Sequence[tuple[int, ...]], task: Task, count: int
) -> list[Explanation]:
    """Return the hypotheses that zeros of each set changed, of so many joints that may have."""
    explanations: list[Explanation] = []
    for joints in sets:
        others = count - len(joints)
        prior = ZERO_CHANGED ** len(joints) * (1 - ZERO_CHANGED) ** others
        zeros = task.prior.zeros[[*joints]]
        for width in WIDTHS:
            widths = dict.fromkeys(zeros, width)
            explanations.append(Explanation("", prior / len(WIDTHS), widths, joints))
    return explanations


def _probabilities_of_change(
    shares: np.ndarray,
    sets: Sequence[Explanation],
    named: Sequence[int],
    count: int,
) -> np.ndarray:
    """Return the probability that each joint's zero changed, 1 of named ones, shape (m,)."""
    changed = np.zeros(count)
    for share, explanation in zip(shares, sets, strict=True):
        changed[[*explanation.joints]] += share
    changed[[*named]] = 1.0
    return changed


def _mixture(
    weights: np.ndarray, estimates: Sequence[ZeroEstimates]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the offsets of all zeros and their deviations by estimates of known probability."""
    offsets = np.array([estimate.offsets for estimate in estimates])
    deviations = np.array([estimate.deviations for estimate in estimates])
    offset = weights @ offsets
    variances = weights @ (deviations**2 + (offsets - offset) ** 2)
    return offset, np.sqrt(variances)

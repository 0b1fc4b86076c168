"""Joints whose zeros changed, by the evidence of each set of them.

How exact the parts of an arm are is an unknown, too: a factor on the deviations of its prior, of
which there are a few. A model that is off in its lengths and angles explains samples as well as
changed zeros do, so the factor decides what can be told. With the probability p_k of factor k, the
offset o_k of a zero by it, and the deviation s_k, the offset and its variance are

    o = sum_k p_k o_k        s^2 = sum_k p_k (s_k^2 + (o_k - o)^2)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, compress, product

import numpy as np

from .evidence import (
    Explanation,
    Scatter,
    linear_about,
    log_evidences,
    log_evidences_of_scatter,
    shares_beside,
)
from .prior import ZERO
from .system import System
from .task import Task
from .zeros import (
    UNIDENTIFIABLE,
    ZERO_CHANGED,
    JointZero,
    fit_with_zeros,
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
    scatter: Scatter
    """Scatter that no zero explains."""

    @property
    def scatter_text(self) -> str:
        """A sentence that all joints scatter alike; empty where they do not."""
        return "" if self.scatter.probability < SURE else str(self.scatter)


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
    systems = [replace(widest, task=tolerant) for tolerant in tasks]
    tried = [tuple(joints)]
    if not joints:
        tried = _sets_of(np.flatnonzero(zero_deviations(systems[0]) < UNIDENTIFIABLE))
    sets = _changes_of(tried, zeros)
    weights = np.array([*factors.values()])
    shares = np.zeros((len(tasks), len(sets)))
    scatter = Scatter()
    if converged:
        logs = np.array([log_evidences(system, sets) for system in systems])
        # What scatters is no zero; of a nominal model, lengths that are off look alike.
        may_scatter = not joints and len(tasks) == 1
        scatters = log_evidences_of_scatter(widest) if may_scatter else {}
        logs += np.log(weights)[:, None]
        shares, scatter = shares_beside(scatters, logs, task.rows.rounding)
        weights = shares.sum(axis=1) if len(tasks) > 1 else weights
    changed = np.zeros(len(zeros))
    for share, explanation in zip(shares.sum(axis=0), sets, strict=True):
        changed[[*explanation.joints]] += share
    changed[[*joints]] = 1.0
    numbers = np.flatnonzero(changed > SURE)
    estimates = [_estimates(system, numbers) for system in systems]
    by_factor = np.array([offsets for _, offsets, _ in estimates])
    deviations = np.array([deviations for *_, deviations in estimates])
    offsets = weights @ by_factor
    sigma = np.sqrt(weights @ (deviations**2 + (by_factor - offsets) ** 2))
    offsets[sigma >= UNIDENTIFIABLE] = 0.0
    columns = changed.tolist(), offsets.tolist(), sigma.tolist()
    of_empty_set = float(shares[:, : len(WIDTHS)].sum())
    unchanged = min(of_empty_set + scatter.probability, 1.0)
    likeliest = int(np.argmax(weights))
    return ZeroPosterior(
        system=estimates[likeliest][0],
        factor=[*factors][likeliest],
        unchanged=None if joints else unchanged,
        joints=tuple(map(JointZero, names, *columns)),
        blind=tuple(compress(names, deviations[0] >= UNIDENTIFIABLE)),
        scatter=scatter,
    )


def _estimates(
    about: System, changed: np.ndarray
) -> tuple[System, np.ndarray, np.ndarray]:
    """Return the fit with the zeros that changed, by their joints' numbers, among its unknowns.

    With the offsets of all zeros, shape (m,) [rad], [m], 0 of those that did not change; and their
    deviations, of such a zero were it to be found alone, from a system that is linear about a fit.
    """
    system = fit_with_zeros(about.task, changed)
    unknowns = about.task.prior.zeros[changed]
    deviations = zero_deviations(about)
    offsets = np.zeros(len(deviations))
    offsets[changed] = system.shift[unknowns]
    if len(changed):
        deviations[changed] = np.sqrt(np.diag(system.posterior_covariance(unknowns)))
    return system, offsets, deviations


def _sets_of(joints: np.ndarray) -> list[tuple[int, ...]]:
    """Return the sets of some joints, the empty set first."""
    sets: list[tuple[int, ...]] = []
    for size in range(len(joints) + 1):
        sets += combinations(joints.tolist(), size)
        if len(sets) > MOST_TOGETHER:
            break
    return sets


def _changes_of(
    sets: Sequence[tuple[int, ...]], zeros: np.ndarray
) -> list[Explanation]:
    """Return the hypotheses that zeros of each set of joints changed, and those of no other."""
    count = len({*chain.from_iterable(sets)})
    return [
        Explanation(
            "",
            ZERO_CHANGED ** len(joints)
            * (1 - ZERO_CHANGED) ** (count - len(joints))
            / len(WIDTHS),
            dict.fromkeys(zeros[[*joints]], width),
            joints,
        )
        for joints, width in product(sets, WIDTHS)
    ]

"""Joints whose zeros changed, by the evidence of each set of them; or another arm."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..bayes.model import probabilities
from .evidence import Explanation, geometry_changes, linear_about, log_evidences
from .fit import fit
from .prior import ZERO
from .system import System
from .task import Task

WIDTHS = (2e-3, 2e-2, ZERO)
"""Typical changes of a joint's zero [rad], [m]."""
MOST_TOGETHER = 128
"""Sets of joints that are compared at most; the smaller sets come first."""
ZERO_CHANGED = 0.02
"""Prior probability that a joint's zero changed, where several may have."""
TICK = 2 * math.pi / 4096
"""Step of a servo with 4096 in a turn [rad]."""
ANOTHER, LESS = math.log(1000), 0.5
"""Log Bayes factor of a geometry that changed everywhere, and the share of the noise that it
leaves, from which samples are taken for another arm's."""
UNIDENTIFIABLE = 1e-2
"""Standard deviation beyond which a zero is not identifiable [rad], [m]."""
SURE = 0.9
"""Probability from which a joint's zero changed."""


@dataclass(frozen=True)
class JointZero:
    """Estimate of the change of a joint's zero."""

    joint: str
    changed: float
    """Probability that it changed; 1 where it was named."""
    offset: float
    """To be added to what the joint reads [rad], [m]; 0 where it did not change."""
    standard_deviation: float
    """Of the offset [rad], [m]; of one that did not change, were it to be found alone."""

    @property
    def told(self) -> bool:
        """True if the samples can identify it."""
        return self.standard_deviation < UNIDENTIFIABLE

    @property
    def degrees(self) -> float:
        """The offset [deg]."""
        return math.degrees(self.offset)

    @property
    def brief(self) -> str:
        """What to add to its readings, in a line."""
        offset = f"{self.offset:+.5f} +- {self.standard_deviation:.5f} rad"
        return f"{self.joint}: add {offset} ({self.degrees:+.3f} deg) to what it reads."

    def __str__(self) -> str:
        offset = f"{self.offset:+.6f} +- {self.standard_deviation:.6f} rad"
        counts = f"{self.counts:+d}"
        return (
            f"{self.joint}: {offset} to be added to what it reads ({self.degrees:+.4f} deg; of a "
            f"servo with 4096 counts a turn {counts}, its homing_offset {-self.counts:+d} "
            f"(Feetech), {counts} (Dynamixel))"
        )

    @property
    def counts(self) -> int:
        """The offset in whole counts of a servo."""
        return round(self.offset / TICK)


def fit_with_zeros(task: Task, joints: Sequence[int] | np.ndarray) -> System:
    """Return the fit with the zeros of some joints as further unknowns."""
    zeros = task.prior.zeros[np.asarray(joints, dtype=int)]
    return fit(task.freeing(dict.fromkeys(zeros, ZERO)))


def find_zeros(
    task: Task, joints: Sequence[int]
) -> tuple[System, float | None, tuple[JointZero, ...]]:
    """Return the fit with free zeros of the named joints, or of those that the evidence names.

    Then the probability that none changed, None for joints that were named; and all joints' zeros.
    """
    names, zeros = task.prior.robot.joint_names, task.prior.zeros
    if joints:
        probability = np.isin(np.arange(len(names)), joints) * 1.0
        unchanged = None
        system = fit_with_zeros(task, joints)
        deviations = zero_deviations(replace(system, task=task))
    else:
        about, converged = linear_about(task, dict.fromkeys(zeros, ZERO))
        deviations = zero_deviations(about)
        sets = _sets_of_zeros(
            task, np.flatnonzero(deviations < UNIDENTIFIABLE).tolist()
        )
        shares = np.zeros(len(sets))
        if converged:
            shares = probabilities(log_evidences(about, sets))
        probability = np.zeros(len(names))
        for share, explanation in zip(shares, sets, strict=True):
            probability[[*explanation.joints]] += share
        unchanged = float(sum(shares[: len(WIDTHS)]))  # those of the empty set
        system = fit_with_zeros(task, np.flatnonzero(probability > SURE))
    offsets = np.zeros(len(names))
    changed = np.flatnonzero(probability > SURE)
    if len(changed):
        unknowns = zeros[changed]
        deviations[changed] = np.sqrt(np.diag(system.posterior_covariance(unknowns)))
        shifts = system.shift[unknowns]
        offsets[changed] = np.where(deviations[changed] < UNIDENTIFIABLE, shifts, 0)
    columns = probability.tolist(), offsets.tolist(), deviations.tolist()
    return system, unchanged, tuple(map(JointZero, names, *columns))


def zero_deviations(system: System) -> np.ndarray:
    """Return the standard deviation of each joint's zero, if it alone may have changed."""
    A = system.slopes[:, system.task.prior.zeros]
    C = system.covariance(system.state.noise, gaussian=True)
    weighted = np.linalg.solve(C, A)
    information: np.ndarray = np.sum(A * weighted, axis=0)
    return 1 / np.sqrt(information + ZERO**-2)


def _sets_of_zeros(task: Task, joints: Sequence[int]) -> list[Explanation]:
    """Return the hypotheses that the zeros of a set of joints changed, the empty set first."""
    sets: list[tuple[int, ...]] = []
    for size in range(len(joints) + 1):
        sets += combinations(joints, size)
        if len(sets) > MOST_TOGETHER:
            break
    explanations: list[Explanation] = []
    for subset in sets:
        prior = ZERO_CHANGED ** len(subset) * (1 - ZERO_CHANGED) ** (
            len(joints) - len(subset)
        )
        zeros = task.prior.zeros[[*subset]]
        for width in WIDTHS:
            widths = dict.fromkeys(zeros, width)
            explanations.append(Explanation("", prior / len(WIDTHS), widths, subset))
    return explanations


def another_arm(system: System) -> tuple[str, ...]:
    """Return a warning where a different arm explains the samples far better, else nothing."""
    with_geometry = fit(system.task.freeing(geometry_changes(system.task)))
    scatter, least = system.state.noise.place, with_geometry.state.noise.place
    gain = with_geometry.log_evidence() - system.log_evidence()
    if gain < ANOTHER or least > LESS * scatter:
        return ()
    return (
        f"The samples scatter by {1e3 * scatter:.2f} mm an axis, and by {1e3 * least:.2f} if the "
        "whole arm may differ: is this another arm's calibration or model, or did more change?",
    )

"""Joints whose zeros changed, by the evidence of each set of them; or another arm."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from ..bayes.model import probabilities
from .evidence import Explanation, geometry_changes, linear_about, log_evidences
from .fit import System, fit
from .prior import ZERO
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
    def brief(self) -> str:
        """What to add to its readings, in a line."""
        degrees = math.degrees(self.offset)
        offset = f"{self.offset:+.5f} +- {self.standard_deviation:.5f} rad"
        return f"{self.joint}: add {offset} ({degrees:+.3f} deg) to what it reads."

    def __str__(self) -> str:
        offset, sigma = self.offset, self.standard_deviation
        return (
            f"{self.joint}: {offset:+.6f} +- {sigma:.6f} rad to be added to what it reads "
            f"({math.degrees(offset):+.4f} deg; of a servo with 4096 counts a turn "
            f"{self.counts:+d}, its homing_offset {-self.counts:+d} (Feetech), {self.counts:+d} "
            "(Dynamixel))"
        )

    @property
    def counts(self) -> int:
        """The offset in whole counts of a servo."""
        return round(self.offset / TICK)


def fit_with_zeros(task: Task, joints: Iterable[int]) -> System:
    """Return the fit with the zeros of some joints as further unknowns."""
    indices = [task.prior.zeros.start + j for j in joints]
    return fit(replace(task, free=task.free | dict.fromkeys(indices, ZERO)))


def find_zeros(
    task: Task, joints: Sequence[int]
) -> tuple[System, float | None, tuple[JointZero, ...]]:
    """Return the fit with free zeros of the named joints, or of those that the evidence names.

    Then the probability that none changed, None for joints that were named; and all joints' zeros.
    """
    names, zeros = task.prior.robot.joint_names, task.prior.zeros
    indices = np.arange(len(names))
    if joints:
        probability, unchanged = np.isin(indices, joints) * 1.0, None
        system = fit_with_zeros(task, joints)
        deviations = zero_deviations(system, task)
    else:
        about, converged = linear_about(task, dict.fromkeys(range(zeros.start, zeros.stop), ZERO))
        deviations = zero_deviations(about, task)
        sets = _sets_of_zeros(task, np.flatnonzero(deviations < UNIDENTIFIABLE).tolist())
        shares = probabilities(log_evidences(about, sets)) if converged else np.zeros(len(sets))
        probability = shares @ [np.isin(indices, explanation.joints) for explanation in sets]
        unchanged = float(shares @ [not explanation.joints for explanation in sets])
        system = fit_with_zeros(task, np.flatnonzero(probability > SURE).tolist())
    changed, offsets = np.flatnonzero(probability > SURE), np.zeros(len(names))
    if len(changed):
        unknowns = changed + zeros.start
        deviations[changed] = np.sqrt(np.diag(system.posterior_covariance(unknowns)))
        shifts = system.state.x[unknowns] - task.prior.mean[unknowns]
        offsets[changed] = np.where(deviations[changed] < UNIDENTIFIABLE, shifts, 0)
    rows = zip(names, probability.tolist(), offsets.tolist(), deviations.tolist(), strict=True)
    return system, unchanged, tuple(JointZero(*row) for row in rows)


def zero_deviations(system: System, task: Task) -> np.ndarray:
    """Return the standard deviation of each joint's zero, if it were the only one unknown."""
    A = system.slopes[:, task.prior.zeros]
    C = replace(system, task=task).covariance(system.state.noise, gaussian=True)
    information: np.ndarray = np.sum(A * np.linalg.solve(C, A), axis=0)
    return 1 / np.sqrt(information + ZERO**-2)


def _sets_of_zeros(task: Task, joints: Sequence[int]) -> list[Explanation]:
    """Return the hypotheses that the zeros of a set of joints changed, the empty set first."""
    sets: list[tuple[int, ...]] = []
    for size in range(len(joints) + 1):
        sets += combinations(joints, size)
        if len(sets) > MOST_TOGETHER:
            break
    begin, candidates = task.prior.zeros.start, list[Explanation]()
    for subset, width in product(sets, WIDTHS):
        prior = ZERO_CHANGED ** len(subset) * (1 - ZERO_CHANGED) ** (len(joints) - len(subset))
        widths = task.free | dict.fromkeys([begin + j for j in subset], width)
        candidates.append(Explanation("", prior / len(WIDTHS), widths, subset))
    return candidates


def another_arm(system: System) -> tuple[str, ...]:
    """Return a warning where a different arm explains the samples far better, else nothing."""
    task, noise = system.task, system.state.noise
    with_geometry = fit(replace(task, free=task.free | geometry_changes(task)))
    noise_of_geometry = with_geometry.state.noise
    gain = with_geometry.log_evidence(noise_of_geometry) - system.log_evidence(noise)
    if gain < ANOTHER or noise_of_geometry.place > LESS * noise.place:
        return ()
    scatter = f"{1e3 * noise.place:.2f} mm an axis, and by {1e3 * noise_of_geometry.place:.2f}"
    return (
        f"The samples scatter by {scatter} if the whole arm may differ: is this another arm's "
        "calibration or model, or did more change?",
    )

"""Comparison of explanations of what changed, by their evidence.

Each explanation frees some unknowns beside the prior: N(e; 0, C + A A^T) with A the slopes by them,
times their prior standard deviations, and is averaged over these and over the noise. Each
explanation also lets all zeros vary by as little as a ball's seat seen from a metre away.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..assessment import mm
from .fit import System, fit, linear, next_step
from .prior import ZERO
from .task import Task

NOTHING, LENGTHS, EVERYTHING = "nothing", "distance", "everything"
PRIOR = {NOTHING: 0.5, LENGTHS: 0.05, "joint": 0.3, "tool": 0.1, "base": 0.1, EVERYTHING: 0.1}
"""Prior probabilities; that of ``joint`` is shared among all joints."""
TYPICAL = (1e-3, 2e-2)
"""Typical changes of a joint's zero [rad], of a tool's or base's place [m]."""
GEOMETRY_CHANGES = {"m": 1e-3, "rad": 3e-3}
"""Typical change of each number of the geometry after a crash [m], [rad]."""
ANOTHER, LESS = math.log(1000), 0.5
"""Log Bayes factor of a geometry that changed everywhere, and the share of the noise that it
leaves, from which samples are taken for another arm's."""
UNCHANGED = 5e-5
"""Standard deviation of the zero of a joint that did not change, from place to place [rad], [m]."""
DIVERGED = 1e-2
"""Next step beyond which a fit is taken for diverged [m]."""
WIDTHS = (2e-3, 2e-2, ZERO)
"""Typical changes of a joint's zero [rad], [m]."""
MOST_TOGETHER = 128
"""Sets of joints that are compared at most; the smaller sets come first."""
ZERO_CHANGED = 0.02
"""Prior probability that a joint's zero changed, where several may have."""
TICK = 2 * math.pi / 4096
"""Step of a servo with 4096 in a turn [rad]."""
UNIDENTIFIABLE = 1e-2
"""Standard deviation beyond which a zero is not identifiable [rad], [m]."""
SURE = 0.9
"""Probability from which a joint's zero changed."""
LEVELS = np.exp(np.linspace(-1.2, 1.2, 13))
"""Factors on the noise over which the evidence is averaged."""


@dataclass(frozen=True)
class Explanation:
    """A hypothesis on what changed."""

    name: str
    prior: float
    """Prior probability."""
    widths: Sequence[dict[int, float]]
    """Prior standard deviations of the unknowns that changed; the alternatives are equally likely.

    After the unknowns of the task, indices count the errors of the stated distances.
    """
    joints: tuple[int, ...] = ()
    """Joints whose zeros changed."""


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

    def __str__(self) -> str:
        found, sigma = self.offset, self.standard_deviation
        return (
            f"{self.joint}: {found:+.6f} +- {sigma:.6f} rad to be added to what it reads "
            f"({math.degrees(found):+.4f} deg; of a servo with 4096 counts a turn "
            f"{self.counts:+d}, its homing_offset {-self.counts:+d} (Feetech), {self.counts:+d} "
            "(Dynamixel))"
        )

    @property
    def counts(self) -> int:
        """The offset in whole counts of a servo."""
        return round(self.offset / TICK)


@dataclass(frozen=True)
class NearestCause:
    """An offset of one joint, and the error that remains with it."""

    joint: str
    offset: float
    """To be added to what the joint reads [rad], [m] for a prismatic joint."""
    error: float
    """Mean absolute error [m]."""
    unit: str

    def text(self, share: str) -> str:
        """Return it in words, with its probability."""
        size = f"{1e3 * self.offset:+.2f} mm"
        if self.unit == "rad":
            size = f"{math.degrees(self.offset):+.2f} deg"
        left = mm(self.error)
        return f"nearest cause {self.joint} ({share}), off by {size}: with it {left} are left"


def fit_with_zeros(task: Task, joints: Iterable[int]) -> System:
    """Return the fit with the zeros of some joints as further unknowns."""
    own = [task.prior.zeros.start + j for j in joints]
    return fit(replace(task, free=task.free | dict.fromkeys(own, ZERO)))


def linear_about(
    task: Task, wide: dict[int, float], *, lengths: bool = False
) -> tuple[System, bool]:
    """Return a task linearised about a fit with wider priors, and True if that fit converged.

    Where distances may be wrong (``lengths``) the fit is to samples alone: a wrong distance would
    bias everything else.
    """
    wider = replace(task, free=wide | task.free)
    about = fit(replace(wider, distances=()) if lengths else wider)
    return linear(wider, about.state), next_step(about) < DIVERGED


def probabilities(system: System, explanations: Sequence[Explanation]) -> np.ndarray:
    """Return the probabilities of explanations by a linear system, shape (E,)."""
    zeros, noise = system.task.prior.zeros, system.task.noise
    wander = dict.fromkeys(range(zeros.start, zeros.stop), UNCHANGED)
    held = replace(system, task=replace(system.task, free=wander))
    used = sorted({i for e in explanations for width in e.widths for i in width})
    lengths = np.eye(len(system.errors))[:, len(system.errors) - len(system.task.distances) :]
    A = np.hstack([system.slopes, lengths])[:, used]
    logs = np.full((len(LEVELS), len(explanations)), -np.inf)
    for level, factor in enumerate(LEVELS):
        trial = replace(noise, place=factor * noise.place)
        root, alone = np.linalg.cholesky(held.covariance(trial)), held.log_evidence(trial)
        e, B = np.linalg.solve(root, system.errors), np.linalg.solve(root, A)
        M, g = B.T @ B, B.T @ e
        for i, one in enumerate(explanations):
            gains = [_gain(M, g, np.searchsorted(used, list(w)), w) for w in one.widths]
            logs[level, i] = alone + np.log(one.prior / len(gains)) + np.logaddexp.reduce(gains)
    each = np.logaddexp.reduce(logs, axis=0)
    odds: np.ndarray = np.exp(each - each.max())
    return odds / odds.sum()


def _gain(M: np.ndarray, g: np.ndarray, own: np.ndarray, width: Mapping[int, float]) -> float:
    """Return ln N(e; 0, C + A A^T) - ln N(e; 0, C)."""
    w = np.array(list(width.values()))
    N = np.eye(len(own)) + w[:, None] * M[np.ix_(own, own)] * w
    b = w * g[own]
    return float(0.5 * (b @ np.linalg.solve(N, b) - np.linalg.slogdet(N)[1]))


def explanations(task: Task) -> list[Explanation]:
    """Return the hypotheses: nothing, a wrong distance, a joint, the tool, the base, everything."""
    prior = task.prior
    joints, begin = prior.robot.joint_names, prior.zeros.start
    base = [i for k in task.known for i in task.places[k].tolist()]
    each = PRIOR["joint"] / len(joints)
    some = [(name, each, [begin + j]) for j, name in enumerate(joints)]
    if task.distances:
        own = list(range(task.size, task.size + len(task.distances)))
        some.insert(0, (LENGTHS, PRIOR[LENGTHS], own))
    if prior.ball[0] not in task.free:
        some.append(("tool", PRIOR["tool"], prior.ball.tolist()))
    if base:
        some.append(("base", PRIOR["base"], base))
    found = [
        Explanation(name, before, [task.free | dict.fromkeys(own, width) for width in TYPICAL])
        for name, before, own in some
    ]
    everything = Explanation(EVERYTHING, PRIOR[EVERYTHING], [task.free | _geometry(task)])
    return [Explanation(NOTHING, PRIOR[NOTHING], [task.free]), *found, everything]


def find_zeros(
    task: Task, named: Sequence[int]
) -> tuple[System, float | None, tuple[JointZero, ...]]:
    """Return the fit with free zeros of the named joints, or of those that the evidence names.

    Then the probability that none changed, None for joints that were named; and all joints' zeros.
    """
    names, zeros = task.prior.robot.joint_names, task.prior.zeros
    count = len(names)
    if named:
        probability, unchanged, changed = np.isin(np.arange(count), named) * 1.0, None, list(named)
        system = fit_with_zeros(task, changed)
        deviations = zero_deviations(system, task)
    else:
        about, converged = linear_about(task, dict.fromkeys(range(zeros.start, zeros.stop), ZERO))
        deviations = zero_deviations(about, task)
        sets = _sets_of_zeros(task, np.flatnonzero(deviations < UNIDENTIFIABLE).tolist())
        odds = probabilities(about, sets) if converged else np.zeros(len(sets))
        probability = odds @ [[j in one.joints for j in range(count)] for one in sets]
        unchanged, changed = float(odds[0]), np.flatnonzero(probability > SURE).tolist()
        system = fit_with_zeros(task, changed)
    offsets = np.zeros(count)
    if changed:
        own = np.array(changed) + zeros.start
        deviations[changed] = np.sqrt(np.diag(system.posterior_covariance(own)))
        moved = system.state.x[own] - task.prior.mean[own]
        offsets[changed] = np.where(deviations[changed] < UNIDENTIFIABLE, moved, 0)
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
    begin = task.prior.zeros.start
    return [
        Explanation(
            "",
            ZERO_CHANGED ** len(one) * (1 - ZERO_CHANGED) ** (len(joints) - len(one)),
            [task.free | {begin + j: width for j in one} for width in WIDTHS],
            one,
        )
        for one in sets
    ]


def another_arm(system: System) -> tuple[str, ...]:
    """Return a warning where a different arm explains the samples far better, else nothing."""
    task, held = system.task, system.state.noise
    loose = fit(replace(task, free=task.free | _geometry(task)))
    free = loose.state.noise
    gain = loose.log_evidence(free) - system.log_evidence(held)
    if gain < ANOTHER or free.place > LESS * held.place:
        return ()
    scatter = f"{1e3 * held.place:.2f} mm an axis, and by {1e3 * free.place:.2f}"
    return (
        f"The samples scatter by {scatter} if the whole arm may differ: is this another arm's "
        "calibration or model, or did more change?",
    )


def _geometry(task: Task) -> dict[int, float]:
    """Return the prior standard deviations of a chain all of whose numbers may have changed."""
    parameters = enumerate(task.prior.model.parameters)
    return {i: GEOMETRY_CHANGES[p.unit] for i, p in parameters if not p.of_ball}

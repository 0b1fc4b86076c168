"""Which of several things changed, by the evidence.

Each explanation frees some unknowns beside the prior: N(e; 0, C + A A^T) with A the slopes by them,
times how far they may have changed. It is averaged over those widths, and over the noise. Zeros
that wander by what a ball's seat wanders a metre away are unchanged in each of them.
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
"""Probabilities before the samples; that of the joints is shared among them."""
TYPICAL = (1e-3, 2e-2)
"""Typical changes of a joint's zero [rad], of a tool's or base's place [m]."""
CRASHED = {"m": 1e-3, "rad": 3e-3}
"""Typical change of each number of the geometry after a crash."""
ANOTHER, LESS = math.log(1000), 0.5
"""Rise of the logarithm of the evidence by a geometry that may have changed everywhere, and share
of the noise that is left then, from which samples are another arm's."""
UNCHANGED = 5e-5
"""Standard deviation of the zero of a joint that did not change, from place to place [rad], [m]."""
ASTRAY = 1e-2
"""A next step beyond which a fit did not converge, and is no evidence [m]."""
WIDTHS = (2e-3, 2e-2, ZERO)
"""Typical changes of a joint's zero [rad], [m]."""
MOST_TOGETHER = 128
"""Sets of joints that are compared; of more joints, only the smaller sets."""
ZERO_CHANGED = 0.02
"""Probability before the samples that a joint's zero changed, where several may have."""
UNTOLD = 1e-2
"""A zero whose standard deviation is larger is not told [rad], [m]."""
SURE = 0.9
"""Probability from which a joint's zero changed."""
LEVELS = np.exp(np.linspace(-1.2, 1.2, 13))
"""Scales of noise that are tried, as factors."""


@dataclass(frozen=True)
class Explanation:
    """Something that may have changed."""

    name: str
    prior: float
    """Its probability before the samples."""
    widths: Sequence[dict[int, float]]
    """Standard deviations by which unknowns are freed; one of these holds, each as likely.

    Behind all unknowns stand the errors of the distances that were stated.
    """
    joints: tuple[int, ...] = ()
    """Joints whose zeros changed."""


@dataclass(frozen=True)
class NearestCause:
    """An offset of one joint, and the error that is left with it."""

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


def freed(task: Task, joints: Iterable[int]) -> System:
    """Return the fit with the zeros of some joints free, too."""
    own = [task.prior.zeros.start + j for j in joints]
    return fit(replace(task, free=task.free | dict.fromkeys(own, ZERO)))


def linear_about(
    task: Task, wide: dict[int, float], *, lengths: bool = False
) -> tuple[System, bool]:
    """Return a task, linear about a fit with much freed, and if that fit converged.

    Where distances may be wrong (``lengths``) the fit is to samples alone: a wrong one draws all
    else after it.
    """
    wider = replace(task, free=wide | task.free)
    about = fit(replace(wider, distances=()) if lengths else wider)
    return linear(wider, about.state), next_step(about) < ASTRAY


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
    """Return explanations: nothing, a wrong distance, a joint, the tool, the base, everything."""
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
) -> tuple[System, float | None, list[tuple[float, float, float]]]:
    """Return a fit with the zeros free of joints that are named, or that the evidence names.

    Then the probability that none changed, None for joints that were named; and for each joint the
    probability that it changed, the offset of its zero (0 where it did not change), and the
    standard deviation of that (where it did not change, were it alone to be found) [rad], [m].
    """
    count, zeros = len(task.prior.robot.joint_names), task.prior.zeros
    if named:
        probability, unchanged, changed = np.isin(np.arange(count), named) * 1.0, None, list(named)
        system = freed(task, changed)
        deviations = _alone(system, task)
    else:
        about, converged = linear_about(task, dict.fromkeys(range(zeros.start, zeros.stop), ZERO))
        deviations = _alone(about, task)
        sets = _sets_of_zeros(task, np.flatnonzero(deviations < UNTOLD).tolist())
        odds = probabilities(about, sets) if converged else np.zeros(len(sets))
        probability = odds @ [[j in one.joints for j in range(count)] for one in sets]
        unchanged, changed = float(odds[0]), np.flatnonzero(probability > SURE).tolist()
        system = freed(task, changed)
    offsets = np.zeros(count)
    if changed:
        own = np.array(changed) + zeros.start
        deviations[changed] = np.sqrt(np.diag(system.posterior_covariance(own)))
        moved = system.state.x[own] - task.prior.mean[own]
        offsets[changed] = np.where(deviations[changed] < UNTOLD, moved, 0)
    rows = zip(probability.tolist(), offsets.tolist(), deviations.tolist(), strict=True)
    return system, unchanged, list(rows)


def _alone(system: System, task: Task) -> np.ndarray:
    """Return the standard deviation of each joint's zero, were it alone to be found."""
    A = system.slopes[:, task.prior.zeros]
    C = replace(system, task=task).covariance(system.state.noise, gaussian=True)
    information: np.ndarray = np.sum(A * np.linalg.solve(C, A), axis=0)
    return 1 / np.sqrt(information + ZERO**-2)


def _sets_of_zeros(task: Task, joints: Sequence[int]) -> list[Explanation]:
    """Return explanations by sets of joints, of some, whose zeros changed; that of none first."""
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
    """Return in words that samples fit no arm like this one, but another; none where they do."""
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
    """Return by how much each number of the chain's geometry may have changed."""
    parameters = enumerate(task.prior.model.parameters)
    return {i: CRASHED[p.unit] for i, p in parameters if not p.of_ball}

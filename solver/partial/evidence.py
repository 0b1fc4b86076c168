"""Comparison of explanations of what changed, by their evidence.

Each explanation frees some unknowns beside the prior: N(e; 0, C + A A^T) with A the slopes by them,
times their prior standard deviations, and is averaged over these and over the noise. Each
explanation also lets all zeros vary by as little as a ball's seat seen from a metre away.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations

import numpy as np

from ..assessment import mm
from ..bayes.model import log_bayes_factor, submatrix
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
        remainder = mm(self.error)
        return f"nearest cause {self.joint} ({share}), off by {size}: with it {remainder} are left"


def fit_with_zeros(task: Task, joints: Iterable[int]) -> System:
    """Return the fit with the zeros of some joints as further unknowns."""
    indices = [task.prior.zeros.start + j for j in joints]
    return fit(replace(task, free=task.free | dict.fromkeys(indices, ZERO)))


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


def probabilities(system: System, candidates: Sequence[Explanation]) -> np.ndarray:
    """Return the probabilities of explanations by a linear system, shape (E,)."""
    zeros, noise = system.task.prior.zeros, system.task.noise
    wander = dict.fromkeys(range(zeros.start, zeros.stop), UNCHANGED)
    wandering = replace(system, task=replace(system.task, free=wander))
    widths = chain.from_iterable(explanation.widths for explanation in candidates)
    used = sorted(set(chain.from_iterable(widths)))
    lengths = np.eye(len(system.errors))[:, len(system.errors) - len(system.task.distances) :]
    A = np.hstack([system.slopes, lengths])[:, used]
    logs = np.full((len(LEVELS), len(candidates)), -np.inf)
    for level, factor in enumerate(LEVELS):
        trial = replace(noise, place=factor * noise.place)
        root, log_evidence = (
            np.linalg.cholesky(wandering.covariance(trial)),
            wandering.log_evidence(trial),
        )
        e, B = np.linalg.solve(root, system.errors), np.linalg.solve(root, A)
        M, g = B.T @ B, B.T @ e
        for i, explanation in enumerate(candidates):
            gains = [_gain(M, g, np.searchsorted(used, list(w)), w) for w in explanation.widths]
            logs[level, i] = (
                log_evidence + np.log(explanation.prior / len(gains)) + np.logaddexp.reduce(gains)
            )
    totals = np.logaddexp.reduce(logs, axis=0)
    odds: np.ndarray = np.exp(totals - totals.max())
    return odds / odds.sum()


def _gain(M: np.ndarray, g: np.ndarray, indices: np.ndarray, width: Mapping[int, float]) -> float:
    """Return the logarithm of the Bayes factor of some unknowns of these widths."""
    w = np.array(list(width.values()))
    return float(log_bayes_factor(w[:, None] * submatrix(M, indices) * w, w * g[indices]))


def explanations(task: Task) -> list[Explanation]:
    """Return the hypotheses: nothing, a wrong distance, a joint, the tool, the base, everything."""
    prior = task.prior
    joints, begin = prior.robot.joint_names, prior.zeros.start
    base = list(chain.from_iterable(task.places[k].tolist() for k in task.known))
    share = PRIOR["joint"] / len(joints)
    some = [(name, share, [begin + j]) for j, name in enumerate(joints)]
    if task.distances:
        lengths = list(range(task.size, task.size + len(task.distances)))
        some.insert(0, (LENGTHS, PRIOR[LENGTHS], lengths))
    if prior.ball[0] not in task.free:
        some.append(("tool", PRIOR["tool"], prior.ball.tolist()))
    if base:
        some.append(("base", PRIOR["base"], base))
    candidates = [Explanation(name, p, _freed(task, i, TYPICAL)) for name, p, i in some]
    everything = Explanation(EVERYTHING, PRIOR[EVERYTHING], [task.free | _geometry(task)])
    return [Explanation(NOTHING, PRIOR[NOTHING], [task.free]), *candidates, everything]


def find_zeros(
    task: Task, joints: Sequence[int]
) -> tuple[System, float | None, tuple[JointZero, ...]]:
    """Return the fit with free zeros of the named joints, or of those that the evidence names.

    Then the probability that none changed, None for joints that were named; and all joints' zeros.
    """
    names, zeros = task.prior.robot.joint_names, task.prior.zeros
    count = len(names)
    if joints:
        probability, unchanged, changed = (
            np.isin(np.arange(count), joints) * 1.0,
            None,
            list(joints),
        )
        system = fit_with_zeros(task, changed)
        deviations = zero_deviations(system, task)
    else:
        about, converged = linear_about(task, dict.fromkeys(range(zeros.start, zeros.stop), ZERO))
        deviations = zero_deviations(about, task)
        sets = _sets_of_zeros(task, np.flatnonzero(deviations < UNIDENTIFIABLE).tolist())
        odds = probabilities(about, sets) if converged else np.zeros(len(sets))
        probability = odds @ [np.isin(range(count), explanation.joints) for explanation in sets]
        unchanged, changed = float(odds[0]), np.flatnonzero(probability > SURE).tolist()
        system = fit_with_zeros(task, changed)
    offsets = np.zeros(count)
    if changed:
        indices = np.array(changed) + zeros.start
        deviations[changed] = np.sqrt(np.diag(system.posterior_covariance(indices)))
        shifts = system.state.x[indices] - task.prior.mean[indices]
        offsets[changed] = np.where(deviations[changed] < UNIDENTIFIABLE, shifts, 0)
    rows = zip(names, probability.tolist(), offsets.tolist(), deviations.tolist(), strict=True)
    return system, unchanged, tuple(JointZero(*row) for row in rows)


def zero_deviations(system: System, task: Task) -> np.ndarray:
    """Return the standard deviation of each joint's zero, if it were the only one unknown."""
    A = system.slopes[:, task.prior.zeros]
    C = replace(system, task=task).covariance(system.state.noise, gaussian=True)
    information: np.ndarray = np.sum(A * np.linalg.solve(C, A), axis=0)
    return 1 / np.sqrt(information + ZERO**-2)


def _freed(task: Task, indices: Sequence[int], widths: Sequence[float]) -> list[dict[int, float]]:
    """Return what is free in a task, and some unknowns beside, for each of their widths."""
    return [task.free | dict.fromkeys(indices, width) for width in widths]


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
            ZERO_CHANGED ** len(subset) * (1 - ZERO_CHANGED) ** (len(joints) - len(subset)),
            _freed(task, [begin + j for j in subset], WIDTHS),
            subset,
        )
        for subset in sets
    ]


def another_arm(system: System) -> tuple[str, ...]:
    """Return a warning where a different arm explains the samples far better, else nothing."""
    task, noise = system.task, system.state.noise
    with_geometry = fit(replace(task, free=task.free | _geometry(task)))
    noise_of_geometry = with_geometry.state.noise
    gain = with_geometry.log_evidence(noise_of_geometry) - system.log_evidence(noise)
    if gain < ANOTHER or noise_of_geometry.place > LESS * noise.place:
        return ()
    scatter = f"{1e3 * noise.place:.2f} mm an axis, and by {1e3 * noise_of_geometry.place:.2f}"
    return (
        f"The samples scatter by {scatter} if the whole arm may differ: is this another arm's "
        "calibration or model, or did more change?",
    )


def _geometry(task: Task) -> dict[int, float]:
    """Return the prior standard deviations of a chain all of whose numbers may have changed."""
    parameters = enumerate(task.prior.model.parameters)
    return {i: GEOMETRY_CHANGES[p.unit] for i, p in parameters if not p.of_ball}

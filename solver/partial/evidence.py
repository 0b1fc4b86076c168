"""Explanations of what changed, and their evidence.

Each explanation frees some unknowns beside the prior, and its evidence is averaged over the noise.
Each also lets all zeros vary by as little as a ball's seat seen from a metre away.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..identification.model import log_bayes_factor, probabilities
from .fit import fit, linear, next_step
from .system import System
from .task import Task

UNCHANGED = 5e-5
"""Standard deviation of the zero of a joint that did not change, from place to place [rad], [m]."""
LEVELS = np.exp(np.linspace(-1.2, 1.2, 13))
"""Factors on the noise over which the evidence is averaged."""
GEOMETRY_CHANGES = {"m": 1e-3, "rad": 3e-3}
"""Typical change of each number of the geometry after a crash [m], [rad]."""
SCATTERS = (1e-3, 3e-3, 1e-2)
"""Scatter of joints that are commanded, rounded, or have play [rad]."""
MORE = 3.0
"""Multiple of the calibration's own noise of joints from which it counts as scatter."""
LOG_PRIOR_OF_SCATTER = math.log(0.05 / len(SCATTERS))
"""Prior probability of each."""
DIVERGED = 1e-2
"""Next step beyond which a fit is taken for diverged [m]."""
NOTHING, LENGTHS, EVERYTHING = "nothing", "distance", "everything"
PRIOR = {
    NOTHING: 0.5,
    LENGTHS: 0.05,
    "joint": 0.3,
    "tool": 0.1,
    "base": 0.1,
    EVERYTHING: 0.1,
}
"""Prior probabilities; that of ``joint`` is shared among all joints."""
TYPICAL = (1e-3, 2e-2)
"""Typical changes of a joint's zero [rad], of a tool's or base's place [m]."""


@dataclass(frozen=True)
class Explanation:
    """A hypothesis on what changed."""

    name: str
    prior: float
    """Prior probability."""
    widths: dict[int, float]
    """Prior standard deviations of the unknowns that changed, beside those that the task frees.

    After the unknowns of the task, indices count the errors of the stated distances.
    """
    joints: tuple[int, ...] = ()
    """Joints whose zeros changed."""


def linear_about(
    task: Task, wide: dict[int, float], *, lengths: bool = False
) -> tuple[System, bool]:
    """Return a task linear about a fit with wider priors, and True if that fit converged.

    Where distances may be wrong (``lengths``) the fit is to samples alone: a wrong distance would
    bias everything else.
    """
    wider = task.freeing(wide)
    about = fit(replace(wider, distances=()) if lengths else wider)
    return linear(task, about.state), next_step(about) < DIVERGED


def log_evidences(system: System, candidates: Sequence[Explanation]) -> np.ndarray:
    """Return ln(p_k Z_k) of explanations by a linear system, but for a constant, shape (E,).

    With the prior p_k, the slopes A by all unknowns that any explanation frees, and the widths S_k
    of explanation k, its evidence Z_k is the sum over the noise of N(e; 0, C + A S_k^2 A^T).
    """
    task, errors = system.task, system.errors
    unchanged = replace(task, free=dict.fromkeys(task.prior.zeros, UNCHANGED))
    wandering = replace(system, task=unchanged)
    samples = len(errors) - len(task.distances)
    by_lengths = np.eye(len(errors))[:, samples:]
    slopes = np.hstack([system.slopes, by_lengths])
    widths = np.zeros((len(candidates), slopes.shape[1]))  # S_k, row by row
    for row, candidate in zip(widths, candidates, strict=True):
        free = {**task.free, **candidate.widths}
        row[[*free]] = [*free.values()]
    freed = widths.any(axis=0)
    columns = np.column_stack([errors, slopes[:, freed]])
    logs: list[np.ndarray] = []
    for factor in LEVELS.tolist():
        noise = replace(task.noise, place=factor * task.noise.place)
        white, _ = wandering.whitened(columns, noise)
        M = white.T @ white
        information, pull = M[1:, 1:], M[0, 1:]
        factors = log_bayes_factor(information, pull, widths[:, freed])
        logs.append(wandering.log_evidence(noise) + factors)
    return np.log([candidate.prior for candidate in candidates]) + np.logaddexp.reduce(
        logs
    )


def log_evidences_of_scatter(system: System) -> dict[float, float]:
    """Return ln(p Z) of all joints that scatter alike, by how much [rad].

    They compare with :func:`log_evidences`.
    """
    task = system.task
    free = {**dict.fromkeys(task.prior.zeros, UNCHANGED), **task.free}
    alike = replace(system.state, weights=np.ones_like(system.state.weights))
    wandering = replace(system, task=replace(task, free=free), state=alike)
    places = (task.noise.place * LEVELS).tolist()
    logs: dict[float, float] = {}
    for scatter in SCATTERS:
        if scatter > MORE * max(task.noise.joint, task.rows.rounding.max()):
            noise = replace(task.noise, joint=scatter)
            by_noise = [wandering.log_evidence(replace(noise, place=s)) for s in places]
            logs[scatter] = np.logaddexp.reduce(by_noise) + LOG_PRIOR_OF_SCATTER
    return logs


@dataclass(frozen=True)
class Scatter:
    """Scatter of all joints alike, while no zero changed."""

    probability: float = 0.0
    size: float = 0.0
    """Most probable one [rad]."""

    def __str__(self) -> str:
        return (
            f"All joints scatter alike, by some {1e3 * self.size:.2g} mrad "
            f"({100 * self.probability:.0f} %): are they read, not commanded, and written with all "
            "digits? Or is it another arm's calibration?"
        )


def shares_beside(
    scatters: dict[float, float], logs: np.ndarray, rounding: np.ndarray
) -> tuple[np.ndarray, Scatter]:
    """Return probabilities of explanations by ln(p Z), and that of scatters compared to them.

    Joints that read in coarse steps scatter for sure, by the deviations ``rounding`` [rad].
    """
    shares = probabilities(np.append(logs, [*scatters.values()]))
    of_logs = shares[: logs.size].reshape(logs.shape)
    of_scatters = shares[logs.size :].tolist()
    by_size = dict(zip(scatters, of_scatters, strict=True))
    size = max(by_size, key=by_size.__getitem__, default=0.0)
    scatter = Scatter(sum(of_scatters), size)
    coarsest = float(rounding.max())
    if coarsest > SCATTERS[0]:
        scatter = Scatter(1.0, coarsest)
    return of_logs, scatter


def geometry_changes(task: Task) -> dict[int, float]:
    """Return the prior standard deviations of a chain all of whose numbers may have changed."""
    parameters = enumerate(task.prior.model.parameters)
    return {i: GEOMETRY_CHANGES[p.unit] for i, p in parameters if not p.of_ball}


def explanations(task: Task) -> list[Explanation]:
    """Return the hypotheses: nothing, a wrong distance, a joint, the tool, the base, everything."""
    prior = task.prior
    joints = prior.robot.joint_names
    lengths = range(task.size, task.size + len(task.distances))
    ball = [i for i in prior.ball if i not in task.free]
    base = task.places[task.known].ravel().tolist()
    share = PRIOR["joint"] / len(joints)
    candidates = [Explanation(NOTHING, PRIOR[NOTHING], {})]
    candidates += changes_of(LENGTHS, PRIOR[LENGTHS], lengths)
    for joint, zero in zip(joints, prior.zeros, strict=True):
        candidates += changes_of(joint, share, [zero])
    candidates += changes_of("tool", PRIOR["tool"], ball)
    candidates += changes_of("base", PRIOR["base"], base)
    everything = Explanation(EVERYTHING, PRIOR[EVERYTHING], geometry_changes(task))
    return [*candidates, everything]


def changes_of(name: str, prior: float, unknowns: Sequence[int]) -> list[Explanation]:
    """Return the hypotheses that unknowns changed by what is typical; none without unknowns."""
    return [
        Explanation(name, prior / len(TYPICAL), dict.fromkeys(unknowns, width))
        for width in TYPICAL
        if unknowns
    ]

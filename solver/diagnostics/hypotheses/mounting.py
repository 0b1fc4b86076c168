"""The mounting: gravity pulls elsewhere than was said, as on a wall, a ceiling or a sloping table.

Joints give way with their load and never against it. So a direction of gravity is judged by what
elasticity with its moments explains, and by how far that comes out positive.
"""

import itertools
import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...data import Load
from ...robot import BallModel, gravity_moments
from .evidence import LinearEvidence
from .kinds import Block, NoisePrior, Parameters, silent
from .scene import Scene

ALIKE = 0.95
"""Cosine of directions that are one."""
LEAST, LARGEST, TRIALS = 0.3, 0.3, 32
"""Least noise that is tried, relative to the expected one, the largest [m], and how many."""
MOST = 150
"""Samples that are looked at."""
PLACES = {"-z": "stands upright", "+z": "hangs from the ceiling"}


def mounted(scene: Scene) -> Iterable[Block]:
    """Return blocks of other directions of gravity."""
    elastic = [effect for effect in scene.effects if effect.shared_by_type]
    if scene.zeros or scene.found or not elastic or not scene.torques.any():
        return
    said = np.array(scene.load.gravity)
    strength = float(np.linalg.norm(said))
    every = [np.array(d, float) for d in itertools.product((-1, 0, 1), repeat=3)]
    units = [d / np.linalg.norm(d) for d in every if 0 < np.count_nonzero(d) < 3]
    others = [strength * d for d in units if d @ said < ALIKE * strength]
    logs = _logs(scene, [said, *others])
    options = [" ".join(f"{v:.3g}" for v in (g + 0.0).tolist()) for g in others]
    names = [{"gravity": g.tolist(), "option": o} for g, o in zip(others, options, strict=True)]
    for name, value in zip(names, logs[1:] - logs[0], strict=True):
        yield silent(name, float(value))


def _logs(scene: Scene, directions: list[np.ndarray]) -> np.ndarray:
    """Return the logarithm of the evidence by direction of gravity, shape (C,)."""
    m, every = scene.q.shape[1], len(scene.q)
    some = np.unique(np.linspace(0, every - 1, min(every, MOST)).astype(int))
    q, N = scene.q[some], len(some)
    model = BallModel(scene.robot, [p.index for p in scene.parameters])
    still = np.concatenate([q, np.zeros((N, 2 * m))], axis=1)
    by_axes = model.linearise(model.nominal + scene.x[: model.nominal.size], still).by_joints
    columns: list[np.ndarray] = []
    along = [gravity_moments(scene.robot, q, e, scene.load.payload) for e in np.eye(3).tolist()]
    counts = [len(one.positions) for one in scene.measurements]
    measured = np.repeat([one.efforts is not None for one in scene.measurements], counts)[some]
    for gravity in directions:
        moments: np.ndarray = np.tensordot(gravity, along, axes=1)
        moments[measured, :m] = scene.torques[some][measured, :m]
        parts: list[np.ndarray] = []
        for effect in (e for e in scene.effects if e.shared_by_type):
            turns = effect.derivatives(q, moments)
            parts.append(turns * effect.typical_shift / max(float(np.mean(turns**2)) ** 0.5, 1e-6))
        columns.append((-by_axes * np.concatenate(parts, axis=1)[:, None]).reshape(3 * N, -1))
    before = scene.centres.size + len(scene.parameters)
    B = np.delete(scene.nuisances, slice(before, before + 3 * m), axis=1)
    rows = np.append(3 * some[:, None] + np.arange(3), np.arange(3 * every, len(B)))
    evidence = LinearEvidence(scene.residuals[rows], B[rows])
    nameless: list[Parameters] = [{}] * len(columns)
    block = Block(slice(0, 3 * N), np.array(columns), nameless)
    trials, base = evidence.trials(LEAST * scene.noise, LARGEST, TRIALS)
    base = base + NoisePrior(1.5 * scene.noise, scene.noise_width, below=True).log_density(trials)
    logs = evidence.log_ratios(block, trials)[:, 0] + base[:, None]
    found: list[float] = []
    for c, at in enumerate(np.argmax(logs, axis=0).tolist()):
        mean, covariance = evidence.posterior(block.only([c]), float(trials[at]))
        away = mean / np.sqrt(2 * np.diag(covariance))
        positive = (math.log(max(math.erfc(-a), 1e-30)) for a in away.tolist())
        found.append(float(logs[at, c]) + sum(positive))
    return np.array(found)


def stands(parameters: Parameters) -> str:
    """Return in words how the arm is mounted."""
    pairs = zip(parameters["gravity"], "xyz", strict=True)
    axes = [f"{'-' if g < 0 else '+'}{axis}" for g, axis in pairs if round(g)]
    how = PLACES.get(axes[0], "is mounted on a wall") if len(axes) == 1 else "is mounted on a slope"
    return f"the arm {how}: gravity pulls along {' and '.join(axes)} of its base"


def remounted(scene: Scene, parameters: Parameters) -> Scene:
    """Return the scene of an arm that is mounted so."""
    return replace(scene, load=Load(tuple(parameters["gravity"]), scene.load.payload))

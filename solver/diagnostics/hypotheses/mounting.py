"""The mounting: gravity pulls elsewhere than was said, as on a wall, a ceiling or a sloping table.

Joints give way with their load and never against it, so elasticity has to come out positive.
"""

import itertools
import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ...data import Load
from .evidence import LinearEvidence
from .kinds import Block, NoisePrior, Parameters, without_columns
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
    known = scene.robot.bodies or any(m.efforts is not None for m in scene.measurements)
    if scene.explained or not elastic or not known or not scene.torques.any():
        return
    said = np.array(scene.load.gravity)
    strength = float(np.linalg.norm(said))
    every = [np.array(d, float) for d in itertools.product((-1, 0, 1), repeat=3)]
    units = [d / np.linalg.norm(d) for d in every if 0 < np.count_nonzero(d) < 3]
    others = [strength * d for d in units if d @ said < ALIKE * strength]
    logs = _logs(scene, [said, *others])
    options = [" ".join(map("{:.3g}".format, (g + 0.0).tolist())) for g in others]
    names = [{"gravity": g.tolist(), "option": o} for g, o in zip(others, options, strict=True)]
    for name, value in zip(names, logs[1:] - logs[0], strict=True):
        yield without_columns(name, float(value))


def _logs(scene: Scene, directions: list[np.ndarray]) -> np.ndarray:
    """Return the logarithm of the evidence by direction of gravity, shape (C,)."""
    m, every = scene.q.shape[1], len(scene.q)
    some = np.unique(np.linspace(0, every - 1, min(every, MOST)).astype(int))
    of_samples = (3 * some[:, None] + np.arange(3)).ravel()
    loads = [Load(tuple(g.tolist()), scene.load.payload) for g in directions]
    scenes = [replace(scene, load=load) for load in loads]
    slopes = scene.by_readings
    columns = [one.of_effects(elastic=True, by_readings=slopes)[of_samples] for one in scenes]
    before = scene.centres.size + len(scene.parameters)
    B = np.delete(scene.nuisances, slice(before, before + 3 * m), axis=1)
    rows = np.append(of_samples, np.arange(3 * every, len(B)))
    evidence = LinearEvidence(scene.residuals[rows], B[rows])
    nameless: list[Parameters] = [{}] * len(columns)
    block = Block(slice(0, len(of_samples)), np.array(columns), nameless)
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

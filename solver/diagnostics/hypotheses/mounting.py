"""The mounting: gravity pulls elsewhere than was said, as on a wall, a ceiling or a sloping table.

Joints give way with their load and never against it, so elasticity has to come out positive.
"""

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from .evidence import LinearEvidence
from .kinds import Block, NoisePrior, Parameters, without_columns
from .samples import evenly
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
    weighed = scene.robot.bodies or any(
        m.efforts is not None for m in scene.measurements
    )
    if (
        scene.explained
        or not scene.is_elastic.any()
        or not weighed
        or not scene.torques.any()
    ):
        return
    said = np.array(scene.load.gravity)
    strength = float(np.linalg.norm(said))
    others: list[np.ndarray] = []
    for components in product((-1.0, 0.0, 1.0), repeat=3):
        direction = np.array(components)
        if 0 < np.count_nonzero(direction) < 3:
            unit = direction / np.linalg.norm(direction)
            if unit @ said < ALIKE * strength:
                others.append(strength * unit)
    as_said, *logs = _logs(scene, [said, *others])
    for gravity, log in zip(others, logs, strict=True):
        numbers = (gravity + 0.0).tolist()
        option = " ".join(f"{g:.3g}" for g in numbers)
        names = {"gravity": gravity.tolist(), "option": option}
        yield without_columns(names, log - as_said)


def _logs(scene: Scene, directions: list[np.ndarray]) -> list[float]:
    """Return the logarithm of the evidence by direction of gravity."""
    some = evenly(len(scene.q), MOST)
    of_some = (3 * some[:, None] + np.arange(3)).ravel()
    of_lengths = np.arange(len(scene.residuals))[scene.all_lengths]
    rows = np.append(of_some, of_lengths)
    elastic = np.flatnonzero(scene.is_elastic)
    columns: list[np.ndarray] = []
    for gravity in directions:
        load = replace(scene.load, gravity=tuple(gravity.tolist()))
        of_effects = scene.of_effects(scene.readings_under(load))
        columns.append(of_effects[of_some][:, elastic])
    nameless: list[Parameters] = [{}] * len(columns)
    block = Block(slice(0, len(of_some)), np.array(columns), nameless)
    first = scene.centres.size + len(scene.parameters)
    others = np.delete(scene.nuisances[rows], first + elastic, axis=1)
    evidence = LinearEvidence(scene.residuals[rows], others)
    trials, base = evidence.trials(LEAST * scene.noise, LARGEST, TRIALS)
    noise = NoisePrior(1.5 * scene.noise, scene.noise_width, below=True)
    density = base + noise.log_density(trials)
    logs_by_trial = evidence.log_ratios(block, trials)[:, 0] + density[:, None]
    logs: list[float] = []
    for c, log_by_trial in enumerate(logs_by_trial.T):
        likeliest = int(np.argmax(log_by_trial))
        mean, covariance = evidence.posterior(block.only([c]), float(trials[likeliest]))
        deviations = mean / np.sqrt(2 * np.diag(covariance))
        positive = [max(math.erfc(-d), 1e-30) for d in deviations.tolist()]
        logs.append(float(log_by_trial[likeliest]) + sum(map(math.log, positive)))
    return logs


def stands(parameters: Parameters) -> str:
    """Return in words how the arm is mounted."""
    pairs = zip(parameters["gravity"], "xyz", strict=True)
    axes = [f"{'-' if g < 0 else '+'}{axis}" for g, axis in pairs if round(g)]
    how = (
        PLACES.get(axes[0], "is mounted on a wall")
        if len(axes) == 1
        else "is mounted on a slope"
    )
    return f"the arm {how}: gravity pulls along {' and '.join(axes)} of its base"


def remounted(scene: Scene, parameters: Parameters) -> Scene:
    """Return the scene of an arm that is mounted so."""
    return replace(
        scene, load=replace(scene.load, gravity=tuple(parameters["gravity"]))
    )

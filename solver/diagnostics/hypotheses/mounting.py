"""The mounting: gravity pulls elsewhere than was said, as on a wall, a ceiling or a sloping table.

Joints give way with their load and never against it, so elasticity has to come out positive.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from ...identification.data import as_point
from .evidence import LinearEvidence
from .kinds import Block, NoisePrior, Parameters, without_columns
from .samples import evenly
from .scene import Scene

Gravity = tuple[float, float, float]
"""In the axes of the robot's base [m/s^2]."""
ALIKE = 0.95
"""Cosine of directions that are one."""
LEAST = 0.3
"""Least noise that is tried, relative to the expected one."""
LARGEST = 0.3
"""The largest noise that is tried [m]."""
TRIALS = 32
"""Noises that are tried."""
MOST = 150
"""Samples that are looked at."""
PLACES = {"-z": "stands upright", "+z": "hangs from the ceiling"}


def mounted(scene: Scene) -> Iterable[Block]:
    """Return blocks of other directions of gravity."""
    if scene.explained or not _is_bent(scene):
        return
    others = [*_other_directions(np.array(scene.load.gravity))]
    as_said, *logs = _logs(scene, [scene.load.gravity, *others])
    for gravity, log in zip(others, logs, strict=True):
        names = {
            "gravity": list(gravity),
            "option": " ".join(f"{g:.3g}" for g in gravity),
        }
        yield without_columns(names, log - as_said)


def _is_bent(scene: Scene) -> bool:
    """Tell whether an arm of known weight gives way under it."""
    has_efforts = any(m.efforts is not None for m in scene.measurements)
    if not (scene.robot.bodies or has_efforts):
        return False
    is_loaded = scene.loaded_samples.moments.any()
    return bool(is_loaded and scene.is_elastic.any())


def _other_directions(said: np.ndarray) -> Iterator[Gravity]:
    """Yield gravity along other axes, and between two of them, with the strength of ``said``."""
    strength = math.hypot(*said)
    for direction in product((-1.0, 0.0, 1.0), repeat=3):
        axes = np.count_nonzero(direction)
        gravity = np.array(direction) * (strength / max(axes, 1) ** 0.5)
        if axes in (1, 2) and gravity @ said < ALIKE * strength**2:
            yield as_point(gravity)


def _logs(
    scene: Scene,
    directions: Sequence[Gravity],
) -> Iterator[float]:
    """Yield the logarithm of the evidence by direction of gravity."""
    evidence, block = _elasticity(scene, directions)
    sigma, log_likelihood = evidence.trials(LEAST * scene.noise, LARGEST, TRIALS)
    noise = NoisePrior(1.5 * scene.noise, scene.noise_width, below=True)
    density = log_likelihood + noise.log_density(sigma)
    by_trial = evidence.log_ratios(block, sigma)[:, 0] + density[:, None]
    for c, likeliest in enumerate(np.argmax(by_trial, axis=0)):
        estimate = evidence.posterior(block.only([c]), float(sigma[likeliest]))
        yield float(by_trial[likeliest, c]) + _log_positive(*estimate)


def _elasticity(
    scene: Scene,
    directions: Sequence[Gravity],
) -> tuple[LinearEvidence, Block]:
    """Return the evidence of some samples of a stiff arm, and its elasticity by direction."""
    some = evenly(len(scene.q), MOST)
    rows_of_samples = 3 * some[:, None] + np.arange(3)
    of_some = rows_of_samples.ravel()
    of_lengths = scene.all_lengths.start + np.arange(len(scene.known))
    rows = np.append(of_some, of_lengths)
    elastic = np.flatnonzero(scene.is_elastic)
    loads = [replace(scene.load, gravity=gravity) for gravity in directions]
    of_loads = [scene.of_effects(scene.samples_under(load)) for load in loads]
    columns = np.array(of_loads)[:, of_some][:, :, elastic]
    nameless: list[Parameters] = [{}] * len(columns)
    block = Block(slice(0, len(of_some)), columns, nameless)
    first = scene.centres.size + len(scene.parameters)
    others = np.delete(scene.nuisances[rows], first + elastic, axis=1)
    return LinearEvidence(scene.residuals[rows], others), block


def _log_positive(
    mean: np.ndarray,
    covariance: np.ndarray,
) -> float:
    """Return the sum of ln 2 P(u > 0), with each unknown u a Gaussian by itself."""
    ratios = mean / (2**0.5 * np.sqrt(np.diag(covariance)))
    doubled = [math.erfc(-ratio) for ratio in ratios.tolist()]
    return sum(math.log(max(share, 1e-30)) for share in doubled)


def stands(parameters: Parameters) -> str:
    """Return in words how the arm is mounted."""
    pairs = zip(parameters["gravity"], "xyz", strict=True)
    axes = [f"{'-' if g < 0 else '+'}{axis}" for g, axis in pairs if round(g)]
    directions = " and ".join(axes)
    how = "is mounted on a slope"
    if len(axes) == 1:
        how = PLACES.get(directions, "is mounted on a wall")
    return f"the arm {how}: gravity pulls along {directions} of its base"


def remounted(
    scene: Scene,
    parameters: Parameters,
) -> Scene:
    """Return the scene of an arm that is mounted so."""
    load = replace(scene.load, gravity=tuple(parameters["gravity"]))
    return replace(scene, load=load)

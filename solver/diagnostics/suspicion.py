"""What if: a suspected flaw put into perfect data, and laid beside what was observed.

The recordings are a linear model about a robust fit (:mod:`.explain`). A flaw of some size changes
its residuals r by a known shift s. A fit to perfect data with that flaw leaves, with nuisances B in
the widths of their priors and the noise sigma::

    p = s - B (B^T B + sigma^2 I)^-1 B^T s

which is compared with what the same fit leaves of the recordings.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from ..data import STANDARD_LOAD, Measurement
from ..robot import Robot
from .configurations import known_distances
from .explain import scene_loaded
from .hypotheses import (
    INDEPENDENT,
    KINDS,
    SCATTER,
    Candidate,
    Comparison,
    Flaw,
    Kind,
    Parameters,
    Scene,
    largest_shift,
    noise_of_size,
    of_size,
    these,
    unknowns_per_size,
)
from .inspection import Given
from .robust_fit import RigidModel

CLEAR, ALIKE = 3.0, 5.0
"""Logarithms of odds: from the first a flaw is clearly there; below the second two are as good."""
SEEN = 9.0
"""Chi-square of the pattern of a flaw that can be seen."""
TRIED = "whatif"
"""Name of the explanation that is the flaw at its size."""
RIVALS = 3
"""Other explanations that are listed at most."""

Answer = Literal["yes", "no", "size", "unseen"]


@dataclass(frozen=True)
class WhatIf:
    """A suspected flaw beside what was observed."""

    fault: str
    cause: str
    """Name of the explanation that it is compared by."""
    answer: Answer
    """``size``: the pattern is there, of another size. ``unseen``: a fit hides so small a flaw."""
    where: Parameters
    """Joint, placement and sample, as far as it has them."""
    size: float
    """[m, rad, share]."""
    unit: str
    size_observed: float | None
    """Size that fits the recordings best; None where samples scatter each its own way."""
    deviation: float | None
    """Standard deviation of the latter."""
    moves: float
    """Largest shift of the ball by it [m]."""
    pattern: float
    """What a fit to perfect data with it leaves, root mean square at the ball [m]."""
    observed: float
    """What the same fit leaves of the recordings [m]."""
    remains: float
    """What it leaves of them once the flaw is taken out [m]."""
    alike: float | None
    """Cosine of the two patterns; None for noise, which has no pattern."""
    log_odds: float
    """Logarithm of its odds against recordings with nothing wrong."""
    postures: int
    rivals: tuple[tuple[str, float], ...]
    """Other explanations that fit better or as well, and the logarithm of their odds against it."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        rivals = [{"text": text, "log_odds": odds} for text, odds in self.rivals]
        return {**asdict(self), "where": dict(self.where), "rivals": rivals}


def what_if(
    robot: Robot,
    measurements: Sequence[Measurement],
    flaw: Flaw,
    given: Given | None = None,
    *,
    zeros: bool = False,
    repeatability: float | None = None,
) -> WhatIf:
    """Lay a suspected flaw beside recordings; see :func:`.inspect_all` for the other arguments.

    Raises:
        FlawError: These recordings can have none of it.
        KnownError: A known distance names a socket that is not there.
    """
    given, model = given or Given(), RigidModel(robot, zeros=zeros)
    known = known_distances(measurements, given.known, given.deviation)
    scene = scene_loaded(model, measurements, known, given.load, repeatability)
    free = Comparison(scene, flaw.possible(scene)).candidates
    likeliest = max(free, key=lambda candidate: candidate.log_evidence)
    estimate = _estimate(scene, likeliest)
    size = flaw.size or estimate.size or scene.noise
    best = _best_of_each(scene, _of_size(scene, likeliest, estimate.direction, size))
    tried, sound = best.pop(TRIED), best.pop("sound")
    for kind in flaw.kinds:
        best.pop(kind.name, None)
    pattern, remaining = _pattern(scene, tried), _left(scene, scene.residuals)
    rows, after = _rows_of(scene, tried), tried.after()
    odds = {name: c.log_evidence - tried.log_evidence for name, c in best.items()}
    least = max(-ALIKE, sound.log_evidence + CLEAR - tried.log_evidence)
    listed = sorted((name for name in odds if odds[name] > least), key=lambda n: -odds[n])
    norms = float(np.linalg.norm(pattern[rows]) * np.linalg.norm(remaining[rows]))
    return WhatIf(
        fault=flaw.text,
        cause=likeliest.kind.name,
        answer=_answer(tried, sound, likeliest, pattern, list(odds.values())),
        where=likeliest.block.parameters[0],
        size=size,
        unit=flaw.unit,
        size_observed=estimate.size,
        deviation=estimate.deviation,
        moves=largest_shift(scene, tried.block.rows, _shift(tried)),
        pattern=_root_mean_square(pattern[rows]),
        observed=_root_mean_square(remaining[rows]),
        remains=_root_mean_square(_left(after, after.residuals)[rows]),
        alike=float(pattern[rows] @ remaining[rows]) / norms if norms else None,
        log_odds=tried.log_evidence - sound.log_evidence,
        postures=len(scene.q),
        rivals=tuple((best[name].hypothesis().text, odds[name]) for name in listed[:RIVALS]),
    )


@dataclass(frozen=True)
class _Estimate:
    """What recordings say of a flaw of any size."""

    direction: np.ndarray
    """Of its unknowns, a unit vector."""
    size: float | None = None
    deviation: float | None = None


def _estimate(scene: Scene, likeliest: Candidate) -> _Estimate:
    """Return the most probable size of a candidate, and the direction of its unknowns."""
    block, count = likeliest.block, likeliest.block.unknowns
    if likeliest.kind.noise is not None:
        return _Estimate(np.zeros(0), likeliest.sigma)
    if not 0 < count <= SCATTER:
        return _Estimate(np.zeros(count))
    mean, covariance = likeliest.evidence.posterior(block, likeliest.sigma)
    amount = float(np.linalg.norm(mean))
    direction = mean / amount if amount else np.eye(count)[0]
    per_size = unknowns_per_size(scene, likeliest.kind, block, direction)
    deviation = float(direction @ covariance @ direction) ** 0.5
    return _Estimate(direction, amount / per_size, deviation / per_size)


def _of_size(scene: Scene, likeliest: Candidate, direction: np.ndarray, size: float) -> Kind:
    """Return the explanation by a candidate of one size, as probable as sound recordings."""
    kind = replace(likeliest.kind, name=TRIED, prior=1.0, separate=False)
    block = of_size(scene, kind, likeliest.block, direction, size)
    return replace(kind, blocks=partial(these, [block]), noise=noise_of_size(kind, size))


def _best_of_each(scene: Scene, tried: Kind) -> dict[str, Candidate]:
    """Return the most probable candidate of each explanation, and of the one that is tried."""
    candidates = Comparison(scene, (*KINDS, tried)).candidates
    candidates.sort(key=lambda candidate: candidate.log_evidence)
    return {candidate.kind.name: candidate for candidate in candidates}


def _answer(
    tried: Candidate,
    sound: Candidate,
    likeliest: Candidate,
    pattern: np.ndarray,
    odds: Sequence[float],
) -> Answer:
    """Return whether a flaw of its size explains the recordings, by the odds of all others."""
    strongest = tried.log_evidence + max(odds)
    evidence_of_size = tried.log_evidence
    of_any_size = likeliest.log_evidence - float(np.log(likeliest.kind.prior))
    clear = sound.log_evidence + CLEAR
    if evidence_of_size > clear and evidence_of_size + ALIKE > max(strongest, of_any_size):
        return "yes"
    if of_any_size > clear and of_any_size + ALIKE > strongest:
        return "size"
    chi_square = INDEPENDENT * float(pattern @ pattern) / likeliest.sigma**2
    return "unseen" if tried.block.fixed and chi_square < SEEN else "no"


def _shift(candidate: Candidate) -> np.ndarray:
    """Return by how much a candidate without unknowns changes its rows of the residuals [m]."""
    block = candidate.block
    return block.columns[0, :, block.unknowns :].sum(axis=1)


def _pattern(scene: Scene, candidate: Candidate) -> np.ndarray:
    """Return what a fit to perfect data with a flaw leaves, shape (3 N + K,) [m]."""
    flaw = np.zeros(len(scene.residuals))
    flaw[candidate.block.rows] = _shift(candidate)
    return _left(scene, flaw)


def _left(scene: Scene, residuals: np.ndarray) -> np.ndarray:
    """Return what a fit of the nuisances leaves of residuals, shape (3 N + K,) [m]."""
    B = scene.nuisances
    information = B.T @ B + scene.noise**2 * np.eye(B.shape[1])
    return residuals - B @ np.linalg.solve(information, B.T @ residuals)


def _rows_of(scene: Scene, candidate: Candidate) -> slice:
    """Return the rows of the residuals on which a candidate shows: of samples, or of distances."""
    if "samples" in candidate.residuals:
        return scene.all_samples
    return slice(scene.all_samples.stop, len(scene.residuals))


def _root_mean_square(rows: np.ndarray) -> float:
    """Return the root mean square of residuals, by samples of three rows [m]."""
    count = len(rows) / 3 if len(rows) % 3 == 0 else len(rows)
    return (float(rows @ rows) / max(count, 1)) ** 0.5


def shift_by(
    robot: Robot, measured: Measurement, flaw: Flaw, generator: np.random.Generator
) -> np.ndarray:
    """Return by how much a flaw moves the balls as they were recorded, shape (N, 3) [m].

    Of several joints it takes one amid the chain; what is free besides is random.
    """
    scene = scene_loaded(RigidModel(robot), [measured], (), STANDARD_LOAD, None)
    kind = flaw.possible(scene)[0]
    (block, *_) = kind.blocks(scene)
    single = block.only([len(block.parameters) // 2])
    direction: np.ndarray = generator.normal(size=single.unknowns)
    direction = direction / float(np.linalg.norm(direction))
    changed = of_size(scene, kind, single, direction, flaw.size or 0.0)
    shift = np.zeros(3 * len(scene.q))
    shift[changed.rows] = changed.columns[0].sum(axis=1)
    ordered = np.zeros((len(scene.q), 3))
    ordered[measured.order] = shift.reshape(-1, 3)
    return ordered

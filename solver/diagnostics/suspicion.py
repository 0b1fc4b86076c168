"""What if: a suspected flaw put into perfect data, and laid beside what was observed.

The recordings are a linear model about a robust fit (:mod:`.scene_fit`). A flaw of some size
changes its residuals r by a known shift s. A fit to perfect data with that flaw leaves, with
nuisances B in the widths of their priors and the noise sigma::

    p = s - B (B^T B + sigma^2 I)^-1 B^T s

which is compared with what the same fit leaves of the recordings.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Literal

import numpy as np

from ..identification.data import Measurement
from ..identification.robot import Robot
from .hypotheses import (
    DISTANCE_WEIGHT,
    INDEPENDENT,
    KINDS,
    Block,
    Candidate,
    Comparison,
    Flaw,
    Kind,
    Noise,
    NoisePrior,
    Parameters,
    Scene,
    likeliest_of,
)
from .robust_fit import RigidModel
from .scene_fit import Given, scene_of

CLEAR = 3.0
"""Logarithm of the odds from which a flaw is clearly there."""
ALIKE = 5.0
"""Logarithm of the odds below which two flaws are as good."""
SEEN = 9.0
"""Chi-square of the pattern of a flaw that can be seen."""
TRIED = "whatif"
"""Name of the explanation that is the flaw at its size."""
SCATTER = 9
"""Explanations of more unknowns than this say how far samples scatter, each its own way."""
SIZE_WIDTH = 0.1
"""Standard deviation of the logarithm of a noise whose size is told."""
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
        return {
            **asdict(self),
            "where": dict(self.where),
            "rivals": rivals,
        }


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
    model = RigidModel(robot, zeros=zeros)
    scene = scene_of(model, measurements, given or Given(), repeatability)
    likeliest = likeliest_of(Comparison(scene, flaw.possible(scene)).candidates)
    estimate = _estimate(likeliest)
    size = flaw.size or estimate.size or scene.noise
    best = _best_of_each(scene, _of_size(likeliest, estimate.direction, size))
    tried, sound = best.pop(TRIED), best.pop("sound")
    for kind in flaw.kinds:
        best.pop(kind.name, None)
    rivals = sorted(best.values(), key=lambda rival: -rival.log_evidence)
    least = max(tried.log_evidence - ALIKE, sound.log_evidence + CLEAR)
    listed = [rival for rival in rivals[:RIVALS] if rival.log_evidence > least]
    rows = scene.all_lengths
    if "samples" in tried.residuals:
        rows = scene.all_samples
    pattern = scene.left_of(scene.in_rows(tried.block.rows, tried.shift))
    shown = pattern[rows]
    observed = scene.left_of(scene.residuals)[rows]
    after = tried.after()
    remains = after.left_of(after.residuals)[rows]
    norms = float(np.linalg.norm(shown) * np.linalg.norm(observed))
    return WhatIf(
        fault=flaw.text,
        cause=likeliest.kind.name,
        answer=_answer(tried, sound, likeliest, rivals[0], pattern),
        where=likeliest.block.parameters[0],
        size=size,
        unit=flaw.unit,
        size_observed=estimate.size,
        deviation=estimate.deviation,
        moves=_largest_shift(scene, tried.block.rows, tried.shift),
        pattern=_root_mean_square(shown),
        observed=_root_mean_square(observed),
        remains=_root_mean_square(remains),
        alike=float(shown @ observed) / norms if norms else None,
        log_odds=tried.log_evidence - sound.log_evidence,
        postures=len(scene.q),
        rivals=tuple(
            (rival.hypothesis().text, rival.log_evidence - tried.log_evidence)
            for rival in listed
        ),
    )


@dataclass(frozen=True)
class _Estimate:
    """What recordings say of a flaw of any size."""

    direction: np.ndarray
    """Of its unknowns, a unit vector."""
    size: float | None = None
    deviation: float | None = None


def _estimate(likeliest: Candidate) -> _Estimate:
    """Return the most probable size of a candidate, and the direction of its unknowns."""
    scene, block = likeliest.scene, likeliest.block
    if likeliest.kind.noise is not None:
        return _Estimate(np.zeros(0), likeliest.sigma)
    if not 0 < block.unknowns <= SCATTER:
        return _Estimate(np.zeros(block.unknowns))
    mean, covariance = likeliest.evidence.posterior(block, likeliest.sigma)
    amount = float(np.linalg.norm(mean))
    direction = mean / amount if amount else np.eye(block.unknowns)[0]
    per_size = _unknowns_per_size(scene, likeliest.kind, block, direction)
    deviation = float(direction @ covariance @ direction) ** 0.5
    return _Estimate(direction, amount / per_size, deviation / per_size)


def _of_size(
    likeliest: Candidate,
    direction: np.ndarray,
    size: float,
) -> Kind:
    """Return the explanation by a candidate of one size, as probable as sound recordings."""
    kind = replace(likeliest.kind, name=TRIED, prior=1.0, separate=False)
    if kind.noise is not None:
        kind = replace(kind, noise=_noise_of_size(size))
    scene, block = likeliest.scene, likeliest.block
    of_size = _block_of_size(scene, kind, block, direction, size)
    return kind.only([of_size])


def _noise_of_size(size: float) -> Noise:
    return lambda _: NoisePrior(size, SIZE_WIDTH)


def _block_of_size(
    scene: Scene,
    kind: Kind,
    block: Block,
    direction: np.ndarray,
    size: float,
) -> Block:
    """Return a block of a single candidate with a size [m, rad, share] along a direction."""
    if block.unknowns > SCATTER:
        return replace(block, widths=(size,))
    if not block.unknowns:
        return block
    amount = size * _unknowns_per_size(scene, kind, block, direction)
    shift = block.columns @ (amount * direction)
    return Block(block.rows, shift[..., None], block.parameters, fixed=True)


def _unknowns_per_size(
    scene: Scene,
    kind: Kind,
    block: Block,
    direction: np.ndarray,
) -> float:
    """Return how large a candidate's unknowns are along a direction, for each unit of its size."""
    if not kind.at_ball:
        return 1.0
    shift = _largest_shift(scene, block.rows, block.columns[0] @ direction)
    return 1 / max(shift, 1e-12)


def _largest_shift(
    scene: Scene,
    rows: slice,
    shift: np.ndarray,
) -> float:
    """Return how far a change of some rows of the residuals moves a ball, or a distance, [m]."""
    residuals = scene.in_rows(rows, shift)
    of_balls = residuals[scene.all_samples].reshape(-1, 3)
    of_distances = residuals[scene.all_lengths] / DISTANCE_WEIGHT
    sizes = np.append(np.linalg.norm(of_balls, axis=1), np.abs(of_distances))
    return float(sizes.max())


def _best_of_each(scene: Scene, tried: Kind) -> dict[str, Candidate]:
    """Return the most probable candidate of each explanation, and of the one that is tried."""
    candidates = Comparison(scene, (*KINDS, tried)).candidates
    candidates.sort(key=lambda candidate: candidate.log_evidence)
    return {candidate.kind.name: candidate for candidate in candidates}


def _answer(
    tried: Candidate,
    sound: Candidate,
    likeliest: Candidate,
    rival: Candidate,
    pattern: np.ndarray,
) -> Answer:
    """Return whether a flaw of its size explains the recordings, beside its best rival."""
    of_any_size = likeliest.log_evidence - float(np.log(likeliest.kind.prior))
    clear = sound.log_evidence + CLEAR
    others = max(rival.log_evidence, of_any_size)
    if tried.log_evidence > clear and tried.log_evidence + ALIKE > others:
        return "yes"
    if of_any_size > clear and of_any_size + ALIKE > rival.log_evidence:
        return "size"
    chi_square = INDEPENDENT * float(pattern @ pattern) / likeliest.sigma**2
    return "unseen" if tried.block.fixed and chi_square < SEEN else "no"


def _root_mean_square(rows: np.ndarray) -> float:
    """Return the root mean square of residuals, by samples of three rows [m]."""
    count = len(rows) / 3 if len(rows) % 3 == 0 else len(rows)
    return (float(rows @ rows) / max(count, 1)) ** 0.5


def shift_by(
    robot: Robot,
    measured: Measurement,
    flaw: Flaw,
    generator: np.random.Generator,
) -> np.ndarray:
    """Return by how much a flaw moves the balls as they were recorded, shape (N, 3) [m].

    Of several joints it takes one amid the chain; what is free besides is random.
    """
    scene = scene_of(RigidModel(robot), [measured], Given(), None)
    kind, *_ = flaw.possible(scene)
    block, *_ = kind.blocks(scene)
    single = block.only([len(block.parameters) // 2])
    direction: np.ndarray = generator.normal(size=single.unknowns)
    direction = direction / float(np.linalg.norm(direction))
    changed = _block_of_size(scene, kind, single, direction, flaw.size or 0.0)
    shift = scene.in_rows(changed.rows, changed.columns[0].sum(axis=1))
    return measured.as_recorded(shift[scene.all_samples].reshape(-1, 3))

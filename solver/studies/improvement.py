"""Improvement by a calibration: errors of distances by the nominal model, and by what is loaded.

The arm itself is unknown, so it is drawn from what is known of it: from the posterior of the
samples trained on, updated by those held out. For each draw the errors of both models follow.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from ..identification.data import CALIPER_DEVIATION, Load, Measurement, Samples
from ..identification.inference import Posterior
from ..identification.model import Gaussian
from ..identification.robot import workspace
from ..results import Better, Improvement, Interval
from .base_length import BaseLength, SocketMean
from .predicted_errors import neighbourhoods
from .projections import (
    basis_of,
    evenly,
    outside,
    pair_lengths,
    rows_of,
    shifts_of,
)
from .uncertainty import covariance_of, distance_slopes
from .whitening import whitened

Points = Callable[[np.ndarray], np.ndarray]
"""Ball centres that a model predicts for joint positions, (N, m) to (N, 3) [m]."""
DRAWS, PAIRS, MOST = 400, 400, 90
"""Draws of the arm, random distances in the workspace, and samples of a held-out placement."""
INDEPENDENT = 0.5
"""Share of the evidence of held-out samples that counts: errors of poses alike are alike."""
ROUNDING = 1e-9
"""Of a correlation."""


@dataclass(frozen=True)
class Models:
    """The models that are compared."""

    nominal: Points
    """With its ball refitted."""
    loaded: Points
    """``calibrated.urdf``."""
    corrected: bool
    """True if the full model, which corrects joint positions, is another one."""


def better_than_nominal(
    posterior: Posterior,
    load: Load,
    models: Models,
    recorded: Sequence[np.ndarray],
    held_out: Sequence[Measurement] = (),
) -> Better:
    """Return the errors of distances before and now, and the probability that they are smaller.

    Args:
        posterior: What the samples trained on tell of the arm.
        load: Load of the joints while recording.
        models: The models to compare.
        recorded: Joint positions of each placement, shape (N, m) [rad].
        held_out: Placements whose samples and distances bear on the arm, too.
    """
    robot = posterior.model.robot
    change = _updated(posterior, load, held_out)
    generator = np.random.default_rng(0)
    white = generator.standard_normal((DRAWS, len(change.root)))
    draws = change.mean + white @ change.root.T

    def improvement(q: np.ndarray) -> Improvement:
        poses = load.at(robot, q)
        lengths, slopes = distance_slopes(posterior.model, posterior.x, poses)
        truths = lengths + draws @ slopes.T
        return _improvement(models, q, lengths, truths)

    anywhere = workspace(robot, 2 * PAIRS)
    places = map(improvement, neighbourhoods(robot, recorded))
    worst = max(places, key=lambda place: place.now.value, default=None)
    return Better(
        workspace=improvement(anywhere),
        recorded_places=worst,
    )


def _improvement(
    models: Models,
    q: np.ndarray,
    lengths: np.ndarray,
    truths: np.ndarray,
) -> Improvement:
    """Return the errors of distances between pairs of poses, by draws of them (K, N) [m].

    Each draw is of the arm and, with replacement, of the pairs, which are a sample as well.
    """
    generator = np.random.default_rng(1)
    _, count = truths.shape
    pairs = generator.integers(count, size=truths.shape)
    truths_of_pairs = np.take_along_axis(truths, pairs, axis=1)

    def errors(distances: np.ndarray) -> np.ndarray:
        differences = distances[pairs] - truths_of_pairs
        return np.median(np.abs(differences), axis=1)

    nominal = pair_lengths(models.nominal(q))
    loaded = pair_lengths(models.loaded(q))
    before = errors(nominal)
    now = errors(loaded)
    improvement = Improvement(
        before=_interval(before),
        now=_interval(now),
        probability=_share(now < before),
    )
    if not models.corrected:
        return improvement
    corrected = errors(lengths)
    return replace(
        improvement,
        corrected=_interval(corrected),
        corrected_probability=_share(corrected < before),
    )


def _share(better: np.ndarray) -> float:
    """Return a probability by draws, which is never 0 or 1."""
    count = float(np.sum(better))
    return (count + 0.5) / (len(better) + 1)


def _interval(errors: np.ndarray) -> Interval:
    levels = np.quantile(errors, (0.16, 0.5, 0.84))
    low, middle, high = levels.tolist()
    return Interval(value=middle, low=low, high=high)


def _updated(
    posterior: Posterior,
    load: Load,
    held_out: Sequence[Measurement],
) -> Gaussian:
    """Return the change of the unknowns by what was held out.

    With Sigma = L L^T the covariance of the unknowns, A the whitened derivatives of what was held
    out, and r its errors,

        L' = L (1 + L^T A^T A L)^-1/2        mean = -L' L'^T A^T r        Sigma' = f L' L'^T

    where f, at least 1, is by how much r^T r - |L'^T A^T r|^2 is larger than expected: a model that
    held-out samples contradict is known less well than it seems.
    """
    root = _root(covariance_of(posterior))
    rows: list[np.ndarray] = []
    for measured in held_out:
        if measured.kind == "sockets":
            rows += _evidence(posterior, load, measured)
    if not rows:
        return Gaussian(np.zeros(len(root)), root)
    evidence = np.concatenate(rows)
    r = evidence[:, 0]
    A = evidence[:, 1:]
    slopes = A @ root
    precision = np.eye(len(root)) + slopes.T @ slopes
    L = np.linalg.cholesky(precision)
    root = np.linalg.solve(L, root.T).T
    along = root.T @ (A.T @ r)
    squares = float(r @ r - along @ along)
    expected = INDEPENDENT * len(r)
    f = max(squares / expected, 1.0)
    return Gaussian(-root @ along, f**0.5 * root)


def _root(covariance: np.ndarray) -> np.ndarray:
    """Return L with L L^T the covariance, but for rounding."""
    variances = np.diag(covariance).clip(min=0)
    deviation = np.sqrt(variances)
    scale = np.where(deviation > 0, deviation, 1.0)
    correlation = covariance / np.outer(scale, scale)
    rounding = ROUNDING * np.eye(len(scale))
    L = np.linalg.cholesky(correlation + rounding)
    return deviation[:, None] * L


def _evidence(
    posterior: Posterior,
    load: Load,
    measured: Measurement,
) -> Iterator[np.ndarray]:
    """Yield what a placement tells: the scatter in each socket, and its distance.

    They are rows [r, A] of variance 1, shape (R, 1 + size): errors, and their derivatives by the
    unknowns.
    """
    means: list[SocketMean] = []
    for samples in load.by_socket(posterior.model.robot, measured):
        mean = SocketMean.of(posterior, samples)
        means.append(mean)
        some = evenly(len(samples.q), MOST // 2)
        if len(some) > 1:
            yield _scatter(posterior, samples.only(some), mean.centre)
    if measured.has_distance:
        length = BaseLength.of(*means[:2])
        error = length.value - measured.distance
        row = np.append(error, length.slope)
        caliper = measured.distance_deviation or CALIPER_DEVIATION
        variance = caliper**2 + length.noise
        yield row[None] / variance**0.5


def _scatter(
    posterior: Posterior,
    samples: Samples,
    centre: np.ndarray,
) -> np.ndarray:
    """Return what samples of a socket tell about its centre, as far as they are independent.

    With L L^T the noise of a sample, they are L^-1 (p - c) and L^-1 J without what another centre
    would do to them.
    """
    points, J, by_joints = posterior.linearise(samples)
    columns = np.dstack([shifts_of(points), points - centre, J])
    white = whitened(posterior, by_joints, columns)
    rows = rows_of(white)
    Q = basis_of(rows[:, :3])
    return INDEPENDENT**0.5 * outside(rows[:, 3:], Q)

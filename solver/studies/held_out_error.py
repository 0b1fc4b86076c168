"""The held-out error in three: noise, want of data, and what is not in the model.

With Q an orthonormal basis of the samples' deviations from their socket's mean, the errors at
places that a fit has not seen are Gaussian with the covariance

    Q^T (J Sigma J^T + n^2 C + m^2 K) Q

by the posterior of the unknowns, by noise C of the fit's shape, and by what the model lacks: an
error K that samples have in common whose joints stand alike, or one whose joint is pushed alike.
The evidence of the errors, over all K and over n and m, tells how large n and m are. An effect that
changes from each sample to the next is no different from noise, and counts as noise.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ..identification.data import Samples, joined
from ..identification.inference import Posterior
from ..identification.model import probabilities
from ..results import ErrorParts, Fit, Interval, Measurements, Study
from .evidence import NOISES, Background
from .projections import basis_of, block_diagonal, kernels, rows_of
from .uncertainty import covariance_of

MOST = 72
"""Held-out samples that are looked at, at most."""
TURNS = (0.3, 1.0)
"""Lengths in the angle of one joint, over which its error is alike [rad]."""
LENGTHS = (0.6, 1.5)
"""Lengths in joint space, over which all errors are alike [rad]."""
SIZES = np.append(0.0, np.geomspace(0.05, 4.0, 24) ** 2)
"""m^2, by the mean square error that is expected without; the first has half of the prior."""
LEVELS = (0.025, 0.975)
LEAST_SHARE = 1e-12
"""Smaller shares of the largest eigenvalue of a covariance are rounding."""


UnseenSockets = Sequence[tuple[Posterior, Sequence[Samples]]]
"""Samples in sockets, with the posteriors of fits that have not seen them."""


def error_parts(unseen: UnseenSockets) -> ErrorParts | None:
    """Return the parts of the error at held-out sockets; None for too few samples.

    Their expected squares are n^2 tr Q^T C Q, tr Q^T J Sigma J^T Q, and m^2 times the sum of both
    for n = 1. They are scaled to sum to the square of the error that was found.
    """
    thinned = _thinned(unseen)
    if not thinned:
        return None
    parts: list[tuple[np.ndarray, ...]] = []
    wants: list[np.ndarray] = []
    for posterior, seats in thinned:
        balls, J, slopes = posterior.linearise(joined(seats))
        rows = rows_of(J)
        wants.append(rows @ covariance_of(posterior) @ rows.T)
        parts.append((balls, slopes, posterior.noise.as_gaussian(slopes)))
    points, by_joints, noises = map(np.concatenate, zip(*parts, strict=True))
    sockets = [part for _, seats in thinned for part in seats]
    across = _contrasts([len(part.q) for part in sockets]).T
    want = across @ block_diagonal(wants) @ across.T
    noise = across @ block_diagonal(noises) @ across.T
    roots = [across @ F for F in _roots(joined(sockets), by_joints)]
    errors = across @ points.ravel()
    weights = _weights(want, noise, roots, errors)
    by_size = weights.sum(axis=(0, 1))
    of_noise = weights.sum(axis=(0, 2)) @ NOISES * np.trace(noise)
    of_want = np.trace(want)
    expected = of_want + np.trace(noise)
    of_model = by_size @ SIZES * expected
    square = float(errors @ errors)
    scale = square / (of_noise + of_want + of_model)
    low, high = np.searchsorted(np.cumsum(by_size), LEVELS)

    def error(part: float) -> float:
        """Return a part of the expected square as an error of a sample [m]."""
        return float(min(scale * part, square) / len(points)) ** 0.5

    return ErrorParts(
        error=(square / len(points)) ** 0.5,
        noise=error(of_noise),
        want_of_data=error(of_want),
        not_in_model=Interval(
            value=error(of_model),
            low=error(expected * SIZES[low]),
            high=error(expected * SIZES[high]),
        ),
    )


def _thinned(unseen: UnseenSockets) -> list[tuple[Posterior, list[Samples]]]:
    """Return at most :data:`MOST` samples, of sockets that are left with three or more."""
    total = sum(len(samples.q) for _, sockets in unseen for samples in sockets)
    step = -(-total // MOST)
    every = slice(None, None, step)
    thinned: list[tuple[Posterior, list[Samples]]] = []
    for posterior, sockets in unseen:
        seats = [part.only(every) for part in sockets if len(part.q) > 2 * step]
        if seats:
            thinned.append((posterior, seats))
    return thinned


def _weights(
    want: np.ndarray,
    noise: np.ndarray,
    roots: Sequence[np.ndarray],
    errors: np.ndarray,
) -> np.ndarray:
    """Return the probability of each K, n and m by the errors, shape (kernels, n, m).

    The evidence is N(errors; 0, want + n^2 noise + m^2 K), with K = F F^T by its root F, as large
    as the first two for n = 1. M = 0 has as much of the prior as all others together.
    """
    background = Background.of(errors, noise, want)
    expected = np.trace(want + noise)
    logs: list[np.ndarray] = []
    for F in roots:
        size = np.sum(F**2)
        if not size > 0:
            continue
        part = background.part(F * np.sqrt(expected / size))
        logs.append(background.with_part(part, SIZES))
    log_weights = np.array(logs)
    count = len(SIZES) - 1
    log_weights[..., 0] += np.log(count)
    return probabilities(log_weights)


def _contrasts(counts: Sequence[int]) -> np.ndarray:
    """Return Q for sockets with so many samples, shape (3 N, 3 (N - sockets))."""
    blocks: list[np.ndarray] = []
    for count in counts:
        columns = np.eye(count)
        columns[:, 0] = 1.0  # the mean first, so that the others' basis is free of it
        blocks.append(basis_of(columns)[:, 1:])
    return np.kron(block_diagonal(blocks), np.eye(3))


def _roots(
    samples: Samples,
    by_joints: np.ndarray,
) -> Iterator[np.ndarray]:
    """Yield roots F of covariances F F^T of errors that a model may lack, shape (3 N, k).

    Of samples a and b these are exp(-|q_a - q_b|^2 / 2 l^2) along each axis alone; and with j_a
    how the ball moves by a joint, j_a j_b^T times exp(-2 sin^2((q_a - q_b) / 2) / l^2) of its
    angle, or times the sign by which gravity pushes it in both.
    """
    for K in kernels(samples.q, LENGTHS):
        yield np.kron(_root(K), np.eye(3))
    for j, angles in enumerate(samples.q.T):
        sines = np.sin(np.subtract.outer(angles, angles) / 2)
        roots = [_root(np.exp(-2 * (sines / length) ** 2)) for length in TURNS]
        for root in (*roots, np.sign(samples.moments[:, j, None])):
            yield rows_of(by_joints[:, :, j, None] * root[:, None])


def _root(K: np.ndarray) -> np.ndarray:
    """Return F with K = F F^T to rounding, of as few columns as that takes."""
    values, axes = np.linalg.eigh(K)
    columns = values > LEAST_SHARE * values[-1]
    return axes[:, columns] * np.sqrt(values[columns])


def parts(
    fit: Fit,
    measurements: Measurements,
) -> ErrorParts | None:
    """Return the parts of the error at what was held out or left out in sockets."""
    load, robot = fit.calibrated.load, measurements.robot
    unseen: list[tuple[Posterior, list[Samples]]] = []
    for posterior, placements in measurements.unseen(fit):
        in_sockets = [m for m in placements if m.kind == "sockets"]
        unseen.append((posterior, load.by_socket(robot, *in_sockets)))
    return error_parts(unseen)


ERROR_PARTS = Study("error_parts", parts)

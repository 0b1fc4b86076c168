"""The posterior updated by held-out samples: their scatter in sockets, and their distances."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..identification.data import SEAT_DEVIATION, Load, Measurement, Samples
from ..identification.inference import Posterior
from ..identification.model import Gaussian
from ..results import Unseen
from .base_errors import BaseErrors, BaseLength, SocketMean
from .projections import basis_of, block_diagonal, evenly, outside, rows_of, shifts_of
from .uncertainty import covariance_of
from .whitening import whitened

MOST = 90
"""Samples of a held-out placement that count at most."""
INDEPENDENT = 0.5
"""Share of the evidence of held-out samples that counts: errors of poses alike are alike."""
ROUNDING = 1e-7
"""Of a correlation of thousands of unknowns, as two sessions with the same postures have."""


def updated(
    posterior: Posterior,
    load: Load,
    unseen: Sequence[Unseen],
) -> Gaussian:
    """Return the change of the unknowns by what fits have not seen.

    What was held out of the posterior itself moves it. What folds leave out has moved it already,
    and tells by how much it is known less well than it seems.

    With Sigma = L L^T the covariance of the unknowns, A the whitened derivatives of what was held
    out, and r its errors,

        L' = L (1 + L^T A^T A L)^-1/2        mean = -L' L'^T A^T r        Sigma' = f L' L'^T

    where f, at least 1, is by how much r^T r - |L'^T A^T r|^2 is larger than expected: a model that
    held-out samples contradict is known less well than it seems. The errors of the bases' readings
    are unknowns as well, so that distances measured with one reading count once.
    """
    root = _root(covariance_of(posterior))
    change = Gaussian(np.zeros(len(root)), root)
    squares = expected = 0.0
    for unaware, placements in unseen:
        evidence = _evidence_of(unaware, load, placements)
        if evidence is None:
            continue
        squares += evidence.squares
        expected += evidence.expected
        if unaware is posterior:
            change = evidence.change
    f = max(squares / expected, 1.0) if expected else 1.0
    return Gaussian(change.mean, f**0.5 * change.root)


class _Evidence(NamedTuple):
    """Evidence of placements on the unknowns of a fit that has not seen them."""

    change: Gaussian
    """Of the unknowns, for f = 1."""
    squares: float
    """r^T r - |L'^T A^T r|^2."""
    expected: float
    """The same as expected of a model that is right."""


def _evidence_of(
    posterior: Posterior,
    load: Load,
    placements: Sequence[Measurement],
) -> _Evidence | None:
    """Return what placements in sockets tell, see :func:`updated`; None without any."""
    root = _root(covariance_of(posterior))
    size = len(root)
    bases = BaseErrors.of(posterior, placements)
    in_sockets = [m for m in placements if m.kind == "sockets"]
    rows = [row for m in in_sockets for row in _evidence(bases, load, m)]
    if not rows:
        return None
    root = block_diagonal([root, np.eye(len(bases.distances))])
    evidence = np.concatenate(rows)
    r = evidence[:, 0]
    A = evidence[:, 1:]
    slopes = A @ root
    L = np.linalg.cholesky(np.eye(len(root)) + slopes.T @ slopes)
    root = np.linalg.solve(L, root.T).T
    along = root.T @ (A.T @ r)
    squares = float(r @ r - along @ along)
    change = Gaussian(-root @ along, root).marginal(slice(size))
    return _Evidence(change, squares, INDEPENDENT * len(r))


def _root(covariance: np.ndarray) -> np.ndarray:
    """Return L with L L^T the covariance, but for rounding."""
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    scale = np.where(deviation > 0, deviation, 1.0)
    correlation = covariance / np.outer(scale, scale)
    L = np.linalg.cholesky(correlation + ROUNDING * np.eye(len(scale)))
    return deviation[:, None] * L


def _evidence(
    bases: BaseErrors,
    load: Load,
    measured: Measurement,
) -> Iterator[np.ndarray]:
    """Yield what a placement tells: the scatter in each socket, and its distance.

    They are rows [r, A] of variance 1, shape (R, 1 + size + h): errors, and their derivatives by
    the unknowns and by what these leave unknown of h bases' readings.
    """
    posterior = bases.posterior
    means: list[SocketMean] = []
    for samples in load.by_socket(posterior.model.robot, measured):
        mean = SocketMean.of(posterior, samples)
        means.append(mean)
        some = evenly(len(samples.q), MOST // 2)
        if len(some) > 1:
            scatter = _scatter(posterior, samples.only(some), mean.centre)
            yield np.pad(scatter, ((0, 0), (0, len(bases.distances))))
    if measured.has_distance:
        length = BaseLength.of(*means[:2])
        f = bases.error_of(measured)
        error = length.value - measured.distance - f @ bases.mean
        by_unknowns = length.slope - f @ bases.slopes
        row = np.r_[error, by_unknowns, -f * np.sqrt(bases.variances)]
        seat = min(SEAT_DEVIATION, float(f.max()))
        yield row[None] / (seat**2 + length.noise) ** 0.5


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
    rows = rows_of(whitened(posterior, by_joints, columns))
    Q = basis_of(rows[:, :3])
    return INDEPENDENT**0.5 * outside(rows[:, 3:], Q)

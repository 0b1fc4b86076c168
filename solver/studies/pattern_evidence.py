"""Evidence of a pattern in the errors that a fit leaves, beside all else that may change them.

Samples are linear in all unknowns about the fit. With derivatives J of the model's unknowns,
derivatives B by the places of sockets and frames, noise C, and a pattern of columns A and mean
square m^2, errors y are::

    y ~ N(0, n^2 C + J S J^T + B B^T + m^2 A A^T)

Of samples held out S is the posterior covariance. Those trained on are compared beside all that the
unknowns can explain: S is their prior covariance, made wider, and y is taken about the prior mean.
The odds of a pattern are the evidence averaged over m > 0 and n, against that with m = 0.
"""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from ..identification.inference import Posterior
from ..identification.model import probabilities, student_weights
from .background import Background
from .projections import block_diagonal, rows_of
from .uncertainty import covariance_of

WIDE = 5.0
"""Factor on the widths of the priors beside which samples trained on are compared."""
SIZES = np.geomspace(0.05, 4.0, 16) ** 2
"""m^2, by the mean square of the noise."""


class PatternRows(NamedTuple):
    """Samples of some placements."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    errors: np.ndarray
    """Errors about their sockets, or in their frames, shape (N, 3) [m]."""
    by_joints: np.ndarray
    """Derivatives of the balls by the joints, shape (N, 3, m)."""
    balls: np.ndarray
    """Shape (N, 3) [m]."""
    time: np.ndarray
    """From 0 at a placement's first sample to 1 at its last, shape (N,)."""
    placement: np.ndarray
    """Index, shape (N,)."""
    seats: np.ndarray
    """B, shape (3 N, k) [m]."""


Slopes = tuple[Posterior, np.ndarray]
"""J, derivatives of a placement's balls by the unknowns of a posterior, shape (N, 3, n)."""
EvidenceOf = Callable[[Posterior, PatternRows, Sequence[Slopes]], "PatternEvidence"]


def of_held_out(
    posterior: Posterior,
    rows: PatternRows,
    slopes: Sequence[Slopes],
) -> "PatternEvidence":
    """Return the evidence of patterns beside what posteriors leave open that have not seen them.

    Samples of one posterior follow one another; those of several count as independent.
    """
    y = rows.errors.ravel()
    blocks: list[np.ndarray] = []
    for _, group in groupby(slopes, key=lambda pair: id(pair[0])):
        (unaware, *_), parts = zip(*group, strict=True)
        J = np.concatenate([rows_of(part) for part in parts])
        blocks.append(J @ covariance_of(unaware) @ J.T)
    changes = block_diagonal(blocks)
    return PatternEvidence(posterior, rows, y, changes)


def of_trained(
    posterior: Posterior,
    rows: PatternRows,
    slopes: Sequence[Slopes],
) -> "PatternEvidence":
    """Return the evidence of patterns beside all that the model's unknowns can explain."""
    J = np.concatenate([rows_of(part) for _, part in slopes])
    mean = np.zeros(len(posterior.x))
    changes = np.zeros((len(J), len(J)))
    for group in posterior.groups:
        mean[group.members] = group.mean
        columns = J[:, group.members]
        prior = group.covariance(group.width)
        changes += WIDE**2 * (columns @ prior @ columns.T)
    change_by_fit = J @ (posterior.x - mean)
    y = rows.errors.ravel() - change_by_fit
    return PatternEvidence(posterior, rows, y, changes)


class PatternEvidence:
    """Evidence of patterns in errors y, shape (3 N,) [m], beside other changes J S J^T of them."""

    def __init__(
        self,
        posterior: Posterior,
        rows: PatternRows,
        y: np.ndarray,
        changes: np.ndarray,
    ) -> None:
        noise = posterior.noise
        normal = noise.as_gaussian(rows.by_joints)
        precisions = np.linalg.inv(normal)
        squares = np.einsum("ni,nij,nj->n", rows.errors, precisions, rows.errors)
        # The farther a sample is, the less it counts, as in the fit.
        weights = student_weights(squares, noise.nu).clip(max=1.0)
        C = normal / weights[:, None, None]
        traces = np.trace(C, axis1=1, axis2=2)
        self.deviations: np.ndarray = np.sqrt(traces / 3)
        self._size = float(traces.mean())
        by_places = rows.seats @ rows.seats.T
        S = changes + by_places
        self._beside = Background.of(y, block_diagonal(C), S)

    def of(self, columns: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the logarithm of the odds of a pattern, and its mean, shape (N, 3) [m].

        With d, V and b of its :class:`.Part`, its mean at some n and m is
        A V diag(m^2 / (1 + m^2 d)) b.
        """
        squares = float(np.sum(columns**2))
        mean_square = max(squares / len(columns), 1e-30)
        ratio = self._size / 3 / mean_square
        A = columns * ratio**0.5
        part = self._beside.part(A)
        logs = self._beside.with_part(part, SIZES)
        weights = probabilities(logs)
        m2 = SIZES[:, None]
        shrunk = m2 / (1 + m2 * part.d[:, None])
        along_axes = np.einsum("nm,nmk,nk->nk", weights, shrunk, part.b)
        coefficients = np.einsum("njk,nk->j", part.V, along_axes)
        mean = A @ coefficients
        before = _log_sum(self._beside.logs)
        log_count = float(np.log(len(SIZES)))
        log_odds = _log_sum(logs) - log_count - before
        return log_odds, mean.reshape(-1, 3)


def _log_sum(logs: np.ndarray) -> float:
    return float(np.logaddexp.reduce(logs.ravel()))

"""Evidence of a pattern in the errors that a fit leaves, beside all else that may change them.

Samples are linear in all unknowns about the fit. With derivatives J of the model's unknowns,
derivatives B by the places of sockets and frames, noise C, and a pattern of columns A and mean
square m^2, errors y are::

    y ~ N(0, n^2 C + J S J^T + B B^T + m^2 A A^T)

Of samples held out S is the posterior covariance. Those trained on are compared beside all that the
unknowns can explain: S is their prior covariance, made wider, and y is taken about the prior mean.
The odds of a pattern are the evidence averaged over m > 0 and n, against that with m = 0.
"""

from typing import NamedTuple

import numpy as np

from ..inference import Posterior
from ..model import probabilities, student_weights
from .held_out_error import NOISE_DEVIATION, NOISES
from .projections import block_diagonal
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
    J: np.ndarray
    """Derivatives of the balls by the unknowns, shape (N, 3, n)."""
    by_joints: np.ndarray
    """Those by the joints, shape (N, 3, m)."""
    balls: np.ndarray
    """Shape (N, 3) [m]."""
    time: np.ndarray
    """From 0 at a placement's first sample to 1 at its last, shape (N,)."""
    placement: np.ndarray
    """Index, shape (N,)."""
    seats: np.ndarray
    """B, shape (3 N, k) [m]."""

    @property
    def slopes(self) -> np.ndarray:
        """J, shape (3 N, n)."""
        return self.J.reshape(-1, self.J.shape[2])


def of_held_out(posterior: Posterior, rows: PatternRows) -> "PatternEvidence":
    """Return the evidence of patterns beside what the posterior leaves open."""
    J = rows.slopes
    return PatternEvidence(posterior, rows, rows.errors.ravel(), J @ covariance_of(posterior) @ J.T)


def of_trained(posterior: Posterior, rows: PatternRows) -> "PatternEvidence":
    """Return the evidence of patterns beside all that the model's unknowns can explain."""
    J = rows.slopes
    mean = np.zeros(len(posterior.x))
    changes = np.zeros((len(J), len(J)))
    for group in posterior.groups:
        columns = J[:, group.members]
        changes += WIDE**2 * (columns @ group.covariance(group.width) @ columns.T)
        mean[group.members] = group.mean
    return PatternEvidence(posterior, rows, rows.errors.ravel() - J @ (posterior.x - mean), changes)


class PatternEvidence:
    """Evidence of patterns in errors y, shape (3 N,) [m], beside other changes of them.

    With L_n L_n^T = n^2 C + J S J^T + B B^T it keeps L_n^-1, L_n^-1 y and the evidence without a
    pattern for each n:  -1/2 |L_n^-1 y|^2 - log det L_n, and the prior of n.
    """

    def __init__(
        self, posterior: Posterior, rows: PatternRows, y: np.ndarray, changes: np.ndarray
    ) -> None:
        noise = posterior.noise
        normal = noise.as_gaussian(rows.by_joints)
        squares = np.einsum("ni,nij,nj->n", rows.errors, np.linalg.inv(normal), rows.errors)
        # The farther a sample is, the less it counts, as in the fit.
        C = normal / np.minimum(student_weights(squares, noise.nu), 1.0)[:, None, None]
        traces = np.trace(C, axis1=1, axis2=2)
        self.deviations: np.ndarray = np.sqrt(traces / 3)
        self._size = float(traces.mean())
        scatter = block_diagonal(C)
        background: np.ndarray = changes + rows.seats @ rows.seats.T
        roots: list[np.ndarray] = [
            np.linalg.cholesky(n * scatter + background) for n in NOISES.tolist()
        ]
        self._whiten: list[np.ndarray] = [np.linalg.inv(L) for L in roots]
        self._white: list[np.ndarray] = [W @ y for W in self._whiten]
        squares = np.sum(np.square(self._white), axis=1)
        volumes = np.array([np.log(np.diag(L)).sum() for L in roots])
        prior = np.log(NOISES) ** 2 / 8 / NOISE_DEVIATION**2
        self._base: np.ndarray = -0.5 * squares - volumes - prior

    def of(self, columns: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the logarithm of the odds of a pattern, and its mean, shape (N, 3) [m].

        With z = L_n^-1 y, (L_n^-1 A)^T L_n^-1 A = V diag(d) V^T and b = V^T (L_n^-1 A)^T z, a
        pattern changes the evidence by

            1/2 sum_i [m^2 b_i^2 / (1 + m^2 d_i) - log(1 + m^2 d_i)]

        and has the mean A V diag(m^2 / (1 + m^2 d)) b.
        """
        squares = max(float(np.sum(columns**2)), 1e-30)
        A: np.ndarray = columns * (self._size * len(columns) / 3 / squares) ** 0.5
        logs = np.zeros((len(NOISES), len(SIZES)))
        means = np.zeros((*logs.shape, A.shape[1]))
        for k, (W, z) in enumerate(zip(self._whiten, self._white, strict=True)):
            white: np.ndarray = W @ A
            d, V = np.linalg.eigh(white.T @ white)
            d = d.clip(min=0.0)
            along = (white @ V).T @ z
            for i, size in enumerate(SIZES.tolist()):
                shrunk: np.ndarray = size / (1 + size * d)
                gain = float(shrunk @ along**2) - float(np.log1p(size * d).sum())
                logs[k, i], means[k, i] = 0.5 * gain, V @ (shrunk * along)
        of_pattern: np.ndarray = self._base[:, None] + logs
        coefficients = np.einsum("ki,kij->j", probabilities(of_pattern), means)
        log_odds = _log_sum(of_pattern) - np.log(len(SIZES)) - _log_sum(self._base)
        return float(log_odds), (A @ coefficients).reshape(-1, 3)


def _log_sum(logs: np.ndarray) -> float:
    return float(np.logaddexp.reduce(logs.ravel()))

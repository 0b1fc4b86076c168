"""Covariance of the minimum of Eq. (5), if the same recordings were made once more.

The minimum follows errors e of the data by a step of Gauss-Newton:

    dx = -H^-1 J^T e,   H = J^T J + the regularization's

with J the Jacobian of the data's residuals. So errors with covariance C move the minimum with
covariance H^-1 J^T C J H^-1.
"""

import numpy as np

from ..data import CALIPER_DEVIATION, Known, Measurement, distance_covariance
from .problem import Problem

CORRELATED = 3.0
"""Errors of a sample and the next are alike by about a half: so much larger is the variance of what
many of them say together."""


def covariance(problem: Problem, x: np.ndarray) -> np.ndarray:
    """Return the covariance of the parameters at the minimum, shape (n, n).

    The balls' noise is what the fit left of it; the sockets' distances are a caliper's, wrong by
    the same amount wherever one base stands. What the regularization holds at nominal does not
    move: its deviation is small, though nothing is known of it.

    Args:
        problem: What was minimised.
        x: Its minimum.
    """
    residuals, jacobian = problem.residuals(x)
    unit, J = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True), jacobian[len(x) :]
    rows = [3 * len(m.positions) + 1 for m in problem.training]
    distances = np.cumsum(rows) - 1
    relative = np.concatenate([_relative_variances(m) for m in problem.training])
    balls = np.delete(residuals[len(x) :] / np.sqrt(relative), distances)
    fitted = float(np.sum((J @ unit) * J))
    free = len(balls) - 3 * sum(len(m.sockets) for m in problem.training) - fitted
    noise = CORRELATED * float(balls @ balls) / max(free, 1.0)
    of_noise = (J * (noise * relative)[:, None]).T @ J
    of_caliper = J[distances].T @ _caliper(problem.training) @ J[distances]
    return unit @ (of_noise + of_caliper) @ unit


def _relative_variances(measured: Measurement) -> np.ndarray:
    """Return the variance of each residual of a placement for noise of variance 1 per axis."""
    total = len(measured.positions)
    means = sum(1 / count for count in measured.counts[:2])
    return np.append(np.full(3 * total, 1 / total), means)


def _caliper(training: tuple[Measurement, ...]) -> np.ndarray:
    """Return the covariance of the errors of the placements' distances [m^2]."""
    return distance_covariance(
        [Known(0, 1, m.distance, CALIPER_DEVIATION, on_base=True) for m in training]
    )

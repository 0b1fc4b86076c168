"""Eq. (5) of the paper as a sum of squared residuals, its problem and its solution.

    J = (N0 tr(S0) + N1 tr(S1)) / (N0 + N1)       inconsistency
      + (|mu1 - mu0| - d)^2                       distortion
      + lambda |Theta - Theta_nominal|^2          regularization

for each placement with sockets 0 and 1: N_k samples in socket k, mu_k and S_k the mean and the
covariance of their predicted ball centres, d the measured distance between the sockets [m], Theta
the parameters [m, rad], and lambda the weight that keeps them near nominal. A placement of one
socket has no distortion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ....errors import MukcaError
from ..data import CALIPER_DEVIATION, Known, Measurement, distance_covariance
from ..robot import BallModel, Parameter, Robot, choose_parameters
from .optimizers import MAX_ITERATIONS, Solution, gauss_newton, ipopt

OPTIMIZERS = ("gauss-newton", "ipopt")
REGULARIZATION = 1e-4
"""lambda of Eq. (5): what a change of a parameter by 1 m or 1 rad costs [m^2]."""
CORRELATED = 3.0
"""Errors of a sample and the next are alike by about a half: so much larger is the variance of what
many of them say together."""


class SettingError(MukcaError):
    """A setting of the calibration that cannot be."""


@dataclass(frozen=True)
class Problem:
    """Eq. (5), summed over the placements trained on."""

    parameters: tuple[Parameter, ...]
    model: BallModel
    training: tuple[Measurement, ...]
    regularization: float

    @property
    def start(self) -> np.ndarray:
        """The nominal parameters."""
        return self.model.nominal

    def residuals(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the residuals at x, shape (r,) [m], and their Jacobian, shape (r, n)."""
        positions = np.concatenate([m.positions for m in self.training])
        linear = self.model.linearise(x, positions)
        # means and deviations of points and of their derivatives are the same linear operations
        columns = np.dstack([linear.points, linear.by_parameters])
        weights = self._weights
        change = (x - self.start) * weights
        parts = [np.column_stack([change, np.diag(weights)])]
        for measured in self.training:
            total = len(measured.positions)
            parts += _of_placement(measured, columns[:total])
            columns = columns[total:]
        rows = np.concatenate(parts)
        return rows[:, 0].copy(), rows[:, 1:].copy()

    def objective(self, x: Any) -> Any:
        """Return Eq. (5) as a CasADi expression of a symbolic parameter vector [m^2]."""
        change = (x - ca.DM(self.start)) * ca.DM(self._weights)
        total: Any = ca.sumsqr(change)
        for measured in self.training:
            means: list[Any] = []
            for rows in measured.by_socket:
                count = len(rows)
                points = self.model.function.map(count)(x, rows.T)
                mean = ca.sum2(points) / count
                means.append(mean)
                offsets = points - ca.repmat(mean, 1, count)
                total += ca.sumsqr(offsets) / len(measured.positions)
            if measured.has_distance:
                length = ca.norm_2(means[1] - means[0])
                total += (length - measured.distance) ** 2
        return total

    @property
    def _weights(self) -> np.ndarray:
        """Square root of each parameter's weight: lambda for each placement, and 0 for the ball."""
        weight = (self.regularization * len(self.training)) ** 0.5
        return np.array([0.0 if p.of_ball else weight for p in self.parameters])


def _of_placement(
    measured: Measurement,
    balls: np.ndarray,
) -> list[np.ndarray]:
    """Return the residuals of a placement's inconsistency and distortion.

    ``balls`` are columns of its N samples: points, and their derivatives, shape (N, 3, 1 + n); rows
    of residuals have the same columns.
    """
    means: list[np.ndarray] = []
    parts: list[np.ndarray] = []
    for rows in measured.slices:
        mean = balls[rows].mean(axis=0)
        means.append(mean)
        deviations = (balls[rows] - mean) / len(balls) ** 0.5
        parts.append(deviations.reshape(-1, balls.shape[2]))
    if not measured.has_distance:
        return parts
    offset = means[1] - means[0]
    length = float(np.linalg.norm(offset[:, 0]))
    distortion = offset[:, 0] @ offset / length
    distortion[0] = length - measured.distance
    return [*parts, distortion[None]]


def build_problem(
    robot: Robot,
    training: Sequence[Measurement],
    *,
    parameters: Sequence[Parameter] | None = None,
    regularization: float = REGULARIZATION,
) -> Problem:
    """Return the problem of Eq. (5); free are by default all actuated joints and the ball.

    The paper's Theta has roll, pitch and yaw.
    """
    if not 0 <= regularization < np.inf:
        raise SettingError(
            f"regularization {regularization}: give zero or a positive number"
        )
    chosen = choose_parameters(robot) if parameters is None else tuple(parameters)
    model = BallModel(robot, [p.index for p in chosen], "rpy")
    return Problem(chosen, model, tuple(training), regularization)


def solve(
    problem: Problem,
    optimizer: str = "gauss-newton",
    max_iterations: int = MAX_ITERATIONS,
) -> Solution:
    """Minimise Eq. (5) from the nominal parameters; both :data:`OPTIMIZERS` reach the minimum."""
    if optimizer == "gauss-newton":
        return gauss_newton(
            problem.residuals, problem.start, max_iterations=max_iterations
        )
    if optimizer == "ipopt":
        return ipopt(problem.objective, problem.start, max_iterations=max_iterations)
    raise SettingError(
        f"optimizer {optimizer!r}: choose one of {', '.join(OPTIMIZERS)}"
    )


def covariance(problem: Problem, x: np.ndarray) -> np.ndarray:
    """Return the covariance of the minimum if the same were recorded once more, shape (n, n).

    The minimum follows errors e of the data by a step of Gauss-Newton, dx = -H^-1 J^T e, with J the
    Jacobian of the data's residuals and H = J^T J + the regularization's. The balls' noise is what
    the fit left of it; the sockets' distances are a caliper's, wrong alike wherever one base
    stands.
    """
    residuals, jacobian = problem.residuals(x)
    unit = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    J = jacobian[len(x) :]
    variances = [_relative_variances(m) for m in problem.training]
    relative = np.concatenate(variances)
    paired = [m.has_distance for m in problem.training]
    distances = np.cumsum([len(v) for v in variances])[paired] - 1
    white = residuals[len(x) :] / np.sqrt(relative)
    balls = np.delete(white, distances)
    fitted = float(np.sum((J @ unit) * J))
    means = sum(len(m.sockets) for m in problem.training)
    free = len(balls) - 3 * means - fitted
    noise = CORRELATED * float(balls @ balls) / max(free, 1.0)
    weights = noise * relative
    of_noise = (J * weights[:, None]).T @ J
    known = [
        Known(0, 1, m.distance, CALIPER_DEVIATION, on_base=True)
        for m in problem.training
        if m.has_distance
    ]
    by_distances = J[distances]
    of_caliper = by_distances.T @ distance_covariance(known) @ by_distances
    return unit @ (of_noise + of_caliper) @ unit


def _relative_variances(measured: Measurement) -> np.ndarray:
    """Return the variance of each residual of a placement for noise of variance 1 per axis."""
    total = len(measured.positions)
    of_balls = np.full(3 * total, 1 / total)
    if not measured.has_distance:
        return of_balls
    of_distance = sum(1 / count for count in measured.counts[:2])
    return np.append(of_balls, of_distance)

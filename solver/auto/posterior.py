"""Where an estimation arrived: the posterior's maximum, its covariance, its hyperparameters."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .deflection import Deflection
from .extended_model import MapProblem
from .priors import Group, Noise

__all__ = ["INFORMATION", "NU", "Estimate", "predict"]

Vector = NDArray[np.float64]
NU = 5.0
"""Degrees of freedom of the noise: heavy tails, so that a ball badly seated weighs little."""
INFORMATION = (NU + 3) / (NU + 5)
"""What a sample of that noise tells, relative to a Gaussian one of the same scale."""


@dataclass(frozen=True)
class Estimate:
    """Where the estimation arrived."""

    problem: MapProblem
    x: Vector
    """Geometry, as change from nominal, and coefficients of the extensions."""
    centres: Vector
    """Socket centres, shape (S, 3) [m]."""
    covariance: Vector
    """Posterior covariance of x and the centres."""
    groups: tuple[Group, ...]
    noise: Noise
    points: Vector
    """Ball centres of the samples, shape (N, 3) [m]."""
    weights: Vector
    """Robust weight of each sample, shape (N,): near 1, and towards 0 far from its socket."""
    log_evidence: float
    evaluations: int
    """Residuals and Jacobians evaluated."""
    iterates: tuple[Vector, ...] = field(default=())
    """x after each iteration, the start first."""

    @property
    def values(self) -> Vector:
        """The geometric parameters."""
        geometry = self.problem.geometry
        return self.problem.model.nominal + self.x[:geometry]

    @property
    def residuals(self) -> Vector:
        """Each sample's ball centre less its socket's, shape (N, 3) [m]."""
        return self.points - self.centres[self.problem.data.sockets]

    @property
    def deflection(self) -> Deflection:
        """The extensions."""
        return self.problem.deflection(self.x)

    def predict(self, q: Vector, torque: Vector) -> Vector:
        """Return the ball's centre for rows of joint positions and torques, shape (N, 3) [m]."""
        return predict(self.problem, self.x, q, torque)


def predict(problem: MapProblem, x: Vector, q: Vector, torque: Vector) -> Vector:
    """Return the ball's centre at some unknowns, shape (N, 3) [m]."""
    true = problem.deflection(x).true_positions(q, torque)
    return problem.model.points(problem.model.nominal + x[: problem.geometry], true)

"""The result of the default method: the most probable unknowns, and how well they are known."""

from dataclasses import dataclass

import numpy as np

from ..data.observations import Observations
from .deflection import Deflection
from .extended_model import ExtendedModel
from .noise import Noise
from .priors import PriorGroup

__all__ = ["Posterior"]


@dataclass(frozen=True)
class Posterior:
    """The posterior: what is known of the unknowns after the data, as a bell curve.

    docs/model.md introduces prior, posterior and evidence.
    """

    model: ExtendedModel
    data: Observations
    x: np.ndarray
    """The most probable unknowns: changes of the geometry from nominal, then the extensions'
    coefficients, shape (model.size,)."""
    centres: np.ndarray
    """Socket centres, shape (S, 3) [m]."""
    covariance: np.ndarray
    """Covariance of x and the centres, shape (size + 3 S, size + 3 S)."""
    groups: tuple[PriorGroup, ...]
    """The priors, with the widths that the data gave them."""
    noise: Noise
    """How large the noise is, as the data show it."""
    points: np.ndarray
    """Ball centres of the samples, shape (N, 3) [m]."""
    weights: np.ndarray
    """Robust weight of each sample, shape (N,): near 1, and towards 0 far from its socket."""
    log_evidence: float
    """Logarithm of the evidence: how probable the data are under the model, averaged over all
    values that the prior allows for its unknowns."""
    iterates: tuple[np.ndarray, ...]
    """x after each iteration, the start first."""

    @property
    def evaluations(self) -> int:
        """How often the residuals and their Jacobian were computed."""
        return len(self.iterates)

    @property
    def values(self) -> np.ndarray:
        """The geometric parameters, shape (geometry,) [m, rad]."""
        return self.model.values(self.x)

    @property
    def deflection(self) -> Deflection:
        """The calibrated elasticity and transmission errors."""
        return self.model.deflection(self.x)

    @property
    def residuals(self) -> np.ndarray:
        """Each sample's predicted ball centre minus its socket's centre, shape (N, 3) [m]."""
        return self.points - self.centres[self.data.sockets]

    def predict(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the ball's centre for rows of joint positions and torques, shape (N, 3) [m]."""
        return self.model.predict(self.x, q, torque)

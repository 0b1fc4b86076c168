"""What the evidence decides beside the unknowns: widths of priors, and scales of the noise."""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

__all__ = ["NEGLIGIBLE", "Group", "Noise"]

Vector = NDArray[np.float64]
NEGLIGIBLE = 0.05
"""A scale that moves the ball by less than this part of the noise is nothing."""


@dataclass(frozen=True)
class Group:
    """Unknowns that share one prior, of mean 0 and width (standard deviation) s_g."""

    name: str
    unit: str
    members: NDArray[np.int64]
    """Their indices among the unknowns."""
    width: float
    scale: float = np.inf
    """Of a half-normal prior on the width itself."""
    learned: bool = True
    """Whether the evidence sets the width."""
    effective: float = 0.0
    """gamma_g: how many of its unknowns the data decide."""
    together: Vector | None = None
    """A change of all members at once that the prior leaves free, in standard deviations of it."""

    def covariance(self, width: float) -> Vector:
        """Return the members' prior covariance for a width: s_g^2 I + t t^T."""
        t = self._together
        return width**2 * np.eye(len(t)) + np.outer(t, t)

    def precision(self, kept: NDArray[np.int64], width: float) -> Vector:
        """Return the prior precision of those members that do not stay at zero."""
        t = self._together[np.isin(self.members, kept)]
        return (np.eye(len(t)) - np.outer(t, t) / (width**2 + t @ t)) / width**2

    @property
    def _together(self) -> Vector:
        return np.zeros(len(self.members)) if self.together is None else self.together

    @property
    def deviation(self) -> float:
        """Standard deviation of the prior, the uncertainty of its own width included.

        With a width learned from gamma unknowns integrated out, the prior is Student's with gamma
        degrees of freedom, whose variance is gamma / (gamma - 2) larger; twice at most here.
        """
        gamma = max(self.effective, 4.0)
        return self.width * (gamma / (gamma - 2)) ** 0.5 if self.learned else self.width

    def updated(self, x: Vector, covariance: Vector, kept: NDArray[np.int64]) -> "Group":
        """Return the group after a fixed-point step of its width, gamma s^2 = |x_g|^2 (MacKay).

        Args:
            x: Those members that do not stay at zero.
            covariance: Their posterior covariance.
            kept: Their indices.
        """
        P = self.width**2 * self.precision(kept, self.width)
        effective = float(np.trace(P) - np.trace(P @ covariance @ P) / self.width**2)
        squares, gamma = float(np.sum((P @ x) ** 2)), max(effective, 1e-9)
        square = squares / gamma
        if np.isfinite(self.scale):
            h2 = self.scale**2
            square = h2 * (np.sqrt(gamma**2 + 4 * squares / h2) - gamma) / 2
        return replace(self, width=float(np.sqrt(max(square, 1e-24))), effective=effective)


@dataclass(frozen=True)
class Noise:
    """Scales of the noise."""

    space: float
    """s_x [m]."""
    joint: float
    """s_q [rad]; 0 where the data do not support it."""

    def updated(self, step: Vector, effect: float) -> "Noise":
        """Return the noise after a step of its squares, each by a factor of 4 at most.

        Noise in space is kept from zero, since no ball sits without any play.

        Args:
            step: Change of s_x^2 [m^2] and, unless it is zero, of s_q^2 [rad^2].
            effect: What the noise of the joints does to the ball, relative to that in space.
        """
        squares = np.array([self.space, self.joint])[: len(step)] ** 2
        scales = np.sqrt(np.clip(squares + step, squares / 4, 4 * squares)).tolist()
        s_x, s_q = scales if len(scales) == 2 else (scales[0], 0.0)
        reach = effect * self.space / self.joint if self.joint else 0.0
        return Noise(max(s_x, NEGLIGIBLE * s_q * reach, 1e-9), s_q)

    def scales(self, by_joints: Vector) -> Vector:
        """Return C_i for each sample's Jq, shape (N, 3, 3)."""
        spread = by_joints @ by_joints.transpose(0, 2, 1)
        return self.space**2 * np.eye(3) + self.joint**2 * spread

    def fisher_step(
        self, inverse: Vector, weights: Vector, errors: Vector, leverage: Vector, by_joints: Vector
    ) -> Vector:
        """Return a step of Fisher scoring for s_x^2 and, unless it is zero, s_q^2.

        The score of each is what is left over of it in the errors, less what was to be expected
        in the directions that the fit leaves to it (restricted maximum likelihood).

        Args:
            inverse: C_i^-1, shape (N, 3, 3).
            weights: Robust information of each sample, shape (N,).
            errors: Shape (N, 3).
            leverage: Posterior covariance of the errors, weighted, shape (N, 3, 3).
            by_joints: Jq, shape (N, 3, m).
        """
        u = np.einsum("nij,nj->ni", inverse, errors)
        left = inverse - inverse @ leverage @ inverse
        kinds = [
            np.broadcast_to(np.eye(3), inverse.shape),
            by_joints @ by_joints.transpose(0, 2, 1),
        ]
        kinds = kinds if self.joint else kinds[:1]
        score = [
            float(np.sum(weights * np.einsum("ni,nij,nj->n", u, V, u)) - np.sum(left * V))
            for V in kinds
        ]
        scaled = [inverse @ V for V in kinds]
        fisher = [[float(np.sum(A * B.transpose(0, 2, 1))) for B in scaled] for A in scaled]
        return np.linalg.solve(fisher, score).astype(np.float64)

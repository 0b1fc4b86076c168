"""The noise of a sample: how well the ball sits in its socket, and how well angles are read.

The error e_i of sample i, a vector of shape (3,) [m], scatters by

    C_i = s_x^2 I + s_q^2 Jq_i Jq_i^T

    s_x    noise in space: of the ball's place in its socket, per axis [m]
    s_q    noise of each joint angle [rad]
    Jq_i   derivative of the ball's position by the joint positions, shape (3, m) [m/rad]

so an arm that is stretched out, where a small angle moves the ball far, may err more.
"""

from dataclasses import dataclass

import numpy as np

__all__ = ["INFORMATION", "NEGLIGIBLE", "NU", "SMALLEST", "Noise"]

NU = 5.0
"""Degrees of freedom of Student's t distribution of the errors. Unlike a Gaussian it expects a
large error now and then, so that a ball that was badly seated hardly pulls at the fit."""
INFORMATION = (NU + 3) / (NU + 5)
"""Information of one sample with Student's noise, as a share of one with Gaussian noise of scale
C_i."""
NEGLIGIBLE = 0.05
"""Whatever moves the ball by less than this share of the noise is taken for zero."""
SMALLEST = 1e-7
"""Least value of s_x [m]."""
LARGEST_FACTOR = 4
"""s_x^2 and s_q^2 change by at most this factor in one step."""


@dataclass(frozen=True)
class Noise:
    """How large the noise is."""

    space: float
    """s_x, of the ball's place in a socket [m]."""
    joint: float
    """s_q, of the joint angles [rad]; 0 where the data do not support it."""

    def scales(self, by_joints: np.ndarray) -> np.ndarray:
        """Return C_i for each sample's Jq_i, shape (N, 3, 3) [m^2]."""
        spread = by_joints @ by_joints.transpose(0, 2, 1)
        return self.space**2 * np.eye(3) + self.joint**2 * spread

    def joint_effect(self, by_joints: np.ndarray) -> float:
        """Return how far the joints' noise moves the ball, relative to the noise in space.

        Args:
            by_joints: Jq_i of each sample, shape (N, 3, m) [m/rad].
        """
        squares: np.ndarray = np.sum(by_joints**2, axis=(1, 2)) / 3
        return self.joint * float(np.mean(squares)) ** 0.5 / self.space

    def updated(self, step: np.ndarray, effect: float) -> "Noise":
        """Return the noise after s_x^2 and s_q^2 changed by a step.

        s_x is kept from zero, since no ball sits without any play.

        Args:
            step: Change of s_x^2 [m^2] and, unless it is zero, of s_q^2 [rad^2].
            effect: What :meth:`joint_effect` returns for this noise.
        """
        squares = np.array([self.space, self.joint])[: len(step)] ** 2
        moved = np.clip(squares + step, squares / LARGEST_FACTOR, LARGEST_FACTOR * squares)
        scales = np.sqrt(moved).tolist()
        s_x, s_q = scales if len(scales) == 2 else (scales[0], 0.0)
        reach = effect * self.space / self.joint if self.joint else 0.0
        return Noise(max(s_x, NEGLIGIBLE * s_q * reach, SMALLEST), s_q)

    def fisher_step(
        self,
        inverse: np.ndarray,
        weights: np.ndarray,
        errors: np.ndarray,
        leverage: np.ndarray,
        by_joints: np.ndarray,
    ) -> np.ndarray:
        """Return a step of s_x^2 and, unless it is zero, of s_q^2 towards their best values.

        If the errors scatter more than the noise says, it grows; if less, it shrinks. What is
        compared with the errors takes into account that a fit makes errors smaller than the noise
        was: each unknown uses up some of them (restricted maximum likelihood, Harville 1977; the
        step is Fisher scoring, Newton's method with the expected curvature). The slope for s_x^2,
        where V_i = I, and for s_q^2, where V_i = Jq_i Jq_i^T, is

            sum_i  w_i e_i^T C_i^-1 V_i C_i^-1 e_i  -  tr((C_i^-1 - C_i^-1 L_i C_i^-1) V_i)    (A5)

        Args:
            inverse: C_i^-1, shape (N, 3, 3).
            weights: w_i, robust weight of each sample, shape (N,).
            errors: e_i, shape (N, 3) [m].
            leverage: L_i, how uncertain the errors are because the unknowns are, times k w_i,
                shape (N, 3, 3) [m^2].
            by_joints: Jq_i, shape (N, 3, m) [m/rad].

        Returns:
            The change of s_x^2 [m^2] and of s_q^2 [rad^2], shape (2,), or (1,) without the latter.
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

"""The noise of a sample: of the ball in its socket, and of the joint angles that were read.

A sample's error e_i has the scale C_i = s_x^2 I + s_q^2 Jq_i Jq_i^T, where Jq_i is the derivative
of the ball's position by the joint positions.
"""

from dataclasses import dataclass

import numpy as np

__all__ = ["INFORMATION", "NEGLIGIBLE", "NU", "Noise"]

NU = 5.0
"""Degrees of freedom of the noise: heavy tails, so that a ball badly seated weighs little."""
INFORMATION = (NU + 3) / (NU + 5)
"""What a sample of that noise tells, relative to a Gaussian one of the same scale."""
NEGLIGIBLE = 0.05
"""What moves the ball by less than this part of the noise counts as nothing."""
SMALLEST = 1e-9
"""Noise in space is never taken for less [m]."""
LARGEST_FACTOR = 4
"""By so much the square of a scale may change in one step."""


@dataclass(frozen=True)
class Noise:
    """Scales of the noise."""

    space: float
    """s_x, of the ball's place in a socket [m]."""
    joint: float
    """s_q, of the joint angles [rad]; 0 where the data do not support it."""

    def scales(self, by_joints: np.ndarray) -> np.ndarray:
        """Return C_i for each sample's Jq_i, shape (N, 3, 3) [m^2]."""
        spread = by_joints @ by_joints.transpose(0, 2, 1)
        return self.space**2 * np.eye(3) + self.joint**2 * spread

    def joint_effect(self, by_joints: np.ndarray) -> float:
        """Return how far the joints' noise moves the ball, relative to the noise in space."""
        squares: np.ndarray = np.sum(by_joints**2, axis=(1, 2)) / 3
        return self.joint * float(np.mean(squares)) ** 0.5 / self.space

    def updated(self, step: np.ndarray, effect: float) -> "Noise":
        """Return the noise after a step of its squares.

        Noise in space is kept from zero, since no ball sits without any play.

        Args:
            step: Change of s_x^2 [m^2] and, unless it is zero, of s_q^2 [rad^2].
            effect: As :meth:`joint_effect` returns it.
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
        """Return a step of Fisher scoring for s_x^2 and, unless it is zero, s_q^2.

        With V = I for s_x^2 and V = Jq Jq^T for s_q^2, the score is what the errors hold of V
        less what was to be expected in the directions that the fit leaves free (restricted
        maximum likelihood, Harville 1977):

            score_V = sum_i  w_i e_i^T C_i^-1 V C_i^-1 e_i  -  tr((C_i^-1 - C_i^-1 L_i C_i^-1) V)

        Args:
            inverse: C_i^-1, shape (N, 3, 3).
            weights: w_i, robust weight of each sample, shape (N,).
            errors: e_i, shape (N, 3) [m].
            leverage: L_i, posterior covariance of the errors, weighted, shape (N, 3, 3).
            by_joints: Jq_i, shape (N, 3, m).
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

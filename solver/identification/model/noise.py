"""The noise of a sample: how well the ball sits in its socket, and how well angles are read."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import lgamma, log, pi

import numpy as np

NU = 5.0
"""nu before the errors have shown how heavy their tails are, and the least: heavier ones would
explain away what is no noise, as play is, and leave it to chance which samples count."""
TAILS = np.geomspace(NU, 60, 9)
"""Values of nu that are tried; with the last, the distribution is nearly Gaussian."""
LIGHT_TAILS = 10.0
"""Scale of the prior of nu, with the density nu exp(-nu / 10) (Juarez and Steel 2010)."""
SCALE_STEPS = 6
"""Until errors are about as large as their noise says, whatever nu is tried."""
NEGLIGIBLE = 0.05
"""Whatever moves the ball by less than this share of the noise is taken for zero."""
SMALLEST = 1e-7
"""Least value of s_x [m]."""
LARGEST_FACTOR = 4
"""s_x^2 and s_q^2 change by at most this factor in one step."""


@dataclass(frozen=True)
class Noise:
    """Scales and tails of the noise of samples."""

    space: float
    """s_x, of the ball's place in a socket [m]."""
    joint: float
    """s_q, of the joint angles [rad]; 0 where the data do not support it."""
    nu: float = NU
    """Degrees of freedom of Student's distribution of the errors."""

    @property
    def information(self) -> float:
        """k: what a sample tells, as a share of what one with Gaussian noise of scale C_i would."""
        return (self.nu + 3) / (self.nu + 5)

    def as_gaussian(self, by_joints: np.ndarray) -> np.ndarray:
        """Return C_i / k, the covariance of Gaussian noise of which a sample tells as much."""
        sources = np.zeros(len(by_joints), int)
        C = sample_scales([self], sources, by_joints)
        return C / self.information

    def joint_effect(self, by_joints: np.ndarray) -> float:
        """Return how far the joints' noise moves the ball, relative to that in space."""
        return self.joint * joint_reach(by_joints) / self.space

    def updated(self, step: np.ndarray, reach: float) -> "Noise":
        """Return the noise after a step of s_x^2 and of s_q^2, by the :func:`joint_reach`.

        s_x is kept from zero, since no ball sits without any play.
        """
        scales = np.array([self.space, self.joint])
        squares = scales[: len(step)] ** 2
        lower, upper = squares / LARGEST_FACTOR, squares * LARGEST_FACTOR
        clipped = np.clip(squares + step, lower, upper)
        updated = np.sqrt(clipped)
        s_x = float(updated[0])
        s_q = float(updated[1]) if len(step) > 1 else 0.0
        s_x = max(s_x, NEGLIGIBLE * s_q * reach, SMALLEST)
        return replace(self, space=s_x, joint=s_q)


def joint_reach(by_joints: np.ndarray) -> float:
    """Return how far joints that all err by 1 rad at random move the ball per axis [m/rad]."""
    squares = (by_joints**2).sum(axis=(1, 2))
    square = float(squares.mean()) / 3
    return square**0.5


def sample_scales(
    noises: Sequence[Noise],
    sources: np.ndarray,
    by_joints: np.ndarray,
) -> np.ndarray:
    """Return C_i of samples, by the index of each one's noise and its Jq_i, (N, 3, 3) [m^2]."""
    space = np.array([noise.space for noise in noises])
    joint = np.array([noise.joint for noise in noises])
    s_x = space[sources, None, None]
    s_q = joint[sources, None, None]
    spread = by_joints @ by_joints.transpose(0, 2, 1)
    return s_x**2 * np.eye(3) + s_q**2 * spread


def sample_degrees(noises: Sequence[Noise], sources: np.ndarray) -> np.ndarray:
    """Return nu of samples, by the index of each one's noise, shape (N,)."""
    nu = np.array([noise.nu for noise in noises])
    return nu[sources]


def student_weights(
    squares: np.ndarray,
    nu: float | np.ndarray,
    axes: int = 3,
) -> np.ndarray:
    """Return w = (nu + d) / (nu + e^T C^-1 e), the robust weights of errors with d axes (A2).

    A fit by Student's distribution is one of least squares with these weights, found in turn.
    """
    return (nu + axes) / (nu + squares)


def information_of(weights: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """Return k w, the information of samples relative to Gaussian noise of scale C_i."""
    return weights * (nu + 3) / (nu + 5)


def fitted_squares(
    squares: np.ndarray,
    nu: float | np.ndarray,
    steps: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Return squares, shape (..., N), as large as Student's noise says, and by how much they grew.

    Each step is one of EM with one more parameter (Kent, Tyler and Vardi 1994). The growth is a
    logarithm, shape (..., 1).
    """
    growth = np.zeros(())
    for _ in range(steps):
        weights = student_weights(squares, nu)
        weighted = weights * squares
        square = weighted.mean(axis=-1, keepdims=True)
        weight = weights.mean(axis=-1, keepdims=True)
        factor = 3 * weight / square
        squares = squares * factor
        growth = growth + np.log(factor)
    return squares, growth


def degrees_of_freedom(squares: np.ndarray) -> float:
    """Return the most plausible nu of errors by (anything in proportion to) e^T C^-1 e, (N,)."""
    if not squares.any():
        return NU
    count, nu = len(squares), TAILS[:, None]
    errors, growth = fitted_squares(squares[None], nu, SCALE_STEPS)
    log_kernels = np.log1p(errors / nu).sum(axis=1)
    log_densities = 1.5 * count * growth[:, 0]
    log_densities -= 0.5 * (TAILS + 3) * log_kernels
    for k, tried in enumerate(TAILS.tolist()):
        log_densities[k] += count * log_constant(tried) + log_prior(tried)
    best = int(np.argmax(log_densities))
    aside = 0.0
    if 0 < best < len(TAILS) - 1:  # the top of the parabola through three
        before, peak, after = log_densities[best - 1 : best + 2].tolist()
        bend = before - 2 * peak + after
        aside = 0.5 * (before - after) / bend
    ratio = TAILS[1] / TAILS[0]
    return float(TAILS[best] * ratio**aside)


def log_constant(nu: float) -> float:
    """Return the logarithm of Student's density of a 3-vector of size 0, for a scale of I."""
    numerator = lgamma((nu + 3) / 2)
    denominator = lgamma(nu / 2) + 1.5 * log(nu * pi)
    return numerator - denominator


def log_prior(nu: float) -> float:
    """Return the logarithm of the prior density of log nu, but for a constant."""
    return 2 * log(nu) - nu / LIGHT_TAILS

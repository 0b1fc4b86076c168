"""What bends a joint away from the angle that its encoder reads.

The true joint positions follow from those read by

    q' = q - c tau + sum over k = 1, 2 of a_k sin(k q) + b_k cos(k q)

joint by joint: c >= 0 is the joint's compliance [rad/(N m)], tau the torque that it exerts on
the arm to hold it, a_k and b_k the harmonics of its transmission error [rad].
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

__all__ = ["COMPLIANCE", "EXTENSIONS", "TRANSMISSION", "Deflection", "coefficient_names", "design"]

COMPLIANCE = "compliance"
TRANSMISSION = ("harmonic_1", "harmonic_2")
EXTENSIONS = (COMPLIANCE, *TRANSMISSION)


def design(extension: str, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Return how an extension's coefficients shift the joint positions.

    Args:
        extension: One of :data:`EXTENSIONS`.
        q: Joint positions as read, shape (N, m).
        torque: Joint torques, shape (N, m).

    Returns:
        Derivatives of q' by the coefficients, shape (N, m, p): p = m compliances, or p = 2 m
        sines and cosines, sines first.
    """
    one_each = np.eye(q.shape[1])
    if extension == COMPLIANCE:
        return -torque[:, :, None] * one_each
    k = TRANSMISSION.index(extension) + 1
    sines, cosines = np.sin(k * q)[:, :, None], np.cos(k * q)[:, :, None]
    return np.concatenate([sines * one_each, cosines * one_each], axis=2)


def coefficient_names(extension: str, joints: Sequence[str]) -> list[str]:
    """Return the names of an extension's coefficients, in the order of :func:`design`."""
    if extension == COMPLIANCE:
        return [f"{joint}.compliance" for joint in joints]
    k = TRANSMISSION.index(extension) + 1
    return [f"{joint}.{wave}{k}" for wave in ("sin", "cos") for joint in joints]


@dataclass(frozen=True)
class Deflection:
    """The calibrated extensions of a robot."""

    extensions: tuple[str, ...] = ()
    """Those that the data support, among :data:`EXTENSIONS`."""
    coefficients: tuple[np.ndarray, ...] = ()
    """Their coefficients, each in the order of :func:`design`."""

    def true_positions(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return q', the joint positions that geometry may be applied to, shape (N, m)."""
        shifts = [
            design(extension, q, torque) @ values
            for extension, values in zip(self.extensions, self.coefficients, strict=True)
        ]
        return q + sum(shifts, np.zeros_like(q))

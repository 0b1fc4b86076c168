"""Joint compliance and transmission error: why a joint is not quite where its encoder says.

The true joint positions follow from those read by

    q' = q - c tau + sum over k = 1, 2 of a_k sin(k q) + b_k cos(k q)

joint by joint, where

    q      position as the encoder reads it [rad]
    q'     true position, to which the geometry may be applied [rad]
    c      compliance, >= 0: how far the joint twists under load [rad/(N m)]
    tau    torque that the joint exerts to hold the arm, at rest the gravity torque [N m]
    a, b   the two coefficients of each harmonic of the transmission error [rad]

A harmonic is a sine wave that repeats k times a turn, see docs/model.md.
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

    The shift is linear in the coefficients: q' - q = design @ coefficients.

    Args:
        extension: One of :data:`EXTENSIONS`.
        q: Joint positions as the encoders read them, shape (N, m) [rad].
        torque: Joint torques, shape (N, m) [N m].

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
    """The compliance and transmission error of a robot's joints, as calibrated."""

    extensions: tuple[str, ...] = ()
    """Which extensions the data support, among :data:`EXTENSIONS`."""
    coefficients: tuple[np.ndarray, ...] = ()
    """Their coefficients, each in the order of :func:`design`."""

    def true_positions(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the true joint positions q'.

        Args:
            q: Joint positions as the encoders read them, shape (N, m) [rad].
            torque: Joint torques, shape (N, m) [N m].

        Returns:
            Shape (N, m) [rad].
        """
        shifts = [
            design(extension, q, torque) @ values
            for extension, values in zip(self.extensions, self.coefficients, strict=True)
        ]
        return q + sum(shifts, np.zeros_like(q))

"""Elasticity and transmission error: why a joint is not quite where its encoder says.

The true joint positions follow from those read by

    q' = q + z - c tau - p side(tau) + sum over k = 1, 2 of a_k sin(k q) + b_k cos(k q)
    side(tau) = tau / sqrt(tau^2 + tau_0^2)

joint by joint. Joints and links bend about the two axes across as well, by the tilts

    u = -d M_b        v = -e M_c

Here

    q      position as the encoder reads it [rad]
    q'     true position, to which the geometry may be applied [rad]
    z      zero: by how much the encoder reads too little [rad]
    c      compliance, >= 0: how far the joint twists under load [rad/(N m)]
    tau    torque that the joint exerts to hold the arm, at rest the gravity torque [N m]
    p      half the play of the gears: the joint rests where gravity turns it to [rad]
    tau_0  0.02 N m: under less, the joint may rest on either side, see :func:`backlash`
    d, e   the same about the two axes across the joint's own, b and c of
           :func:`mukca.solver.robot.kinematics.across`
    M_b    moment that holds the arm about that axis, from the model's masses [N m]
    a, b   the two coefficients of each harmonic of the transmission error [rad]

A harmonic is a sine wave that repeats k times a turn, see docs/model.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

COMPLIANCE = "compliance"
TILT = "tilt"
ELASTICITY = (COMPLIANCE, TILT)
"""What bends in proportion to its load: never negative, since nothing gives way against it."""
ZERO = "zero"
PLAY = "play"
TRANSMISSION = ("harmonic_1", "harmonic_2")
EXTENSIONS = (ZERO, *ELASTICITY, PLAY, *TRANSMISSION)
LEAST_TORQUE = 0.02
"""tau_0 [N m]."""
FIRM = 0.02
"""Share of an unloaded joint's variance that is left under load."""


def design(
    extensions: Sequence[str], q: np.ndarray, moments: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return how the coefficients of some extensions shift the joint positions and tilts.

    Each coefficient shifts one of them, in proportion to itself.

    Args:
        extensions: Among :data:`EXTENSIONS`.
        q: Joint positions as the encoders read them, shape (N, m) [rad].
        moments: What holds the joints, shape (N, 3 m) [N m]: torques about their own axes, then
            moments about those across. Without tilt, the torques alone are enough, shape (N, m).

    Returns:
        Which of q', of the tilts u and of the tilts v, counted in this order, each of the p
        coefficients shifts, extension after extension, shape (p,); and the derivatives of that by
        the coefficient, shape (N, p). Sines come before cosines.
    """
    m = int(q.shape[1])
    own: np.ndarray = np.arange(m)
    shifted: list[np.ndarray] = [own[:0]]
    parts: list[np.ndarray] = [np.zeros((len(q), 0))]
    for extension in extensions:
        if extension == TILT:
            shifted += [m + own, 2 * m + own]
            parts.append(-moments[:, m:])
            continue
        shifted.append(own)
        if extension == COMPLIANCE:
            parts.append(-moments[:, :m])
        elif extension == ZERO:
            parts.append(np.ones((len(q), m)))
        elif extension == PLAY:
            parts.append(-_sides(moments[:, :m]))
        else:
            k = TRANSMISSION.index(extension) + 1
            shifted.append(own)
            parts += [np.sin(k * q), np.cos(k * q)]
    return np.concatenate(shifted), np.concatenate(parts, axis=1)


def deflected(
    q: np.ndarray, shifted: np.ndarray, shifts: np.ndarray, coefficients: np.ndarray
) -> np.ndarray:
    """Return the true joint positions, followed by the tilts where there are any.

    Args:
        q: Joint positions as the encoders read them, shape (N, m) [rad].
        shifted: What :func:`design` returns for them,
        shifts: and for the same extensions.
        coefficients: Of these extensions, one after the other, shape (p,).
    """
    m = q.shape[1]
    onto = np.eye(3 * m if (shifted >= m).any() else m)[shifted]
    true = (shifts * coefficients) @ onto
    true[:, :m] += q
    return true


def backlash(torque: np.ndarray) -> np.ndarray:
    """Return how uncertain play makes each joint's position, as a share of a joint's without load.

    The angle of such a joint is noisy by half its play; one that carries a load lies on one side.

    Args:
        torque: What holds the joints, shape (N, m) [N m].

    Returns:
        Factors of the noise of the joint positions, shape (N, m).
    """
    return np.sqrt(np.maximum(1 - _sides(torque) ** 2, FIRM))


def _sides(torque: np.ndarray) -> np.ndarray:
    return torque / np.sqrt(torque**2 + LEAST_TORQUE**2)


def coefficient_names(extension: str, joints: Sequence[str]) -> list[str]:
    """Return the names of an extension's coefficients, in the order of :func:`design`."""
    if extension in (ZERO, COMPLIANCE, PLAY):
        return [f"{joint}.{extension}" for joint in joints]
    if extension == TILT:
        return [f"{joint}.tilt{k}" for k in (1, 2) for joint in joints]
    k = TRANSMISSION.index(extension) + 1
    return [f"{joint}.{wave}{k}" for wave in ("sin", "cos") for joint in joints]


@dataclass(frozen=True)
class Deflection:
    """The elasticity and transmission error of a robot's joints, as calibrated."""

    extensions: tuple[str, ...] = ()
    """Which extensions the data support, among :data:`EXTENSIONS`."""
    coefficients: tuple[np.ndarray, ...] = ()
    """Their coefficients, each in the order of :func:`design`."""

    @property
    def zeros(self) -> np.ndarray | None:
        """What to add to the encoders' readings, shape (m,) [rad]; None if not looked for."""
        return dict(zip(self.extensions, self.coefficients, strict=True)).get(ZERO)

    @property
    def without_joint_offsets(self) -> "Deflection":
        """The rest, for a geometry that holds the zeros in its origins."""
        if ZERO not in self.extensions:
            return self
        return Deflection(self.extensions[1:], self.coefficients[1:])

    def true_positions(self, q: np.ndarray, moments: np.ndarray) -> np.ndarray:
        """Return the true joint positions q', followed by the tilts where there are any.

        Args:
            q: Joint positions as the encoders read them, shape (N, m) [rad].
            moments: What holds the joints, as for :func:`design`.

        Returns:
            Shape (N, m), or with tilts (N, 3 m) [rad].
        """
        coefficients = np.concatenate([np.zeros(0), *self.coefficients])
        return deflected(q, *design(self.extensions, q, moments), coefficients)

"""Rigid transforms as 4 x 4 matrices, and the numbers of a URDF origin for one."""

import math
from collections.abc import Sequence

import casadi as ca
import numpy as np

from ...solver.robot.kinematics import rotation, rotation_rpy
from ...solver.robot.urdf import Joint

__all__ = ["moved", "origin_near", "rigid", "to_axis"]


def rigid(origin: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the transform of a URDF origin: x y z [m], roll pitch yaw [rad]."""
    T = np.eye(4)
    T[:3, :3] = rotation_rpy(ca.DM(np.asarray(origin[3:], dtype=float))).full()
    T[:3, 3] = origin[:3]
    return T


def moved(joint: Joint, q: float) -> np.ndarray:
    """Return the transform by which a joint at position q moves its child link."""
    T = np.eye(4)
    if joint.type == "prismatic":
        T[:3, 3] = np.array(joint.axis) * q
    else:
        T[:3, :3] = rotation(joint.axis, ca.DM(q)).full()
    return T


def to_axis(axis: Sequence[float]) -> np.ndarray:
    """Return a turn that carries the z axis to another axis, as small as it can be."""
    x, y, z = axis
    turn = np.array([-y, x, 0.0])
    sine = float(np.linalg.norm(turn))
    if sine < 1e-12:
        return np.diag([1.0, math.copysign(1, z), math.copysign(1, z), 1.0])
    T = np.eye(4)
    T[:3, :3] = rotation((turn / sine).tolist(), ca.DM(math.atan2(sine, z))).full()
    return T


def origin_near(T: np.ndarray, nominal: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the URDF origin of a transform, with its angles as near to others as they can be.

    A rotation has two sets of roll, pitch and yaw, and infinitely many where the pitch is 90
    degrees; all of them may be turned by 360 degrees.

    Args:
        T: The transform.
        nominal: x y z roll pitch yaw; only the angles count.

    Returns:
        x y z [m], roll pitch yaw [rad], shape (6,).
    """
    R, near = T[:3, :3], np.asarray(nominal[3:], dtype=float)
    cosine = math.hypot(R[0, 0], R[1, 0])
    pitch = math.atan2(-R[2, 0], cosine)
    if cosine > 1e-9:
        roll, yaw = math.atan2(R[2, 1], R[2, 2]), math.atan2(R[1, 0], R[0, 0])
    else:
        sign = -math.copysign(1, R[2, 0])  # only roll -+ yaw is known
        roll, known = near[0], math.atan2(-R[0, 1], R[1, 1])
        yaw = known + sign * roll
    both = np.array([[roll, pitch, yaw], [roll + math.pi, math.pi - pitch, yaw + math.pi]])
    both -= 2 * math.pi * np.round((both - near) / (2 * math.pi))
    best = both[int(np.argmin(np.abs(both - near).sum(axis=1)))]
    return np.concatenate([T[:3, 3], best])

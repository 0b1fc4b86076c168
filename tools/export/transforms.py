"""Rigid transforms as 4 x 4 matrices, and the numbers of a URDF origin for one."""

import math
from collections.abc import Sequence

import casadi as ca
import numpy as np

from ...solver.auto.zeros import angles_near
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

    Args:
        T: The transform.
        nominal: x y z roll pitch yaw; only the angles count.

    Returns:
        x y z [m], roll pitch yaw [rad], shape (6,).
    """
    near = np.asarray(nominal[3:], dtype=float)
    return np.concatenate([T[:3, 3], angles_near(T[:3, :3], near)])

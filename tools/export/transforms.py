"""Rigid transforms as 4 x 4 matrices, and the numbers of a URDF origin for one."""

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import casadi as ca
import numpy as np

from ...solver.bayes.results import angles_near
from ...solver.robot import rotation, rotation_rpy


def rigid(origin: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the transform of a URDF origin: x y z [m], roll pitch yaw [rad]."""
    return _rigid()(origin).full()


@cache
def _rigid() -> Any:
    origin = ca.SX.sym("origin", 6)
    T = ca.vertcat(ca.horzcat(rotation_rpy(origin[3:]), origin[:3]), ca.DM([[0, 0, 0, 1]]))
    return ca.Function("rigid", [origin], [ca.densify(T)])


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

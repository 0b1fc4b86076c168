"""Joint origins as 4 x 4 transforms, and for formats that carry only some of the joints."""

import math
from collections.abc import Collection, Sequence

import numpy as np

from ...solver.bayes.results import angles_near
from ...solver.data import Pose, turn
from ...solver.robot import Origin
from .request import Request


def rigid(origin: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the transform of a URDF origin: x y z [m], roll pitch yaw [rad]."""
    return Pose.of(Origin.of(origin)).matrix


def to_axis(axis: Sequence[float]) -> np.ndarray:
    """Return the smallest turn that carries the z axis to another axis."""
    x, y, z = axis
    sine = math.hypot(x, y)
    if sine < 1e-12:
        return np.diag([1.0, math.copysign(1, z), math.copysign(1, z), 1.0])
    T = np.eye(4)
    T[:3, :3] = turn(np.array([-y, x, 0.0]) * (math.atan2(sine, z) / sine))
    return T


def redistributed_origins(request: Request, carried: Collection[str]) -> dict[str, np.ndarray]:
    """Return origins of some joints that give the calibrated arm while all others stay nominal.

    The change of a joint that is not carried goes into the next one that is. Origins before which
    nothing else changed are returned as they are, to the last digit; each has the shape (6,).
    """
    origins: dict[str, np.ndarray] = {}
    change, changed = np.eye(4), False
    for joint, origin in zip(request.calibration.robot.joints, request.origins, strict=True):
        nominal = np.array(joint.origin.xyz + joint.origin.rpy)
        if joint.name in carried:
            origins[joint.name] = origin
            if changed:
                T = change @ rigid(origin)
                angles = angles_near(T[:3, :3], nominal[3:])
                origins[joint.name] = np.concatenate([T[:3, 3], angles])
            change, changed = np.eye(4), False
        elif changed or np.any(origin != nominal):
            change, changed = np.linalg.inv(rigid(nominal)) @ change @ rigid(origin), True
    return origins


def after_last_exported(request: Request, carried: Collection[str]) -> list[str]:
    """Return the joints after the last carried one, whose changes no origin can take."""
    names = [joint.name for joint in request.calibration.robot.joints]
    return names[1 + max(i for i, name in enumerate(names) if name in carried) :]

"""Zeros of joints, put into the geometry."""

import math
from collections.abc import Sequence

import numpy as np

from ...data import Pose
from ...robot import BallModel, Parameter, rotation, rotation_rpy
from ..inference import Posterior

DECIDED = math.radians(0.2)
"""The data decide a zero if its standard deviation is no larger: it is then within 0.4 degrees, by
95 %. On simulated arms with play, whose deviations come true, more would promise too much."""


def joint_offsets_in_words(posterior: Posterior) -> str:
    """Return what was found of each joint's zero, and which the data do not decide."""
    begin = posterior.model.geometry
    variances = np.diag(posterior.covariance)[begin:]
    words = [
        f"{joint} {math.degrees(zero):+.2f} +- {math.degrees(variance**0.5):.2f} deg"
        + (" (not decided)" if variance > DECIDED**2 else "")
        for joint, zero, variance in zip(
            posterior.model.robot.joint_names, posterior.x[begin:], variances, strict=False
        )
    ]
    return f"joint offsets: {', '.join(words)}"


def with_joint_offsets(posterior: Posterior) -> np.ndarray:
    """Return the geometric parameters of a model, its zeros put into them, shape (geometry,)."""
    offsets, model = posterior.deflection.joint_offsets, posterior.model
    if offsets is None:
        return posterior.values
    return offsets_in_origins(model.ball, model.parameters, posterior.values, offsets)


def offsets_in_origins(
    model: BallModel, parameters: Sequence[Parameter], values: np.ndarray, offsets: np.ndarray
) -> np.ndarray:
    """Return geometric parameters with zeros of the joints put into them, shape (geometry,).

    All of the origin of a joint whose zero is not 0 is free; zeros have shape (m,) [rad, m].
    """
    values, origins = values.copy(), model.origins(values)
    place = {parameter.index: i for i, parameter in enumerate(parameters)}
    for joint, offset in zip(model.robot.actuated, offsets.tolist(), strict=True):
        j = model.robot.joints.index(joint)
        if not offset:
            continue
        R = rotation_rpy(origins[j, 3:].tolist()).full()
        if joint.type == "prismatic":
            values[[place[6 * j + k] for k in range(3)]] += R @ np.array(joint.axis) * offset
            continue
        turned = R @ rotation(joint.axis, offset).full()
        values[[place[6 * j + k] for k in (3, 4, 5)]] = angles_near(turned, origins[j, 3:])
    return values


def angles_near(R: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw of a rotation, of all its sets the nearest to others [rad]."""
    roll, pitch, yaw = Pose(R, np.zeros(3)).origin.rpy
    if np.hypot(R[0, 0], R[1, 0]) < 1e-9:  # only roll -+ yaw is known
        roll, yaw = near[0], yaw - np.copysign(1, R[2, 0]) * near[0]
    both = np.array([[roll, pitch, yaw], [roll + np.pi, np.pi - pitch, yaw + np.pi]])
    both -= 2 * np.pi * np.round((both - near) / (2 * np.pi))
    return both[int(np.argmin(np.abs(both - near).sum(axis=1)))]

"""Zeros of joints, put into the geometry."""

from collections.abc import Sequence

import numpy as np

from ..robot import BallModel, Parameter, angles_near, rotation
from .posterior import Posterior

NONE = 1e-7
"""A zero that is held is smaller [rad], [m]."""


def with_joint_offsets(posterior: Posterior) -> np.ndarray:
    """Return the geometric parameters of a model, its zeros put into them, shape (geometry,)."""
    offsets = posterior.deflection.joint_offsets
    model = posterior.model
    if offsets is None:
        return posterior.values
    return offsets_in_origins(model.ball, model.parameters, posterior.values, offsets)


def offsets_in_origins(
    model: BallModel,
    parameters: Sequence[Parameter],
    values: np.ndarray,
    offsets: np.ndarray,
) -> np.ndarray:
    """Return geometric parameters with zeros of the joints put into them, shape (geometry,).

    All of the origin of a joint whose zero is not 0 is free; zeros have shape (m,) [rad, m].
    """
    frames = model.frames(values)
    origins = model.origins(values)
    place = {parameter.index: i for i, parameter in enumerate(parameters)}
    changed: list[int] = []
    pairs = zip(model.robot.actuated, offsets.tolist(), strict=True)
    for joint, offset in pairs:
        if abs(offset) < NONE:
            continue
        j = model.robot.joints.index(joint)
        R = frames[j, :, 1:4]
        if joint.type == "prismatic":
            along = R @ np.array(joint.axis)
            origins[j, :3] += along * offset
            columns = (0, 1, 2)
        else:
            turn = rotation(joint.axis, offset)
            angles = origins[j, 3:]
            origins[j, 3:] = angles_near(R @ turn.full(), angles)
            columns = (3, 4, 5)
        changed += [place[6 * j + k] for k in columns]
    with_offsets = values.copy()
    at_origins = model.parameters_at(origins)
    with_offsets[changed] = at_origins[changed]
    return with_offsets

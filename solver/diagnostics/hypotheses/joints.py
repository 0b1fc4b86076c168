"""Joints: a zero that is wrong or was lost, a gain, or readings that lag behind the arm."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from .base import changes
from .kinds import Block, Kind, Parameters, sample_named
from .scene import Scene

ZEROS, LOST, GAINS, LAGS = (0.03, 0.2), (3e-3, 0.05), (0.02,), (3e-3, 0.05)
"""Typical sizes: offsets [rad, m], shares of the reading, and of the last step."""


def _each(scene: Scene, turned: np.ndarray, widths: tuple[float, ...]) -> Iterable[Block]:
    """Return the block of joints that are each off in proportion to something, shape (N, m)."""
    columns = -(scene.by_joints * turned[:, None, :]).reshape(-1, turned.shape[1])
    names = [{"joint": name} for name in scene.robot.joint_names]
    yield Block(scene.all_samples, columns.T[:, :, None], names, widths)


def of_zero(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that are off throughout."""
    return () if scene.zeros else _each(scene, np.ones_like(scene.q), ZEROS)


def of_gain(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that read too much by a share."""
    return _each(scene, scene.q, GAINS)


def of_lost_zero(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that are off from some sample of a placement on."""
    names = scene.robot.joint_names
    for block in changes(scene, -scene.by_joints[:, :, :, None], LOST):
        each = enumerate(block.parameters)
        parameters = [{"joint": names[i % len(names)], **first} for i, first in each]
        yield replace(block, parameters=parameters)


def of_lag(scene: Scene) -> Iterable[Block]:
    """Return the block of readings that are behind the arm by a share of the last step."""
    step = np.zeros_like(scene.q)
    for place, rows in enumerate(scene.places):
        own, order = scene.q[rows], np.argsort(scene.times[place])
        late = np.zeros_like(own)
        late[order[1:]] = own[order[:-1]] - own[order[1:]]
        step[rows] = late
    columns = -np.einsum("nij,nj->ni", scene.by_joints, step).reshape(1, -1, 1)
    yield Block(scene.all_samples, columns, [{}], LAGS)


def offset(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the parameters with how much a joint is off [rad, m], or its share."""
    return {**parameters, "offset": -float(values[0])}


def _degrees(p: Parameters) -> str:
    return f"{np.rad2deg(p['offset']):+.2f} deg"


ZERO = Kind(
    "zero",
    0.06,
    lambda p: f"{p['joint']} looks off by {_degrees(p)}",
    "set the joint's zero, or choose the model of this robot's version",
    "move the joint to its zero mark, and read what it says",
    blocks=of_zero,
    values=offset,
)
ZERO_LOST = Kind(
    "zero_lost",
    0.03,
    lambda p: f"{p['joint']} is off by {_degrees(p)} from {sample_named(p)} on",
    "home the joint again, and record it again",
    "move the joint to its zero mark, and read what it says",
    code="zero",
    blocks=of_lost_zero,
    values=offset,
)
GAIN = Kind(
    "gain",
    0.02,
    lambda p: (
        f"{p['joint']} reads {100 * abs(p['offset']):.2f} % too "
        f"{'much' if p['offset'] > 0 else 'little'}"
    ),
    "look for a wrong gear ratio or unit of that joint in the driver",
    "turn the joint by a known angle, and read what it says",
    blocks=of_gain,
    values=offset,
)
LAG = Kind(
    "lag",
    0.02,
    lambda p: f"the readings are behind the arm by {100 * abs(p['offset']):.1f} % of each move",
    "wait until the arm stands still before each sample",
    "take a sample twice, at once and a second later",
    blocks=of_lag,
    values=offset,
)

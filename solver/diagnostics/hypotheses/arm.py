"""The arm: a number of its URDF wrong, another version or arm, a joint's zero or gain, or a lag."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from .base import changes
from .kinds import Block, Parameters
from .scene import Scene

LENGTHS, ANGLES = (5e-3, 0.03), (0.03, 0.15)
"""Typical errors of a URDF's numbers [m], [rad]."""
VERSION = 10.0
"""Another version's model is off by so many times as much as an arm from its own."""
ZEROS, LOST, GAINS, LAGS = (0.03, 0.2), (3e-3, 0.05), (0.02,), (3e-3, 0.05)
"""Typical sizes: offsets [rad, m], shares of the reading, and of the last step."""


def of_number(scene: Scene, unit: str, widths: tuple[float, ...]) -> Iterable[Block]:
    """Return the block of a model's numbers in a unit, one of which is wrong."""
    chosen = [i for i, p in enumerate(scene.parameters) if p.unit == unit and not p.of_ball]
    of = [scene.parameters[i] for i in chosen]
    names = [{"joint": p.joint, "component": p.component} for p in of]
    columns = scene.by_geometry[:, chosen].T[:, :, None]
    yield Block(scene.all_samples, columns, names, widths)


def of_version(scene: Scene) -> Iterable[Block]:
    """Return the block of a model all of whose numbers are wrong."""
    of_links = VERSION * ~np.array([p.of_ball for p in scene.parameters])
    yield Block(scene.all_samples, (scene.by_geometry * of_links @ scene.usual)[None], [{}])


def of_other_arm(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements that another arm of the type recorded."""
    for place, rows in enumerate(scene.places if len(scene.places) > 1 else ()):
        own = scene.rows(rows)
        columns = (scene.by_geometry[own] @ scene.usual)[None]
        yield Block(own, columns, [scene.named(place)], (1.4,))


def _each(scene: Scene, turned: np.ndarray, widths: tuple[float, ...]) -> Iterable[Block]:
    """Return the block of joints that are each off in proportion to something, shape (N, m)."""
    columns = -(scene.by_joints * turned[:, None, :]).reshape(-1, turned.shape[1])
    names = [{"joint": name} for name in scene.robot.joint_names]
    yield Block(scene.all_samples, columns.T[:, :, None], names, widths)


def of_zero(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that are off throughout."""
    return _each(scene, np.ones_like(scene.q), ZEROS)


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
    for rows, times in zip(scene.places, scene.times, strict=True):
        order = rows.start + np.argsort(times)
        step[order[1:]] = scene.q[order[:-1]] - scene.q[order[1:]]
    columns = -np.einsum("nij,nj->ni", scene.by_joints, step).reshape(1, -1, 1)
    yield Block(scene.all_samples, columns, [{}], LAGS)


def offset(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how much a joint is off [rad, m], or its share."""
    return {"offset": -float(values[0])}


def error(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the error of the model's number [m, rad]."""
    return {"error": -float(values[0])}

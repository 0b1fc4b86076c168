"""The arm: a number of its URDF wrong, another version or arm, a joint's zero or gain, or a lag."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import cycle

import numpy as np

from ...bayes.model.effects import TILT
from ...robot import COMPONENTS, Joint, link_axes
from .base import changes
from .kinds import Block, Parameters, of_samples
from .scene import Scene

LENGTHS, ANGLES = (5e-3, 0.03), (0.03, 0.15)
"""Typical errors of a URDF's numbers [m], [rad]."""
SINGLE = 0.1
"""Share of the largest error of an origin's numbers, up to which the others count as none."""
VERSION = 10.0
"""Another version's model is off by so many times as much as an arm from its own."""
ZEROS, LOST, GAINS, LAGS = (0.03, 0.2), (3e-3, 0.05), (0.02,), (3e-3, 0.05)
"""Typical sizes: offsets [rad, m], shares of the reading, and of the last step."""
UNEVEN, TURNS = (1e-3, 1e-2), ("once", "twice")
"""Amplitudes of joints that turn unevenly [rad], and words for how often in a turn."""
TILTS = (2e-3, 2e-2)
"""Angles by which a base gives way under the arm [rad]."""
AXES = "bca"
"""Names of the axes of a link: the two about which its joint tilts, and the joint's own."""


def of_origin(scene: Scene, unit: str, widths: tuple[float, ...]) -> Iterable[Block]:
    """Return blocks of joints whose origins are wrong: along one axis of a link, or anyhow.

    The axes are those of :func:`.link_axes`, so that how a URDF's frames are drawn does not count.
    """
    joints = [
        joint for joint in scene.robot.joints if joint is not scene.robot.ball_joint
    ]
    of_joints = {joint.name: _directions(scene, joint, unit) for joint in joints}
    of_joints = {
        name: directions for name, directions in of_joints.items() if directions.any()
    }
    if not of_joints:
        return
    axes: list[Parameters] = []
    of_axes: list[np.ndarray] = []
    for name, directions in of_joints.items():
        for axis, direction in zip(AXES, directions.T, strict=True):
            if direction.any():
                axes.append({"joint": name, "axis": axis})
                of_axes.append(direction[:, None])
    yield Block(scene.all_samples, scene.by_geometry @ np.array(of_axes), axes, widths)
    columns = scene.by_geometry @ np.array([*of_joints.values()])
    yield Block(
        scene.all_samples, columns, [{"joint": name} for name in of_joints], widths
    )


def _directions(scene: Scene, joint: Joint, unit: str) -> np.ndarray:
    """Return the changes of the geometry by which a joint moves along three axes, shape (n, 3)."""
    i, parameters = scene.robot.joints.index(joint), scene.parameters
    indices = [
        k for k, p in enumerate(parameters) if p.joint == joint.name and p.unit == unit
    ]
    components = [parameters[k].index % 3 for k in indices]
    link = i if unit == "m" else i + 1
    directions = np.zeros((len(parameters), 3))
    if len(indices) == 3:
        directions[indices] = link_axes(scene.robot)[link]
    else:
        directions[indices] = np.eye(3)[components]
    return directions


def of_version(scene: Scene) -> Iterable[Block]:
    """Return the block of a model all of whose numbers are wrong."""
    of_links = ~np.array([p.of_ball for p in scene.parameters])
    columns = scene.by_geometry * (VERSION * of_links) @ scene.usual
    yield Block(scene.all_samples, columns[None], [{}])


def of_other_arm(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements that another arm of the type recorded."""
    for place, samples in enumerate(scene.places if len(scene.places) > 1 else ()):
        rows = scene.rows(samples)
        columns = scene.by_geometry[rows] @ scene.usual
        yield Block(rows, columns[None], [scene.named(place)], (1.4,))


def _each(
    scene: Scene, turns: np.ndarray, widths: tuple[float, ...], **names: str
) -> Iterable[Block]:
    """Return the block of joints that each read too much by their turns, shape (N, m, k)."""
    columns = -scene.by_joints[..., None] * turns[:, None]
    joints = [{"joint": name, **names} for name in scene.robot.joint_names]
    yield of_samples(scene.every, columns.transpose(2, 0, 1, 3), joints, widths)


def of_zero(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that are off throughout."""
    return _each(scene, np.ones((*scene.q.shape, 1)), ZEROS)


def of_gain(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that read too much by a share."""
    return _each(scene, scene.q[..., None], GAINS)


def of_uneven(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that lead and lag once a turn, or twice, more than gears do."""
    for times, word in enumerate(TURNS, 1):
        phases = times * scene.q
        waves = np.stack([np.sin(phases), np.cos(phases)], axis=2)
        yield from _each(scene, waves, UNEVEN, turn=word)


def of_soft_base(scene: Scene) -> Iterable[Block]:
    """Return the block of a base that tilts under the arm, as its first joint would, but more."""
    if TILT not in scene.effects or not scene.torques.any():
        return
    m = scene.q.shape[1]
    bends: np.ndarray = TILT.turns(scene.as_readings)[:, [0, m]]
    squares: np.ndarray = np.sum(bends**2, axis=1)
    scale = max(float(squares.mean()) ** 0.5, 1e-6)
    tilts = scene.model.slices[scene.effects.index(TILT)]
    of_first_joint = [tilts.start, tilts.start + m]
    columns = -scene.linear[1][:, :, of_first_joint] / scale
    yield of_samples(scene.every, columns, [{}], TILTS)


def of_lost_zero(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that are off from some sample of a placement on."""
    joints = cycle(scene.robot.joint_names)
    for block in changes(scene, -scene.by_joints[..., None], LOST):
        names = [{"joint": next(joints), **first} for first in block.parameters]
        yield replace(block, parameters=names)


def of_lag(scene: Scene) -> Iterable[Block]:
    """Return the block of readings that are behind the arm by a share of the last step."""
    step = np.zeros_like(scene.q)
    for rows, times in zip(scene.places, scene.times, strict=True):
        order = rows.start + np.argsort(times)
        step[order[1:]] = -np.diff(scene.q[order], axis=0)
    columns = -scene.by_joints @ step[:, :, None]
    yield of_samples(scene.every, columns, [{}], LAGS)


def offset(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how much a joint is off [rad, m], or its share."""
    return {"offset": -float(values[0])}


def error(
    scene: Scene, parameters: Parameters, values: np.ndarray, unit: str
) -> Parameters:
    """Return which number of an origin in the URDF is wrong, and by how much [m], [rad].

    Where it is no single one, it is how far the joint is displaced, or turned, in all.
    """
    joints = scene.robot.joints
    i = next(i for i, joint in enumerate(joints) if joint.name == parameters["joint"])
    directions = _directions(scene, joints[i], unit)
    if "axis" in parameters:
        directions = directions[:, [AXES.index(parameters["axis"])]]
    change = directions @ values
    ball = scene.model.ball
    wrong = scene.robot.origins[i] - ball.origins(ball.nominal + change)[i]
    first = 0 if unit == "m" else 3
    errors = wrong[first : first + 3]
    largest = int(np.argmax(np.abs(errors)))
    value = float(errors[largest])
    if float(np.linalg.norm(np.delete(errors, largest))) > SINGLE * abs(value):
        part = "place" if unit == "m" else "rotation"
        return {
            "component": part,
            "error": float(np.linalg.norm(change)),
            "sense": "off",
        }
    sense = "too large" if value > 0 else "too small"
    return {"component": COMPONENTS[first + largest], "error": value, "sense": sense}

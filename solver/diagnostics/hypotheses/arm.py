"""The arm: a number of its URDF wrong, another version or arm, a joint's zero or gain, or a lag."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from ...bayes.model.effects import TILT
from ...robot import COMPONENTS, BallModel, Joint, link_axes
from .base import changes
from .kinds import Block, Parameters
from .scene import Scene

LENGTHS, ANGLES = (5e-3, 0.03), (0.03, 0.15)
"""Typical errors of a URDF's numbers [m], [rad]."""
SINGLE = 0.1
"""Share of the largest error of an origin's numbers, up to which the others count as none."""
VERSION = 10.0
"""Another version's model is off by so many times as much as an arm from its own."""
ZEROS, LOST, GAINS, LAGS = (0.03, 0.2), (3e-3, 0.05), (0.02,), (3e-3, 0.05)
"""Typical sizes: offsets [rad, m], shares of the reading, and of the last step."""
UNEVEN, TURNS = (1e-3, 1e-2), {1: "once", 2: "twice"}
"""Amplitudes of joints that turn unevenly [rad], and words for how often in a turn."""
TILTS = (2e-3, 2e-2)
"""Angles by which a base gives way under the arm [rad]."""
AXES = "bca"
"""Names of the axes of a link: the two about which its joint tilts, and the joint's own."""


def of_origin(scene: Scene, unit: str, widths: tuple[float, ...]) -> Iterable[Block]:
    """Return blocks of joints whose origins are wrong: along one axis of a link, or anyhow.

    The axes are those of :func:`.link_axes`, so that how a URDF's frames are drawn does not count.
    """
    joints = [joint for joint in scene.robot.joints if joint is not scene.robot.ball_joint]
    by_joint = {joint.name: _directions(scene, joint, unit) for joint in joints}
    directions = {name: along for name, along in by_joint.items() if along.any()}
    if not directions:
        return
    axes = [
        (name, k) for (name, along), k in product(directions.items(), range(3)) if along[:, k].any()
    ]
    columns = np.array([scene.by_geometry @ directions[name][:, [k]] for name, k in axes])
    parameters = [{"joint": name, "axis": AXES[k]} for name, k in axes]
    yield Block(scene.all_samples, columns, parameters, widths)
    columns = np.array([scene.by_geometry @ along for along in directions.values()])
    yield Block(scene.all_samples, columns, [{"joint": name} for name in directions], widths)


def _directions(scene: Scene, joint: Joint, unit: str) -> np.ndarray:
    """Return the changes of the geometry by which a joint moves along three axes, shape (n, 3)."""
    i, parameters = scene.robot.joints.index(joint), scene.parameters
    indices = [k for k, p in enumerate(parameters) if p.joint == joint.name and p.unit == unit]
    components = [parameters[k].index % 3 for k in indices]
    axes = link_axes(scene.robot)[i if unit == "m" else i + 1]
    directions = np.zeros((len(parameters), 3))
    directions[indices] = axes if len(indices) == 3 else np.eye(3)[components]
    return directions


def of_version(scene: Scene) -> Iterable[Block]:
    """Return the block of a model all of whose numbers are wrong."""
    of_links = VERSION * ~np.array([p.of_ball for p in scene.parameters])
    yield Block(scene.all_samples, (scene.by_geometry * of_links @ scene.usual)[None], [{}])


def of_other_arm(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements that another arm of the type recorded."""
    for place, rows in enumerate(scene.places if len(scene.places) > 1 else ()):
        rows_of_samples = scene.rows(rows)
        columns = (scene.by_geometry[rows_of_samples] @ scene.usual)[None]
        yield Block(rows_of_samples, columns, [scene.named(place)], (1.4,))


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


def of_uneven(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that lead and lag once a turn, or twice, more than gears do."""
    names = scene.robot.joint_names
    for k in (1, 2):
        phases = k * scene.q
        waves = np.stack([np.sin(phases), np.cos(phases)], axis=2)
        columns = -scene.by_joints[..., None] * waves[:, None]
        flat = columns.transpose(2, 0, 1, 3).reshape(len(names), -1, 2)
        parameters = [{"joint": name, "turn": TURNS[k]} for name in names]
        yield Block(scene.all_samples, flat, parameters, UNEVEN)


def of_soft_base(scene: Scene) -> Iterable[Block]:
    """Return the block of a base that tilts under the arm, as its first joint would, but more."""
    m = scene.q.shape[1]
    names = [effect.name for effect in scene.effects]
    if TILT.name not in names or not scene.torques.any():
        return
    first = scene.model.slices[names.index(TILT.name)].start
    bends: np.ndarray = TILT.turns(scene.as_readings)[:, [0, m]]
    squares: np.ndarray = np.sum(bends**2, axis=1)
    scale = max(float(squares.mean()) ** 0.5, 1e-6)
    columns = -scene.linear[1][:, :, [first, first + m]] / scale
    yield Block(scene.all_samples, columns.reshape(1, -1, 2), [{}], TILTS)


def of_lost_zero(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that are off from some sample of a placement on."""
    names = scene.robot.joint_names
    for block in changes(scene, -scene.by_joints[:, :, :, None], LOST):
        pairs = enumerate(block.parameters)
        parameters = [{"joint": names[i % len(names)], **first} for i, first in pairs]
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


def error(scene: Scene, parameters: Parameters, values: np.ndarray, unit: str) -> Parameters:
    """Return which number of an origin in the URDF is wrong, and by how much [m], [rad].

    Where it is no single one, it is how far the joint is displaced, or turned, in all.
    """
    name = parameters["joint"]
    i = [joint.name for joint in scene.robot.joints].index(name)
    axis = parameters.get("axis")
    along = _directions(scene, scene.robot.joints[i], unit)
    change = (along if axis is None else along[:, [AXES.index(axis)]]) @ values
    ball = BallModel(scene.robot, [p.index for p in scene.parameters])
    errors = scene.robot.origins[i] - ball.origins(ball.nominal + change)[i]
    components = slice(0, 3) if unit == "m" else slice(3, 6)
    size = float(np.linalg.norm(change))
    largest = components.start + int(np.argmax(np.abs(errors[components])))
    remainder = np.delete(errors[components], largest - components.start)
    if float(np.linalg.norm(remainder)) > SINGLE * abs(errors[largest]):
        part = "place" if unit == "m" else "rotation"
        return {"component": part, "error": size, "sense": "off"}
    value = float(errors[largest])
    sense = "too large" if value > 0 else "too small"
    return {"component": COMPONENTS[largest], "error": value, "sense": sense}

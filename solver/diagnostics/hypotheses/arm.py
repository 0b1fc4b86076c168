"""The arm: a number of its URDF wrong, another version or arm, a joint's zero or gain, or a lag."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import cycle
from math import hypot

import numpy as np

from ...identification.effects import TILT
from ...identification.robot import COMPONENTS, Joint, link_axes
from ...results import rms
from .base import changes
from .kinds import Block, Parameters, of_samples
from .scene import Scene

LENGTHS = (5e-3, 0.03)
"""Typical errors of a URDF's lengths [m]."""
ANGLES = (0.03, 0.15)
"""Typical errors of a URDF's angles [rad]."""
SINGLE = 0.1
"""Share of the largest error of an origin's numbers, up to which the others count as none."""
VERSION = 10.0
"""Another version's model is off by so many times as much as an arm from its own."""
OTHERS = (1.4,)
"""Another arm of the type is off by so many times as much as an arm from its model."""
ZEROS = (0.03, 0.2)
"""Typical offsets of a joint [rad, m]."""
LOST = (3e-3, 0.05)
"""Typical offsets of a joint that slipped [rad, m]."""
MOST_SLIPS = 60
"""Samples of a session in which a joint is sought that slips; more take long."""
GAINS = (0.02,)
"""Typical shares by which a joint reads too much."""
LAGS = (3e-3, 0.05)
"""Typical shares of the last step."""
UNEVEN = (1e-3, 1e-2)
"""Amplitudes of joints that turn unevenly [rad]."""
TURNS = ("once", "twice")
"""Number of times that they do in a turn."""
SAGS = (0.01, 0.04)
"""Typical turns of servos under the arm's weight, away from what they are told [rad]."""
TILTS = (2e-3, 2e-2)
"""Angles by which a base gives way under the arm [rad]."""
AXES = "bca"
"""Names of the axes of a link: the two about which its joint tilts, and the joint's own."""


def of_origin(
    scene: Scene,
    unit: str,
    widths: tuple[float, ...],
) -> Iterable[Block]:
    """Return blocks of joints whose origins are wrong: along one axis of a link, or anyhow.

    The axes are those of :func:`.link_axes`, so that how a URDF's frames are drawn does not count.
    """
    along_axes: list[tuple[Parameters, np.ndarray]] = []
    anyhow: list[tuple[Parameters, np.ndarray]] = []
    for joint in scene.robot.joints[:-1]:  # the ball's is the last
        directions = _directions(scene, joint, unit)
        if not directions.any():
            continue
        anyhow.append(({"joint": joint.name}, directions))
        for axis, direction in zip(AXES, directions.T, strict=True):
            if direction.any():
                names = {"joint": joint.name, "axis": axis}
                along_axes.append((names, direction[:, None]))
    for pairs in (along_axes, anyhow):
        if pairs:
            yield Block(
                scene.all_samples,
                scene.by_geometry @ np.array([directions for _, directions in pairs]),
                [names for names, _ in pairs],
                widths,
            )


def _directions(
    scene: Scene,
    joint: Joint,
    unit: str,
) -> np.ndarray:
    """Return the changes of the geometry by which a joint moves along three axes, shape (n, 3)."""
    of_joint = {
        index: parameter.index % 3
        for index, parameter in enumerate(scene.parameters)
        if parameter.joint == joint.name and parameter.unit == unit
    }
    indices = [*of_joint]
    directions = np.zeros((len(scene.parameters), 3))
    if len(indices) == 3:
        link = scene.robot.joints.index(joint) + (unit == "rad")
        directions[indices] = link_axes(scene.robot)[link]
    else:
        directions[indices] = np.eye(3)[[*of_joint.values()]]
    return directions


def of_version(scene: Scene) -> Iterable[Block]:
    """Return the block of a model all of whose numbers are wrong."""
    of_links = np.array([not parameter.of_ball for parameter in scene.parameters])
    columns = scene.by_geometry @ (VERSION * of_links[:, None] * scene.usual)
    yield Block(scene.all_samples, columns[None], [{}])


def of_other_arm(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements that another arm of the type recorded."""
    if len(scene.places) < 2:
        return
    for place, samples in enumerate(scene.places):
        rows = scene.rows(samples)
        columns = scene.by_geometry[rows] @ scene.usual
        yield Block(
            rows,
            columns[None],
            [scene.named(place)],
            OTHERS,
        )


def _each(
    scene: Scene,
    turns: np.ndarray,
    widths: tuple[float, ...],
    **names: str,
) -> Iterable[Block]:
    """Return the block of joints that each read too little by their turns, shape (N, m, k)."""
    shifts = -scene.by_joints[..., None] * turns[:, None]
    joints = [{"joint": name, **names} for name in scene.robot.joint_names]
    yield of_samples(
        scene.every,
        shifts.transpose(2, 0, 1, 3),
        joints,
        widths,
    )


def of_joints(
    scene: Scene,
    turns: Callable[[np.ndarray], np.ndarray],
    widths: tuple[float, ...],
) -> Iterable[Block]:
    """Return the block of joints that are off throughout, by turns of their readings (N, m)."""
    return _each(scene, turns(scene.q)[..., None], widths)


def of_uneven(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that lead and lag once a turn, or twice, more than gears do."""
    for times, word in enumerate(TURNS, 1):
        phases = times * scene.q
        waves = np.stack([np.sin(phases), np.cos(phases)], axis=2)
        yield from _each(scene, waves, UNEVEN, turn=word)


def of_soft_base(scene: Scene) -> Iterable[Block]:
    """Return the block of a base that tilts under the arm, as its first joint would, but more."""
    samples = scene.loaded_samples
    if TILT not in scene.effects or not samples.moments.any():
        return
    m = scene.q.shape[1]
    turns = np.linalg.norm(TILT.turns(samples)[:, [0, m]], axis=1)
    first = scene.model.slices[scene.effects.index(TILT)].start
    by_first_joint = scene.linear.by_unknowns[:, :, [first, first + m]]
    columns = -by_first_joint / max(rms(turns), 1e-6)
    yield of_samples(
        scene.every,
        columns,
        [{}],
        TILTS,
    )


def of_commands(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that all give way under the arm's weight, as far as servos do.

    Encoders see that, commands do not.
    """
    columns = -scene.by_joints * _sags(scene)[:, None]
    yield of_samples(
        scene.every,
        columns[None],
        [{}],
        SAGS,
    )


def _sags(scene: Scene) -> np.ndarray:
    """Return turns in proportion to gravity's moments, 1 in the joint that turns most, (N, m)."""
    torques = scene.loaded_samples.torques
    return torques / max(*map(rms, torques.T), 1e-6)


def of_lost_zero(scene: Scene) -> Iterable[Block]:
    """Return blocks of joints that are off from some sample of a placement on."""
    joints = cycle(scene.robot.joint_names)
    for block in changes(scene, -scene.by_joints[..., None], LOST):
        names = [{"joint": next(joints), **first} for first in block.parameters]
        yield replace(block, parameters=names)


def of_slips(scene: Scene) -> Iterable[Block]:
    """Return the block of joints that slip again and again: off by an unknown at each sample."""
    count = len(scene.q)
    if count <= MOST_SLIPS:
        slopes = -scene.by_joints.transpose(2, 0, 1)
        columns = slopes[..., None] * np.eye(count)[:, None]
        joints = [{"joint": name} for name in scene.robot.joint_names]
        yield of_samples(scene.every, columns, joints, LOST)


def slipped(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how far a joint is off where it slips, root mean square [rad, m]."""
    return {"offset": rms(values)}


def of_lag(scene: Scene) -> Iterable[Block]:
    """Return the block of readings that are behind the arm by a share of the last step."""
    steps = np.zeros_like(scene.q)
    for rows, ranks in zip(scene.places, scene.ranks, strict=True):
        order = rows.start + np.argsort(ranks)
        steps[order[1:]] = -np.diff(scene.q[order], axis=0)
    columns = -scene.by_joints @ steps[:, :, None]
    yield of_samples(
        scene.every,
        columns,
        [{}],
        LAGS,
    )


def sag(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return by how much the joint that gives way most does [rad]."""
    sizes = np.array([*map(rms, _sags(scene).T)]) * np.abs(values)
    return {"size": float(sizes.max())}


def offset(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
) -> Parameters:
    """Return what is to be added to what a joint reads [rad, m], as in ``mukca rezero``."""
    return {"offset": float(values[0])}


def excess(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
) -> Parameters:
    """Return the share by which a joint reads too much, or all of them lead."""
    return {"offset": -float(values[0])}


def error(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
    unit: str,
) -> Parameters:
    """Return which number of an origin in the URDF is wrong, and by how much [m], [rad].

    Where it is no single one, it is how far the joint is displaced, or turned, in all.
    """
    ball = scene.model.ball
    index = [joint.name for joint in scene.robot.joints].index(parameters["joint"])
    directions = _directions(scene, scene.robot.joints[index], unit)
    if "axis" in parameters:
        directions = directions[:, [AXES.index(parameters["axis"])]]
    change = directions @ values
    origins = ball.origins(ball.nominal + change)
    first, part = (0, "place") if unit == "m" else (3, "rotation")
    errors = (scene.robot.origins - origins)[index, first : first + 3]
    largest = int(np.argmax(np.abs(errors)))
    value = float(errors[largest])
    if hypot(*np.delete(errors, largest)) > SINGLE * abs(value):
        return {
            "component": part,
            "error": hypot(*change),
            "sense": "off",
        }
    return {
        "component": COMPONENTS[first + largest],
        "error": value,
        "sense": "too large" if value > 0 else "too small",
    }

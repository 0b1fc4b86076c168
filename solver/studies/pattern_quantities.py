"""Quantities that errors may follow: joints' angles, reach, height and time."""

from typing import NamedTuple

import numpy as np

from ..identification.robot import Robot, crude_bodies, link_poses
from .evidence import PatternRows
from .projections import rows_of, unit

HARMONICS = 5
"""Harmonics of a joint's angle."""
UPWARD = np.array([0.0, 0.0, 1.0])


class Quantity(NamedTuple):
    """A quantity that errors may follow, and the direction of errors that are drawn over it."""

    at: np.ndarray
    """Shape (N,)."""
    unit: str
    along: str
    """The direction in words."""
    directions: np.ndarray | None
    """Unit vectors, shape (N, 3); None for that of each placement's mean drift."""
    columns: np.ndarray
    """A of its pattern, shape (3 N, k)."""


def quantities_of(
    robot: Robot,
    rows: PatternRows,
) -> dict[str, Quantity]:
    """Return what patterns are looked for over, by name."""
    quantities: dict[str, Quantity] = {}
    for j, joint in enumerate(robot.actuated):
        if joint.type != "prismatic":
            angles = rows.q[:, j]
            motion = rows.by_joints[:, :, j]
            quantities[joint.name] = _angle(angles, motion)
    middle = _middle(robot, rows.q)
    quantities["reach"] = _reach(middle, rows.balls)
    quantities["height"] = _height(middle)
    quantities["time"] = _time(rows)
    return quantities


def _angle(angles: np.ndarray, motion: np.ndarray) -> Quantity:
    """Return a joint's angle q: the ball moves by sin(k q) and cos(k q) along the joint's motion.

    Angles have shape (N,) [rad], and the motion, the ball's derivative, (N, 3).
    """
    k = np.arange(1, HARMONICS + 1)
    phases = angles[:, None] * k
    sines = np.sin(phases)
    cosines = np.cos(phases)
    waves = np.hstack([sines, cosines])
    columns = motion[:, :, None] * waves[:, None]
    return Quantity(
        at=angles,
        unit="rad",
        along="along its motion",
        directions=unit(motion),
        columns=rows_of(columns),
    )


def _reach(middle: np.ndarray, balls: np.ndarray) -> Quantity:
    """Return the reach: the ball moves along each of the arm's axes by a parabola.

    With the reach a base gives way as well, by which the ball turns about x or y in proportion to
    the load.
    """
    axes = _axes(middle)
    from_above = middle[:, :2]
    reach = np.linalg.norm(from_above, axis=1)
    x, y, _ = np.eye(3)
    tilt_x = -np.cross(x, balls) * middle[:, [1]]
    tilt_y = np.cross(y, balls) * middle[:, [0]]
    tilts = np.stack([tilt_x, tilt_y], axis=2)
    parabola = _powers(axes, reach)
    return Quantity(
        at=reach,
        unit="m",
        along="upward",
        directions=axes[:, :, 2],
        columns=np.hstack([rows_of(tilts), parabola]),
    )


def _height(middle: np.ndarray) -> Quantity:
    """Return the height: the ball moves along each of the arm's axes by a parabola."""
    axes = _axes(middle)
    height = middle[:, 2]
    return Quantity(
        at=height,
        unit="m",
        along="outward",
        directions=axes[:, :, 0],
        columns=_powers(axes, height),
    )


def _time(rows: PatternRows) -> Quantity:
    """Return the time: each placement moves by a parabola."""
    axes = np.eye(3)
    powers = _powers(axes, rows.time)
    placements = np.unique(rows.placement)
    is_here = rows.placement[:, None] == placements
    is_here = np.repeat(is_here, 3, axis=0)
    columns = is_here[:, :, None] * powers[:, None]
    return Quantity(
        at=rows.time,
        unit="",
        along="along the drift",
        directions=None,
        columns=columns.reshape(len(powers), -1),
    )


def _middle(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return the arm's centre of mass, of crude masses where the model has none, (N, 3) [m]."""
    bodies = robot.bodies or crude_bodies(robot.joints)
    masses = [body.mass for body in bodies]
    links = [body.joint + 1 for body in bodies]
    poses = link_poses(robot.joints, q)[:, links]
    in_links = np.array([body.centre for body in bodies])
    turned = np.einsum("nbij,bj->nbi", poses[..., :3], in_links)
    centres = turned + poses[..., 3]
    return np.average(centres, axis=1, weights=masses)


def _axes(middle: np.ndarray) -> np.ndarray:
    """Return the outward, sideways and upward directions of arms, shape (N, 3, 3)."""
    outward = unit(middle * [1.0, 1.0, 0.0])
    sideways = np.cross(UPWARD, outward)
    axes = np.broadcast_arrays(outward, sideways, UPWARD)
    return np.stack(axes, axis=2)


def _powers(axes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return errors along three axes in proportion to values and their squares, shape (3 N, 6)."""
    deviation = max(float(values.std()), 1e-9)
    centred = (values - values.mean()) / deviation
    centred = centred[:, None, None]
    squares = centred**2 - 1
    columns = np.dstack([axes * centred, axes * squares])
    return rows_of(columns)

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
            quantities[joint.name] = _angle(rows.q[:, j], rows.by_joints[:, :, j])
    middle = _middle(robot, rows.q)
    others = {"reach": _reach(middle, rows.balls), "height": _height(middle)}
    return {**quantities, **others, "time": _time(rows)}


def _angle(
    angles: np.ndarray,
    motion: np.ndarray,
) -> Quantity:
    """Return a joint's angle q: the ball moves by sin(k q) and cos(k q) along the joint's motion.

    Angles have shape (N,) [rad], and the motion, the ball's derivative, (N, 3).
    """
    k = np.arange(1, HARMONICS + 1)
    phases = angles[:, None] * k
    waves = np.hstack([np.sin(phases), np.cos(phases)])
    columns = motion[:, :, None] * waves[:, None]
    return Quantity(
        at=angles,
        unit="rad",
        along="along its motion",
        directions=unit(motion),
        columns=rows_of(columns),
    )


def _reach(
    middle: np.ndarray,
    balls: np.ndarray,
) -> Quantity:
    """Return the reach: the ball moves along each of the arm's axes by a parabola.

    With the reach a base gives way as well, by which the ball turns about x or y in proportion to
    the load.
    """
    axes = _axes(middle)
    reach = np.linalg.norm(middle[:, :2], axis=1)
    x, y, _ = np.eye(3)
    tilt_x = -np.cross(x, balls) * middle[:, [1]]
    tilt_y = np.cross(y, balls) * middle[:, [0]]
    tilts = np.stack([tilt_x, tilt_y], axis=2)
    return Quantity(
        at=reach,
        unit="m",
        along="upward",
        directions=axes[:, :, 2],
        columns=np.hstack([rows_of(tilts), _powers(axes, reach)]),
    )


def _height(middle: np.ndarray) -> Quantity:
    """Return the height: the ball moves along each of the arm's axes by a parabola."""
    axes, height = _axes(middle), middle[:, 2]
    return Quantity(
        at=height,
        unit="m",
        along="outward",
        directions=axes[:, :, 0],
        columns=_powers(axes, height),
    )


def _time(rows: PatternRows) -> Quantity:
    """Return the time: each placement moves by a parabola."""
    powers = _powers(np.eye(3), rows.time)
    is_here = rows.placement[:, None] == np.unique(rows.placement)
    is_here = np.repeat(is_here, 3, axis=0)
    columns = is_here[:, :, None] * powers[:, None]
    return Quantity(
        at=rows.time,
        unit="",
        along="along the drift",
        directions=None,
        columns=columns.reshape(len(powers), -1),
    )


def _middle(
    robot: Robot,
    q: np.ndarray,
) -> np.ndarray:
    """Return the arm's centre of mass, of crude masses where the model has none, (N, 3) [m]."""
    bodies = robot.bodies or crude_bodies(robot.joints)
    poses = link_poses(robot.joints, q)[:, [body.joint + 1 for body in bodies]]
    in_links = np.array([body.centre for body in bodies])
    centres = np.einsum("nbij,bj->nbi", poses[..., :3], in_links) + poses[..., 3]
    return np.average(centres, axis=1, weights=[body.mass for body in bodies])


def _axes(middle: np.ndarray) -> np.ndarray:
    """Return the outward, sideways and upward directions of arms, shape (N, 3, 3)."""
    outward = unit(middle * [1.0, 1.0, 0.0])
    sideways = np.cross(UPWARD, outward)
    return np.stack(np.broadcast_arrays(outward, sideways, UPWARD), axis=2)


def _powers(
    axes: np.ndarray,
    values: np.ndarray,
) -> np.ndarray:
    """Return errors along three axes in proportion to values and their squares, shape (3 N, 6)."""
    centred = (values - values.mean()) / max(float(values.std()), 1e-9)
    centred = centred[:, None, None]
    return rows_of(np.dstack([axes * centred, axes * (centred**2 - 1)]))

"""The moments by which joints hold an arm's masses against gravity."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from .bodies import Body
from .chain import Joint
from .kinematics import frames_of
from .segments import SegmentChain, SegmentLayout, Segments, cross
from .urdf import Robot

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Acceleration in the base frame of an arm that stands upright [m/s^2]."""


def gravity_moments(
    robot: Robot,
    positions: np.ndarray,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    payload: float = 0.0,
) -> np.ndarray:
    """Return the moments by which each joint holds the arm against gravity, about its three axes.

    They are slopes of the potential energy of the URDF's masses and of a payload [kg] at the ball,
    by the nominal model at joint positions of shape (N, m), with gravity in the base frame [m/s^2].

    Returns:
        Moments [N m] ([N] along a prismatic joint), shape (N, 3 m): about the joints' own axes,
        then about the first of each one's :attr:`.Joint.tilt_axes`, then about the second.
    """
    rows = np.ascontiguousarray(positions, dtype=float)
    moments = _moments_at(
        robot.joints, robot.bodies, payload, tuple(gravity), rows.shape, rows.tobytes()
    )
    return moments.copy()


@lru_cache(maxsize=16)
def _moments_at(
    joints: tuple[Joint, ...],
    bodies: tuple[Body, ...],
    payload: float,
    gravity: tuple[float, ...],
    shape: tuple[int, ...],
    positions: bytes,
) -> np.ndarray:
    """Return the moments at joint positions, which are asked for of the same samples in turn."""
    rows = np.frombuffer(positions).reshape(shape)
    m = rows.shape[1]
    layout = SegmentLayout(joints, m)
    chain = layout.chain(frames_of(joints))
    segments = chain.at(rows)
    upright = SegmentLayout(joints, 3 * m).by_q
    # what does not tilt turns about all three axes in one segment
    motions = replace(upright, segments=np.tile(layout.by_q.segments, 3))
    forces, moments = _felt(chain, segments, bodies, payload, gravity)
    return motions.work(forces, moments).T


def _felt(
    chain: SegmentChain,
    segments: Segments,
    bodies: Sequence[Body],
    payload: float,
    gravity: Sequence[float],
) -> tuple[np.ndarray, np.ndarray]:
    """Return forces and moments that hold all masses from each segment on, seen by the segments.

    Their shapes are (segments, 3, N); moments are about the segments' origins.
    """
    links = [*(body.joint + 1 for body in bodies), -1]
    masses = [*(body.mass for body in bodies), payload]
    centres = [*(body.centre for body in bodies), (0.0, 0.0, 0.0)]
    frames = chain.links[links]
    carriers = chain.layout.segments[links]
    points = np.einsum("bij,bj->bi", frames[:, :, :3], centres) + frames[:, :, 3]
    places = np.einsum("bijn,bj->bin", segments.R[carriers], points)
    places += segments.p[carriers]
    weights = -np.outer(masses, gravity)
    S = len(segments.p)
    beyond = carriers >= np.arange(S)[:, None]
    forces = (beyond @ weights)[:, :, None]
    about_base = np.tensordot(beyond, cross(places, weights[:, :, None]), 1)
    moments = about_base - cross(segments.p, forces)
    forces = np.broadcast_to(forces, moments.shape)
    return segments.turned_back(forces), segments.turned_back(moments)

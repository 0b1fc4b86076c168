"""Places where the socket base may stand, and the way from one to another in words."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..studies import unit
from .reachability import Reach

MANY = 200
"""Poses of each socket from which those are taken that are near each other."""
POSES = 40
"""Reachable poses of each socket, among which the samples are chosen."""
ANGLES = np.deg2rad([-90, -45, 0, 45, 90])
"""Directions in which the base may stand, from the robot's front, which is x."""
HEIGHTS = (0.0, 0.1)
"""Above the first place, on a block [m]."""
NEAR = 0.015
"""Shorter ways are not mentioned [m]."""


@dataclass(frozen=True)
class Site:
    """A place for the socket base, and poses that reach its two sockets."""

    centres: np.ndarray
    """Of the sockets, shape (2, 3) [m]."""
    poses: tuple[np.ndarray, np.ndarray]
    """Joint positions for each socket, shape (N, m)."""

    @property
    def along(self) -> np.ndarray:
        """Unit vector from socket 0 to socket 1."""
        return unit(self.centres[1] - self.centres[0])

    @property
    def middle(self) -> np.ndarray:
        """Of both sockets, shape (3,) [m]."""
        return self.centres.mean(axis=0)


def site_at(
    reach: Reach,
    centre: np.ndarray,
    distance: float,
    along: np.ndarray,
) -> Site | None:
    """Return a place for a base about a centre, along a unit vector; None where few poses reach."""
    half = 0.5 * distance * along
    centres = np.array([centre - half, centre + half])
    bounded = np.isfinite(reach.turn)
    count = MANY if bounded else POSES
    zero, first = [reach.poses(end, count) for end in centres]
    if bounded and min(len(zero), len(first)):
        is_near = _near_each_other(reach, zero, first)
        zero = zero[is_near[: len(zero)]][:POSES]
        first = first[is_near[-len(first) :]][:POSES]
    if min(len(zero), len(first)) < POSES // 4:
        return None
    return Site(centres, (zero, first))


def _near_each_other(
    reach: Reach,
    zero: np.ndarray,
    first: np.ndarray,
) -> np.ndarray:
    """Return a mask of those poses of both sockets that a session begun at one of them reaches.

    It begins at the pose of socket 0 where most poses are near.
    """
    offsets = np.abs(zero[:, None] - np.concatenate([zero, first]))
    is_near = offsets.max(axis=2) <= reach.turn
    return is_near[np.argmax(is_near.sum(axis=1))]


def sites_around(
    reach: Reach,
    centre: np.ndarray,
    distance: float,
) -> list[Site]:
    """Return places as far from the robot's axis as one that is known, as high, and higher."""
    radius = float(np.hypot(centre[0], centre[1]))
    upward = np.array([0.0, 0.0, 1.0])
    sites: list[Site] = []
    for angle, height in itertools.product(ANGLES, HEIGHTS):
        outward = np.array([np.cos(angle), np.sin(angle), 0.0])
        above = centre[2] + height
        place = radius * outward + above * upward
        if np.linalg.norm(place - centre) < 0.3 * radius:
            continue
        site = site_at(reach, place, distance, np.cross(upward, outward))
        if site is not None:
            sites.append(site)
    return sites


def in_words(start: Sequence[float], end: Sequence[float]) -> str:
    """Return the way from one place of the base to another [m], as seen from the robot."""
    x, y, z = start
    u, v, w = end
    before = float(np.hypot(x, y))
    angle = float(np.arctan2(x * v - y * u, x * u + y * v))
    arc = 2 * before * abs(np.sin(0.5 * angle))
    outward = float(np.hypot(u, v)) - before
    upward = w - z
    words: list[str] = []
    if arc > NEAR:
        side = "left" if angle > 0 else "right"
        around = " around the robot" if abs(angle) > np.deg2rad(30) else ""
        words.append(f"{arc:.2f} m to the {side}{around}")
    if abs(outward) > NEAR:
        way = "farther" if outward > 0 else "nearer"
        words.append(f"{abs(outward):.2f} m {way}")
    if abs(upward) > NEAR:
        way = "higher" if upward > 0 else "lower"
        words.append(f"{100 * abs(upward):.0f} cm {way}")
    return ", ".join(words) or "here"

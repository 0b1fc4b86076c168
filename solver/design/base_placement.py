"""Places of the socket base, and the accuracy that recording there would bring."""

from dataclasses import dataclass

import numpy as np

from ..data import CALIPER_DEVIATION, SEAT_DEVIATION
from .information import ParameterCovariance, Workspace
from .reachability import Reach

POSES = 20
"""Reachable poses of each socket, among which the samples are chosen."""
SAMPLES = 12
"""Samples in each socket of the placement that is proposed."""
ANGLES = np.deg2rad([-90, -45, 0, 45, 90])
"""Directions in which the base may stand, from the robot's front, which is x."""
LONG = 0.2
"""The longer base that is compared [m]."""
KNOWN = 1e-4
"""Standard deviation of a measured distance between two bases [m]."""


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
        offset = self.centres[1] - self.centres[0]
        return offset / np.linalg.norm(offset).clip(1e-9)


def site_at(reach: Reach, centre: np.ndarray, distance: float, along: np.ndarray) -> Site | None:
    """Return a place for the base; None where too few poses reach it.

    Args:
        reach: Finds poses.
        centre: Between the two sockets, shape (3,) [m].
        distance: Between the sockets [m].
        along: Unit vector from socket 0 to socket 1.
    """
    centres = np.array([centre - 0.5 * distance * along, centre + 0.5 * distance * along])
    poses = [reach.poses(c, POSES) for c in centres]
    if min(map(len, poses)) < POSES // 4:
        return None
    return Site(centres, (poses[0], poses[1]))


def sites_around(reach: Reach, centre: np.ndarray, distance: float) -> list[Site]:
    """Return places as far from the robot's axis, and as high, as one that is known."""
    radius = float(np.hypot(centre[0], centre[1]))
    sites: list[Site] = []
    for angle in ANGLES:
        away = np.array([np.cos(angle), np.sin(angle), 0.0])
        across = np.array([-away[1], away[0], 0.0])
        place = radius * away + np.array([0.0, 0.0, centre[2]])
        if np.linalg.norm(place - centre) < 0.3 * radius:
            continue
        site = site_at(reach, place, distance, across)
        if site is not None:
            sites.append(site)
    return sites


def with_site(
    known: ParameterCovariance,
    site: Site,
    where: Workspace,
    samples: int,
    before: Site | None = None,
) -> ParameterCovariance:
    """Return the covariance after recording at another site.

    Args:
        known: The covariance so far.
        site: The base's place.
        where: Distances to be known.
        samples: Number in each socket; they are chosen greedily among the site's poses.
        before: An earlier site of the same base, whose sockets are the first two of ``known``; its
            distance was measured there. None: it is measured here.
    """
    first = known.sockets
    known = known.with_socket().with_socket()
    u = site.along
    ends = {first: -u, first + 1: u}
    if before is None:
        known = known.with_lengths(ends, CALIPER_DEVIATION)
    else:  # as long as it was there
        ends |= {0: before.along, 1: -before.along}
        known = known.with_lengths(ends, 2**0.5 * SEAT_DEVIATION)
    for i in range(2 * samples):
        socket = i % 2
        poses = site.poses[socket]
        best = best_of(known, poses, first + socket, where)
        known = known.with_samples(poses[best : best + 1], first + socket)
    return known


def best_of(known: ParameterCovariance, poses: np.ndarray, socket: int, where: Workspace) -> int:
    """Return the index of the pose that would teach most."""
    return int(np.argmax(known.variance_reduction(poses, socket, where.shape)))


def next_base_advice(
    known: ParameterCovariance, where: Workspace, reach: Reach, here: np.ndarray, distance: float
) -> tuple[str, ...]:
    """Return lines on the best next placement: its place, its gain, and ways to a larger one.

    Args:
        known: The covariance after this placement.
        where: Distances to be known.
        reach: Finds poses.
        here: The centres of this placement's two sockets, shape (2, 3) [m].
        distance: Between them [m].
    """
    now = known.error(where)
    before = Site(here, (np.zeros((0, 0)), np.zeros((0, 0))))
    sites = sites_around(reach, here.mean(axis=0), distance)
    if not sites:
        return ()
    after = [with_site(known, site, where, SAMPLES, before) for site in sites]
    best = int(np.argmin([k.error(where) for k in after]))
    site, then = sites[best], after[best]
    x, y, z = site.centres.mean(axis=0)
    offset = site.centres[0] - here[0]
    u = offset / np.linalg.norm(offset).clip(1e-9)
    tied = then.with_lengths({0: -u, known.sockets: u}, KNOWN)
    longer = site_at(reach, site.centres.mean(axis=0), LONG, site.along)
    lines = [
        f"Here distances in the workspace are known to {_mm(now)} mm. A second placement near "
        f"x {x:+.2f}, y {y:+.2f}, z {z:+.2f} m brings {_mm(then.error(where))} mm;",
        f"with the distance between both bases measured to 0.1 mm {_mm(tied.error(where))} mm"
        + (";" if longer else "."),
    ]
    if longer:
        with_longer = with_site(known, longer, where, SAMPLES)
        lines.append(
            f"with sockets {1e3 * LONG:g} mm apart there {_mm(with_longer.error(where))} mm."
        )
    return tuple(lines)


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f}"

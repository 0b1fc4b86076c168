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
        return unit(self.centres[1] - self.centres[0])


def site_at(reach: Reach, centre: np.ndarray, distance: float, along: np.ndarray) -> Site | None:
    """Return a place for a base about a centre, along a unit vector; None where few poses reach."""
    centres = np.array([centre - 0.5 * distance * along, centre + 0.5 * distance * along])
    poses = [reach.poses(c, POSES) for c in centres]
    if min(map(len, poses)) < POSES // 4:
        return None
    return Site(centres, (poses[0], poses[1]))


def sites_around(reach: Reach, centre: np.ndarray, distance: float) -> list[Site]:
    """Return places as far from the robot's axis, and as high, as one that is known."""
    radius = float(np.hypot(centre[0], centre[1]))
    sites: list[Site | None] = []
    for angle in ANGLES:
        away = np.array([np.cos(angle), np.sin(angle), 0.0])
        place = radius * away + np.array([0.0, 0.0, centre[2]])
        if np.linalg.norm(place - centre) >= 0.3 * radius:
            sites.append(site_at(reach, place, distance, np.array([-away[1], away[0], 0.0])))
    return [site for site in sites if site is not None]


def unit(offset: np.ndarray) -> np.ndarray:
    """Return the unit vector along an offset."""
    return offset / np.linalg.norm(offset).clip(1e-9)


def with_site(
    known: ParameterCovariance,
    site: Site,
    where: Workspace,
    samples: int,
    before: np.ndarray | None = None,
) -> ParameterCovariance:
    """Return the covariance after recording at another site.

    Args:
        known: The covariance so far.
        site: The base's place.
        where: Distances to be known.
        samples: Number in each socket; they are chosen greedily among the site's poses.
        before: Direction of the same base at an earlier site, whose sockets are the first two of
            ``known``; its distance was measured there. None: it is measured here.
    """
    first = known.sockets
    known = known.with_socket().with_socket()
    ends, deviation = {first: -site.along, first + 1: site.along}, CALIPER_DEVIATION
    if before is not None:  # as long as it was there
        ends, deviation = ends | {0: before, 1: -before}, 2**0.5 * SEAT_DEVIATION
    known = known.with_lengths(ends, deviation)
    for i in range(2 * samples):
        poses, socket = site.poses[i % 2], first + i % 2
        best = int(np.argmax(known.variance_reduction(poses, socket, where.shape)))
        known = known.with_samples(poses[best : best + 1], socket)
    return known


def best_site(
    known: ParameterCovariance,
    sites: list[Site],
    where: Workspace,
    samples: int,
    before: np.ndarray,
) -> tuple[Site, ParameterCovariance]:
    """Return the site that teaches most, and the covariance after it; see :func:`with_site`."""
    after = [with_site(known, site, where, samples, before) for site in sites]
    best = int(np.argmin([k.error(where) for k in after]))
    return sites[best], after[best]


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
    sites = sites_around(reach, here.mean(axis=0), distance)
    if not sites:
        return ()
    site, then = best_site(known, sites, where, SAMPLES, unit(here[1] - here[0]))
    centre, u = site.centres.mean(axis=0), unit(site.centres[0] - here[0])
    tied = then.with_lengths({0: -u, known.sockets: u}, KNOWN)
    longer = site_at(reach, centre, LONG, site.along)
    now, brings, with_tie = (f"{1e3 * one.error(where):.2f} mm" for one in (known, then, tied))
    x, y, z = centre
    lines = [
        f"Here distances in the workspace are known to {now}. A second placement near "
        f"x {x:+.2f}, y {y:+.2f}, z {z:+.2f} m brings {brings};",
        f"with the distance between both bases measured to 0.1 mm {with_tie}"
        + (";" if longer else "."),
    ]
    if longer:
        error = with_site(known, longer, where, SAMPLES).error(where)
        lines.append(f"with sockets {1e3 * LONG:g} mm apart there {1e3 * error:.2f} mm.")
    return tuple(lines)

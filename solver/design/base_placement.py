"""Where the socket base could stand next, and what recording there would bring."""

import numpy as np

from .knowledge import ParameterCovariance, Workspace
from .plan import Site, between, with_site
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
"""How well the distance between two bases can be measured [m]."""


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


def closing_words(
    known: ParameterCovariance, where: Workspace, reach: Reach, here: np.ndarray, distance: float
) -> tuple[str, ...]:
    """Return what another placement would bring, where, and how it could bring more.

    Args:
        known: What this placement taught.
        where: What is to be known.
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
    u = between([before, site])
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

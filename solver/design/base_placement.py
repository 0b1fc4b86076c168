"""Places of the socket base, the accuracy that recording there would bring, and plans of them."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..bayes.model import Noise, extend
from ..bayes.model.effects import TYPES_WITH_CURVES
from ..data import CALIPER_DEVIATION, SEAT_DEVIATION, as_point
from ..robot import Robot, SimulationError, choose_parameters
from .information import ParameterCovariance, Workspace, from_prior, unit, workspace_of
from .pose_route import annealing
from .reachability import Reach

MANY = 200
"""Poses of each socket from which those are taken that are near each other."""
POSES = 40
"""Reachable poses of each socket, among which the samples are chosen."""
SAMPLES = 12
"""Samples in each socket of the placement that is proposed."""
ANGLES = np.deg2rad([-90, -45, 0, 45, 90])
"""Directions in which the base may stand, from the robot's front, which is x."""
HEIGHTS = (0.0, 0.1)
"""Above the first place, on a block [m]."""
LONG = 0.15
"""The longer base that is compared [m]; print-parts makes one of 152 mm at most."""
NEAR = 0.015
"""Shorter ways are not mentioned [m]."""
KNOWN = 1e-4
"""Standard deviation of a measured distance between two bases [m]."""
RADII = (0.5, 0.4, 0.3, 0.6)
"""Distances of the first base from the robot's axis, as shares of the arm's length."""
HEIGHT = 0.1
"""Its height, likewise."""
NOISE = Noise(1e-4, 0.0)
"""Of a sample [m]."""


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


def site_at(
    reach: Reach, centre: np.ndarray, distance: float, along: np.ndarray
) -> Site | None:
    """Return a place for a base about a centre, along a unit vector; None where few poses reach."""
    half = 0.5 * distance * along
    centres = np.array([centre - half, centre + half])
    bounded = np.isfinite(reach.turn)
    zero, first = [reach.poses(end, MANY if bounded else POSES) for end in centres]
    if bounded and min(len(zero), len(first)):
        # a session begins where most poses of both sockets are near
        turns = np.abs(zero[:, None] - np.concatenate([zero, first])).max(axis=2)
        near = turns <= reach.turn
        most = near[np.argmax(near.sum(axis=1))]
        zero = zero[most[: len(zero)]][:POSES]
        first = first[most[len(near) :]][:POSES]
    if min(len(zero), len(first)) < POSES // 4:
        return None
    return Site(centres, (zero, first))


def sites_around(reach: Reach, centre: np.ndarray, distance: float) -> list[Site]:
    """Return places as far from the robot's axis as one that is known, as high, and higher."""
    radius = float(np.hypot(centre[0], centre[1]))
    upward = np.array([0.0, 0.0, 1.0])
    sites: list[Site] = []
    for angle, height in itertools.product(ANGLES, HEIGHTS):
        outward = np.array([np.cos(angle), np.sin(angle), 0.0])
        place = radius * outward + (centre[2] + height) * upward
        if np.linalg.norm(place - centre) >= 0.3 * radius:
            site = site_at(reach, place, distance, np.cross(upward, outward))
            sites += [site] if site else []
    return sites


def in_words(start: Sequence[float], end: Sequence[float]) -> str:
    """Return the way from one place of the base to another [m], as seen from the robot."""
    (x, y, z), (u, v, w) = start, end
    before, after = float(np.hypot(x, y)), float(np.hypot(u, v))
    angle = float(np.arctan2(x * v - y * u, x * u + y * v))
    arc = 2 * before * abs(np.sin(0.5 * angle))
    out, up = after - before, w - z
    words: list[str] = []
    if arc > NEAR:
        around = " around the robot" if abs(angle) > np.deg2rad(30) else ""
        words.append(f"{arc:.2f} m to the {'left' if angle > 0 else 'right'}{around}")
    if abs(out) > NEAR:
        words.append(f"{abs(out):.2f} m {'farther' if out > 0 else 'nearer'}")
    if abs(up) > NEAR:
        words.append(f"{100 * abs(up):.0f} cm {'higher' if up > 0 else 'lower'}")
    return ", ".join(words) or "here"


def with_site(
    state: ParameterCovariance,
    site: Site,
    where: Workspace,
    samples: int,
    before: np.ndarray | None = None,
) -> ParameterCovariance:
    """Return the covariance after recording at another site.

    The ``samples`` in each socket are chosen greedily among the site's poses. ``before`` is the
    direction of the same base at an earlier site, whose sockets are the first two of ``state``; its
    distance was measured there. None: it is measured here.
    """
    first = state.sockets
    state = state.with_sockets(2)
    ends = {first: -site.along, first + 1: site.along}
    deviation = CALIPER_DEVIATION
    if before is not None:  # as long as it was there
        ends = ends | {0: before, 1: -before}
        deviation = 2**0.5 * SEAT_DEVIATION
    state = state.with_lengths(ends, deviation)
    pools = dict(enumerate(site.poses, first))
    order = [first, first + 1] * samples
    return replace(state, covariance=annealing(state, where, pools, order).greedy())


def best_site(
    state: ParameterCovariance,
    sites: list[Site],
    where: Workspace,
    samples: int,
    before: np.ndarray,
) -> tuple[Site, ParameterCovariance]:
    """Return the site that teaches most, and the covariance after it; see :func:`with_site`."""
    after = [(site, with_site(state, site, where, samples, before)) for site in sites]
    return min(after, key=lambda pair: pair[1].error(where))


def next_base_advice(
    state: ParameterCovariance,
    where: Workspace,
    reach: Reach,
    position: np.ndarray,
    distance: float,
) -> tuple[str, ...]:
    """Return lines on the best next placement: its place, its gain, and ways to a larger one.

    ``state`` is the covariance after this placement, whose two sockets are ``position``,
    shape (2, 3) [m], so far apart [m].
    """
    sites = sites_around(reach, position.mean(axis=0), distance)
    if not sites:
        return ()
    along = unit(position[1] - position[0])
    site, then = best_site(state, sites, where, SAMPLES, along)
    middle, centre = position.mean(axis=0), site.centres.mean(axis=0)
    u = unit(site.centres[0] - position[0])
    tied = then.with_lengths({0: -u, state.sockets: u}, KNOWN)
    longer = site_at(reach, centre, LONG, site.along) if distance < LONG else None
    now, there, measured = [_error(each, where) for each in (state, then, tied)]
    lines = [
        f"Here distances in the workspace are known to {now}. A second placement, seen from the "
        f"robot {in_words(middle, centre)}, brings {there};",
        f"with the distance between both bases measured to 0.1 mm {measured}"
        + (";" if longer else "."),
    ]
    if longer:
        error = _error(with_site(state, longer, where, SAMPLES), where)
        lines.append(f"with sockets {1e3 * LONG:g} mm apart there {error}.")
    return tuple(lines)


def _error(state: ParameterCovariance, where: Workspace) -> str:
    """Return a predicted error for people."""
    return f"{1e3 * state.error(where):.2f} mm"


@dataclass(frozen=True)
class Plan:
    """Placements of one base, in the order in which they serve best."""

    distance: float
    """Between its sockets [m]."""
    places: tuple[tuple[float, float, float], ...]
    """Of its middle in the robot's base frame [m]."""
    predicted: tuple[float, ...]
    """Predicted errors of distances after each placement [m]."""
    turn: float | None = None
    """Farthest that a joint turns from where a session began [deg]; None for any."""


def plan(
    robot: Robot,
    distance: float,
    placements: int,
    samples: int,
    turn: float | None = None,
) -> Plan:
    """Return the best places of a base, so many at most, and the predicted errors.

    The base has so many samples in each of two sockets so far apart [m]. No joint may turn farther
    than ``turn`` [deg] from where a session began; None for any.

    Raises:
        SimulationError: The arm reaches no place for the base.
    """
    model = extend(robot, choose_parameters(robot))
    where = workspace_of(model, np.zeros(model.size))
    reach = Reach(robot, turn=np.inf if turn is None else np.deg2rad(turn))
    first = _first(robot, reach, distance)
    state = with_site(from_prior(model, NOISE, 0), first, where, samples)
    route = [(first, state)]
    candidates = sites_around(reach, first.centres.mean(axis=0), distance)
    while candidates and len(route) < placements:
        site, state = best_site(state, candidates, where, samples, first.along)
        route.append((site, state))
        candidates = [candidate for candidate in candidates if candidate is not site]
    return Plan(
        distance,
        tuple(as_point(site.centres.mean(axis=0).round(3)) for site, _ in route),
        tuple(state.error(where) for _, state in route),
        turn,
    )


def curve_advice(robot: Robot) -> str:
    """Return what to record of an arm whose type has joint error curves; empty for others."""
    if robot.name not in TYPES_WITH_CURVES:
        return ""
    return (
        "Arms of this type have an error curve of each joint: turn every joint through many angles "
        "and record at two places of the base at least, better four."
    )


def _first(robot: Robot, reach: Reach, distance: float) -> Site:
    length = float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())
    for radius in RADII:
        centre = np.array([radius * length, 0.0, HEIGHT * length])
        site = site_at(reach, centre, distance, np.array([0.0, 1.0, 0.0]))
        if site is not None:
            return site
    raise SimulationError(
        f"{robot.name}: found no place in front of it that it reaches well"
    )

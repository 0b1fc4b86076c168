"""The accuracy that recording at places of the socket base would bring, and plans of them."""

import json
from dataclasses import dataclass, replace
from importlib.resources import files as resources

import numpy as np

from ..assessment import area, mm
from ..identification.data import CALIPER_DEVIATION, SEAT_DEVIATION, as_point
from ..identification.model import Noise, extend
from ..identification.robot import Robot, choose_parameters
from ..poses import SimulationError
from ..studies import arm_length, unit
from .information import ParameterCovariance, Workspace, from_prior, workspace_of
from .pose_route import annealing
from .reachability import Reach
from .sites import Site, site_at, sites_around

SAMPLES = 12
"""Samples in each socket of the placement that is proposed."""
LONG = 0.15
"""The longer base that is compared [m]; print-parts makes one of 152 mm at most."""
KNOWN = 1e-4
"""Standard deviation of a measured distance between two bases [m]."""
RADII = (0.5, 0.4, 0.3, 0.6)
"""Distances of the first base from the robot's axis, as shares of the arm's length."""
HEIGHT = 0.1
"""Its height, likewise."""
_CURVES = (
    resources("mukca.solver.identification.robot") / "shipped" / "error_curves.json"
)
CURVED: dict[str, str] = json.loads(_CURVES.read_bytes())
"""Shipped robots whose measured arms all had joint error curves, and by what that is known."""
NOISE = Noise(1e-4, 0.0)
"""Of a sample [m]."""


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
    order = [first, first + 1] * samples
    annealed = annealing(state, where, dict(enumerate(site.poses, first)), order)
    return replace(state, covariance=annealed.greedy())


def best_site(
    state: ParameterCovariance,
    sites: list[Site],
    where: Workspace,
    samples: int,
    before: np.ndarray,
) -> tuple[Site, ParameterCovariance]:
    """Return the site that teaches most, and the covariance after it; see :func:`with_site`."""
    states = [with_site(state, site, where, samples, before) for site in sites]
    errors = [after.error(where) for after in states]
    best = int(np.argmin(errors))
    return sites[best], states[best]


def next_base_advice(
    state: ParameterCovariance,
    where: Workspace,
    reach: Reach,
    position: np.ndarray,
    distance: float,
    place: np.ndarray,
    now: float | None = None,
) -> tuple[str, ...]:
    """Return lines on the next placement: its place, its gain, and ways to a larger one.

    Args:
        state: The covariance after this placement.
        where: Distances to be known.
        reach: Of the arm.
        position: Of this placement's two sockets, shape (2, 3) [m].
        distance: Between them [m].
        place: Where another placement serves best, shape (3,) [m]. If the arm does not reach it,
            the best place that it reaches is taken.
        now: Error of distances that ``mukca solve`` predicts [m]; None where it predicts none.
    """
    aside = unit(np.array([-place[1], place[0], 0.0]))
    farthest = site_at(reach, place, distance, aside)
    middle = position.mean(axis=0)
    sites = [farthest] if farthest else sites_around(reach, middle, distance)
    if not sites:
        return ()
    along = unit(position[1] - position[0])
    site, then = best_site(state, sites, where, SAMPLES, along)
    u = unit(site.centres[0] - position[0])
    tied = then.with_lengths({0: -u, state.sockets: u}, KNOWN)
    longer = None
    if distance < LONG:
        longer = site_at(reach, site.middle, LONG, site.along)
    ratio = now / state.error(where) if now else 1.0

    def error(after: ParameterCovariance) -> str:
        return mm(ratio * after.error(where))

    lines = [
        f"Here distances in the workspace are known to {error(state)}. Another placement, "
        f"seen from the robot about {area(as_point(site.middle))}, brings {error(then)};",
        f"with the distance between both bases measured to 0.1 mm {error(tied)}",
    ]
    if longer is None:
        lines[-1] += "."
    else:
        lines[-1] += ";"
        then = with_site(state, longer, where, SAMPLES)
        lines.append(f"with sockets {1e3 * LONG:g} mm apart there {error(then)}.")
    return tuple(lines)


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
    farthest = np.inf if turn is None else np.deg2rad(turn)
    reach = Reach(robot, turn=farthest)
    first = _first(robot, reach, distance)
    sites = [first]
    state = with_site(from_prior(model, NOISE, 0), first, where, samples)
    errors = [state.error(where)]
    candidates = sites_around(reach, first.middle, distance)
    while candidates and len(sites) < placements:
        site, state = best_site(state, candidates, where, samples, first.along)
        sites.append(site)
        errors.append(state.error(where))
        candidates = [candidate for candidate in candidates if candidate is not site]
    places = [as_point(site.middle.round(3)) for site in sites]
    return Plan(distance, tuple(places), tuple(errors), turn)


def curve_advice(robot: Robot) -> str:
    """Return what to record of an arm whose type has joint error curves; empty for others."""
    if robot.name not in CURVED:
        return ""
    return (
        "Arms of this type have an error curve of each joint: turn every joint through many angles "
        "and record at two places of the base at least, better four."
    )


def _first(
    robot: Robot,
    reach: Reach,
    distance: float,
) -> Site:
    length = arm_length(robot)
    sideways = np.array([0.0, 1.0, 0.0])
    for radius in RADII:
        centre = length * np.array([radius, 0.0, HEIGHT])
        site = site_at(reach, centre, distance, sideways)
        if site is not None:
            return site
    raise SimulationError(
        f"{robot.name}: found no place in front of it that it reaches well"
    )

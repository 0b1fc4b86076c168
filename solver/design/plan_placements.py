"""Plan of recordings for an arm: places of the base, and the accuracy that they bring."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..bayes.model import Noise, extend
from ..bayes.model.effects import TYPES_WITH_CURVES
from ..data import as_point
from ..robot import Robot, SimulationError, choose_parameters
from .base_placement import Site, best_site, site_at, sites_around, with_site
from .information import expected_groups, from_prior, workspace_of
from .reachability import Reach

RADII = (0.5, 0.4, 0.3, 0.6)
"""Distances of the first base from the robot's axis, as shares of the arm's length."""
HEIGHT = 0.1
"""Its height, likewise."""
NOISE = Noise(1e-4, 0.0)
"""Of a sample [m]."""


@dataclass(frozen=True)
class Plan:
    """Placements of one base, in the order in which they serve best."""

    distance: float
    """Between its sockets [m]."""
    places: tuple[tuple[float, float, float], ...]
    """Of its middle in the robot's base frame [m]."""
    errors: tuple[float, ...]
    """Predicted errors of distances after each placement [m]."""
    turn: float | None = None
    """Farthest that a joint turns from where a session began [deg]; None for any."""

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        return {
            "distance": self.distance,
            "turn": self.turn,
            "places": self.places,
            "predicted": self.errors,
        }


def plan(
    robot: Robot, distance: float, placements: int, samples: int, turn: float | None = None
) -> Plan:
    """Return the best places of a base, and the predicted errors.

    Args:
        robot: The nominal robot.
        distance: Between the base's sockets [m].
        placements: Their number at most.
        samples: Number in each socket.
        turn: Farthest that a joint may turn from where a session began [deg]; None for any.

    Raises:
        SimulationError: The arm reaches no place for the base.
    """
    model = extend(robot, choose_parameters(robot))
    where = workspace_of(model, np.zeros(model.size))
    reach = Reach(robot, turn=np.inf if turn is None else np.deg2rad(turn))
    first = _first(robot, reach, distance)
    known = from_prior(model, expected_groups(model), NOISE, 0)
    sites, after = [first], [with_site(known, first, where, samples)]
    left = sites_around(reach, first.centres.mean(axis=0), distance)
    while left and len(sites) < placements:
        best, known = best_site(after[-1], left, where, samples, first.along)
        left = [site for site in left if site is not best]
        sites, after = [*sites, best], [*after, known]
    return Plan(
        distance,
        tuple(as_point(site.centres.mean(axis=0).round(3)) for site in sites),
        tuple(known.error(where) for known in after),
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
    raise SimulationError(f"{robot.name}: found no place in front of it that it reaches well")


def picture(robot: Robot, planned: Plan) -> str:
    """Return the placements seen from above, as SVG: x is up, y to the left."""
    size, middle = 480, 240
    reach = 1.25 * max(float(np.hypot(x, y)) for x, y, _ in planned.places)
    scale = middle / reach
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size} {size}" width="{size}" '
        f'height="{size}" font-family="sans-serif" font-size="13">',
        f'<rect width="{size}" height="{size}" fill="#ffffff"/>',
        f'<circle cx="{middle}" cy="{middle}" r="14" fill="#444444"/>',
        f'<text x="{middle + 20}" y="{middle + 5}">{robot.name}, from above</text>',
        f'<path d="M{middle} {middle}V{middle - 60}m-5 9l5 -9 5 9" stroke="#444444" fill="none"/>',
        f'<text x="{middle + 6}" y="{middle - 50}">x</text>',
    ]
    for number, ((x, y, _), error) in enumerate(
        zip(planned.places, planned.errors, strict=True), start=1
    ):
        across, up = middle - scale * y, middle - scale * x
        parts += [
            f'<circle cx="{across:.0f}" cy="{up:.0f}" r="12" fill="#1f5fbf"/>',
            f'<text x="{across:.0f}" y="{up + 5:.0f}" fill="#ffffff" text-anchor="middle">'
            f"{number}</text>",
            f'<text x="{across:.0f}" y="{up + 28:.0f}" text-anchor="middle">'
            f"{1e3 * error:.2f} mm</text>",
        ]
    return "\n".join([*parts, "</svg>", ""])

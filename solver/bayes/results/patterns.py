"""Where the rest of the error sits: patterns over joints' angles, reach, height and time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...data import Load, Measurement, fit_frames, targets
from ...results import ErrorPattern, ErrorPatterns
from ...robot import Robot, even_bodies, link_poses
from ..inference import Posterior
from .pattern_evidence import PatternEvidence, PatternRows, of_held_out, of_trained
from .projections import block_diagonal, rows_of

MOST = 360
"""Samples that are looked at, at most, evenly chosen."""
FEWEST = 20
"""Fewest samples for any pattern."""
HARMONICS = 5
"""Harmonics of a joint's angle."""
CLEAR = 3.0
"""Logarithm of the odds from which a pattern is named."""
SEAT, TURN = 0.3, 1.0
"""Widths of the priors of the places of sockets and frames [m], and of the turns of these [rad]."""
GRID, NEIGHBOURS = 41, 0.04
"""Places of the running mean, and the deviation of its weights as a share of the axis."""
EXACT = 1e-6
"""Noise below which nothing is left in errors but rounding [m]."""
DRAWN = 160
"""Samples that are drawn, at most, evenly chosen."""
BAND = 1.96


def error_patterns(
    posterior: Posterior,
    robot: Robot,
    load: Load,
    train: Sequence[Measurement],
    test: Sequence[Measurement],
) -> ErrorPatterns | None:
    """Return the patterns of what a fit leaves, in placements trained on and held out.

    Of the two the larger odds count. None for too few samples, or without noise.
    """
    if posterior.noise.space < EXACT:
        return None
    parts = [(train, of_trained), (test, of_held_out)]
    parts = [
        (placements, evidence_of) for placements, evidence_of in parts if placements
    ]
    best: dict[str, ErrorPattern] = {}
    for placements, evidence_of in parts:
        rows = _rows(posterior, robot, load, placements)
        if len(rows.q) < FEWEST:
            continue
        evidence = evidence_of(posterior, rows)
        quantities = _quantities(robot, rows)
        tried = len(parts) * len(quantities)
        for over, quantity in quantities.items():
            pattern = _pattern(rows, over, quantity, evidence, tried)
            if over not in best or pattern.log_odds > best[over].log_odds:
                best[over] = pattern
    if not best:
        return None
    first = max(best.values(), key=lambda pattern: pattern.log_odds)
    strongest = first.over if first.log_odds > CLEAR else None
    return ErrorPatterns(patterns=tuple(best.values()), strongest=strongest)


def _rows(
    posterior: Posterior, robot: Robot, load: Load, placements: Sequence[Measurement]
) -> PatternRows:
    """Return the samples of placements, thinned out where there are many."""
    total = sum(len(m.positions) for m in placements)
    step = -(-total // MOST)
    parts: list[list[np.ndarray]] = []
    for k, m in enumerate(placements):
        q = m.positions
        points, J, by_joints = posterior.linearise(q, load.torques(robot, m))
        still = m.at_rest(points)
        frames = fit_frames([(still, m)])
        errors = still - targets(still, m, frames)
        if frames:
            widths = np.repeat([TURN, SEAT], 3)
            seats = widths * frames[m.frame].slopes(m.points)
        else:
            in_socket = np.repeat(np.eye(len(m.counts)), m.counts, axis=0)
            by_centres = np.kron(in_socket, np.eye(3))
            seats = SEAT * by_centres.reshape(len(q), 3, -1)
        time = m.order / max(len(q) - 1, 1)
        index = np.full(len(q), k)
        columns = (q, errors, J, by_joints, points, time, index, seats)
        parts.append([column[::step] for column in columns])
    *columns, seats = zip(*parts, strict=True)
    joined = list(map(np.concatenate, columns))
    return PatternRows._make([*joined, block_diagonal(map(rows_of, seats))])


def _middle(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return the arm's centre of mass, of even masses where the model has none, (N, 3) [m]."""
    bodies = robot.bodies or even_bodies(robot.joints)
    links = [body.joint + 1 for body in bodies]
    poses = link_poses(robot.joints, q)[:, links]
    local = np.array([(*body.centre, 1.0) for body in bodies])
    centres = np.einsum("nbij,bj->nbi", poses, local)
    return np.average(centres, axis=1, weights=[body.mass for body in bodies])


def _axes(middle: np.ndarray) -> np.ndarray:
    """Return the outward, sideways and upward directions of arms, shape (N, 3, 3)."""
    upward = np.array([0.0, 0.0, 1.0])
    outward = _unit(middle * [1.0, 1.0, 0.0])
    sideways = np.cross(upward, outward)
    return np.stack(np.broadcast_arrays(outward, sideways, upward), axis=2)


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


def _quantities(robot: Robot, rows: PatternRows) -> dict[str, Quantity]:
    """Return what patterns are looked for over, by name.

    Over a joint's angle q the ball moves by sin(k q) and cos(k q) along the joint's motion. Over
    reach r and height h it moves along each of the arm's axes by a parabola, and with the reach a
    base gives way as well, by which the ball turns about x or y in proportion to the load. Over
    time each placement moves by a parabola.
    """
    quantities: dict[str, Quantity] = {}
    k = np.arange(1, HARMONICS + 1)
    for j, joint in enumerate(robot.actuated):
        if joint.type == "prismatic":
            continue
        angles = rows.q[:, j]
        motion = rows.by_joints[:, :, j]
        phases = angles[:, None] * k
        waves = np.hstack([np.sin(phases), np.cos(phases)])
        columns = rows_of(motion[:, :, None] * waves[:, None])
        quantities[joint.name] = Quantity(
            angles, "rad", "along its motion", _unit(motion), columns
        )
    middle = _middle(robot, rows.q)
    axes = _axes(middle)
    tilt_y = np.cross([0.0, 1.0, 0.0], rows.balls) * middle[:, [0]]
    tilt_x = -np.cross([1.0, 0.0, 0.0], rows.balls) * middle[:, [1]]
    tilts = rows_of(np.stack([tilt_x, tilt_y], axis=2))
    reach = np.linalg.norm(middle[:, :2], axis=1)
    by_reach = np.hstack([tilts, _powers(axes, reach)])
    upward = axes[:, :, 2]
    quantities["reach"] = Quantity(reach, "m", "upward", upward, by_reach)
    height = middle[:, 2]
    outward = axes[:, :, 0]
    by_height = _powers(axes, height)
    quantities["height"] = Quantity(height, "m", "outward", outward, by_height)
    powers = _powers(np.eye(3), rows.time)
    in_placement = rows.placement[:, None] == np.unique(rows.placement)
    here = np.repeat(in_placement, 3, axis=0)
    by_time = (here[:, :, None] * powers[:, None]).reshape(len(powers), -1)
    quantities["time"] = Quantity(rows.time, "", "along the drift", None, by_time)
    return quantities


def _powers(axes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return errors along three axes in proportion to values and their squares, shape (3 N, 6)."""
    centred = (values - values.mean()) / max(float(values.std()), 1e-9)
    columns = [axes * power[:, None, None] for power in (centred, centred**2 - 1)]
    return rows_of(np.dstack(columns))


def _pattern(
    rows: PatternRows,
    over: str,
    quantity: Quantity,
    evidence: PatternEvidence,
    tried: int,
) -> ErrorPattern:
    """Return one pattern of those tried, with its running mean, the errors along its direction."""
    log_odds, field = evidence.of(quantity.columns)
    directions = quantity.directions
    if directions is None:
        directions = _drift_directions(rows, field)
    at = quantity.at
    errors = np.sum(rows.errors * directions, axis=1)
    grid = np.linspace(float(at.min()), float(at.max()), GRID)
    width = NEIGHBOURS * max(float(np.ptp(at)), 1e-9)
    away = (grid[:, None] - at) / width
    weights = np.exp(-0.5 * away**2) + 1e-12
    weights /= weights.sum(axis=1, keepdims=True)
    step = -(-len(at) // DRAWN)
    return ErrorPattern(
        over=over,
        unit=quantity.unit,
        along=quantity.along,
        at=_rounded(at[::step]),
        errors=_rounded(errors[::step]),
        grid=_rounded(grid),
        mean=_rounded(weights @ errors),
        band=_rounded(BAND * np.sqrt(weights**2 @ evidence.deviations**2)),
        size=float(np.linalg.norm(field)) / len(field) ** 0.5,
        log_odds=log_odds - float(np.log(tried)),
    )


def _drift_directions(rows: PatternRows, field: np.ndarray) -> np.ndarray:
    """Return the direction of the mean drift of each sample's placement, shape (N, 3)."""
    slopes = np.zeros((rows.placement.max() + 1, 3))
    for k in np.unique(rows.placement):
        here = rows.placement == k
        time = rows.time[here]
        slopes[k] = (time - time.mean()) @ field[here]
    return _unit(slopes)[rows.placement]


def _unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.maximum(lengths, 1e-12)


def _rounded(values: np.ndarray) -> tuple[float, ...]:
    return tuple(np.round(values, 7).tolist())

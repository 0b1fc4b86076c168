"""Where the rest of the error sits: patterns over joints' angles, reach, height and time."""

from collections.abc import Sequence

import numpy as np

from ...data import Load, Measurement, fit_pose
from ...results import ErrorPattern, ErrorPatterns
from ...robot import Robot, even_bodies, link_poses
from ..inference import Posterior
from .pattern_evidence import PatternEvidence, PatternRows, of_held_out, of_trained

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
    parts = [
        _rows(posterior, robot, load, placements) for placements in (train, test) if placements
    ]
    best: dict[str, ErrorPattern] = {}
    for number, rows in enumerate(parts):
        if len(rows.q) < FEWEST:
            continue
        evidence = of_held_out(posterior, rows) if number else of_trained(posterior, rows)
        columns = _columns(robot, rows)
        tried = len(parts) * len(columns)
        for over, A in columns.items():
            log_odds, field = evidence.of(A)
            pattern = _pattern(robot, rows, over, log_odds - float(np.log(tried)), field, evidence)
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
    step = max(1, -(-total // MOST))
    parts = [_of_placement(posterior, robot, load, m, step) for m in placements]
    count = [len(part[0]) for part in parts]
    columns = [
        np.concatenate(column) for column in zip(*(part[:-1] for part in parts), strict=True)
    ]
    widths = [part[-1].shape[1] for part in parts]
    seats = np.zeros((3 * sum(count), sum(widths)))
    for i, part in enumerate(parts):
        row = 3 * sum(count[:i])
        column = sum(widths[:i])
        seats[row : row + 3 * count[i], column : column + widths[i]] = part[-1]
    q, errors, J, by_joints, balls, time = columns
    placement = np.repeat(np.arange(len(parts)), count)
    return PatternRows(q, errors, J, by_joints, seats, balls, time, placement)


def _of_placement(
    posterior: Posterior, robot: Robot, load: Load, m: Measurement, step: int
) -> tuple[np.ndarray, ...]:
    """Return q, errors, J, derivatives by joints, balls, time and seats of a placement."""
    q = m.positions
    moments = load.torques(robot, m)
    points, J, by_joints = posterior.model.linearise(posterior.x, q, moments)
    sockets = np.repeat(np.arange(len(m.counts)), m.counts)
    if m.kind == "points":
        measured = m.points[m.order]
        frame = fit_pose(measured, points)
        errors = points - frame.apply(measured)
        seats = frame.slopes(measured) * np.repeat([TURN, SEAT], 3)
    else:
        moved = points if m.moved is None else points - m.moved
        means = np.array([moved[sockets == k].mean(axis=0) for k in range(len(m.counts))])
        errors = moved - means[sockets]
        seats = SEAT * np.kron(np.eye(len(m.counts))[sockets], np.eye(3)).reshape(len(q), 3, -1)
    time = m.order / max(len(q) - 1, 1)
    some = slice(None, None, step)
    seats = seats[some].reshape(-1, seats.shape[2])
    return q[some], errors[some], J[some], by_joints[some], points[some], time[some], seats


def _middle(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return the arm's centre of mass, of even masses where the model has none, (N, 3) [m]."""
    poses = link_poses(robot.joints, q)
    bodies = robot.bodies or even_bodies(robot.joints)
    masses = np.array([body.mass for body in bodies])
    centres = [
        poses[:, body.joint + 1, :, :3] @ np.array(body.centre) + poses[:, body.joint + 1, :, 3]
        for body in bodies
    ]
    return np.einsum("b,bni->ni", masses / masses.sum(), np.array(centres))


def _axes(middle: np.ndarray) -> np.ndarray:
    """Return the outward, sideways and upward directions of arms, shape (N, 3, 3)."""
    outward = middle[:, :2] / np.maximum(np.linalg.norm(middle[:, :2], axis=1), 1e-9)[:, None]
    axes = np.zeros((len(middle), 3, 3))
    axes[:, :2, 0] = outward
    axes[:, 0, 1], axes[:, 1, 1] = -outward[:, 1], outward[:, 0]
    axes[:, 2, 2] = 1.0
    return axes


def _columns(robot: Robot, rows: PatternRows) -> dict[str, np.ndarray]:
    """Return A of each pattern, shape (3 N, k), by what it is over."""
    columns: dict[str, np.ndarray] = {}
    order = np.arange(1, HARMONICS + 1)
    for j, joint in enumerate(robot.actuated):
        phases = rows.q[:, [j]] * order
        waves = np.hstack([np.sin(phases), np.cos(phases)])
        if joint.type != "prismatic":
            along = rows.by_joints[:, :, j, None] * waves[:, None, :]
            columns[joint.name] = along.reshape(-1, 2 * HARMONICS)
    middle = _middle(robot, rows.q)
    axes = _axes(middle)
    tilt_y = np.cross([0.0, 1.0, 0.0], rows.balls) * middle[:, [0]]
    tilt_x = -np.cross([1.0, 0.0, 0.0], rows.balls) * middle[:, [1]]
    tilts = np.stack([tilt_x, tilt_y], axis=2).reshape(-1, 2)
    reach = np.linalg.norm(middle[:, :2], axis=1)
    columns["reach"] = np.hstack([tilts, _powers(axes, reach)])
    columns["height"] = _powers(axes, middle[:, 2])
    powers = _powers(np.tile(np.eye(3), (len(rows.q), 1, 1)), rows.time)
    here = rows.placement[:, None] == np.unique(rows.placement)
    parts = powers.reshape(len(rows.q), 3, 1, -1) * here[:, None, :, None]
    columns["time"] = parts.reshape(len(powers), -1)
    return columns


def _powers(axes: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return errors along three axes in proportion to values and their squares, shape (3 N, 6)."""
    centred = (values - values.mean()) / max(float(values.std()), 1e-9)
    parts = [axes * centred[:, None, None], axes * (centred**2 - 1)[:, None, None]]
    return np.concatenate(parts, axis=2).reshape(-1, 6)


def _pattern(
    robot: Robot,
    rows: PatternRows,
    over: str,
    log_odds: float,
    field: np.ndarray,
    evidence: PatternEvidence,
) -> ErrorPattern:
    """Return a pattern with its running mean, the errors along its direction."""
    at, unit, along, directions = _drawn(robot, rows, over, field)
    errors = np.einsum("ni,ni->n", rows.errors, directions)
    low = float(at.min())
    high = float(at.max())
    grid = np.linspace(low, high, GRID)
    width = NEIGHBOURS * max(high - low, 1e-9)
    weights = np.exp(-0.5 * ((grid[:, None] - at) / width) ** 2) + 1e-12
    weights /= weights.sum(axis=1, keepdims=True)
    some = slice(None, None, -(-len(at) // DRAWN))
    return ErrorPattern(
        over=over,
        unit=unit,
        along=along,
        at=_rounded(at[some]),
        errors=_rounded(errors[some]),
        grid=_rounded(grid),
        mean=_rounded(weights @ errors),
        band=_rounded(BAND * np.sqrt(weights**2 @ evidence.deviations**2)),
        size=float(np.linalg.norm(field)) / len(field) ** 0.5,
        log_odds=log_odds,
    )


def _drawn(
    robot: Robot, rows: PatternRows, over: str, field: np.ndarray
) -> tuple[np.ndarray, str, str, np.ndarray]:
    """Return the quantity, its unit, and the direction of errors in words and as vectors."""
    if over == "time":
        slopes = [
            np.einsum("n,ni->i", rows.time[here] - rows.time[here].mean(), field[here])
            for here in (rows.placement == k for k in np.unique(rows.placement))
        ]
        directions = _unit(np.array(slopes))[rows.placement]
        return rows.time, "", "along the drift", directions
    if over in ("reach", "height"):
        middle = _middle(robot, rows.q)
        axes = _axes(middle)
        if over == "reach":
            return np.linalg.norm(middle[:, :2], axis=1), "m", "upward", axes[:, :, 2]
        return middle[:, 2], "m", "outward", axes[:, :, 0]
    j = robot.joint_names.index(over)
    return rows.q[:, j], "rad", "along its motion", _unit(rows.by_joints[:, :, j])


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def _rounded(values: np.ndarray) -> tuple[float, ...]:
    return tuple(np.round(values, 7).tolist())

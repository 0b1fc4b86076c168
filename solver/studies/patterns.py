"""Patterns of the rest of the error: over joints' angles, reach, height and time."""

from collections.abc import Sequence

import numpy as np

from ..identification.data import Load, fit_frames, targets
from ..identification.robot import Robot
from ..results import (
    ErrorPattern,
    ErrorPatterns,
    Fit,
    Measurements,
    Study,
    Unseen,
)
from .evidence import (
    EvidenceOf,
    PatternEvidence,
    PatternRows,
    Slopes,
    of_held_out,
    of_trained,
)
from .pattern_quantities import Quantity, quantities_of
from .projections import block_diagonal, rounded, rows_of, unit

MOST = 360
"""Samples that are looked at, at most, evenly chosen."""
FEWEST = 20
"""Fewest samples for any pattern."""
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
    fit: Fit,
    measurements: Measurements,
) -> ErrorPatterns | None:
    """Return the patterns of what a fit leaves, in placements trained on, and in unseen ones.

    Of the two the larger odds count. None for too few samples, or without noise.
    """
    posterior, robot = fit.posterior, measurements.robot
    assert posterior is not None
    if posterior.noise.space < EXACT:
        return None
    parts: list[tuple[list[Unseen], EvidenceOf]] = [
        ([(posterior, measurements.measurements)], of_trained),
        (measurements.unseen(fit), of_held_out),
    ]
    parts = [(pairs, of) for pairs, of in parts if any(m for _, m in pairs)]
    best: dict[str, ErrorPattern] = {}
    for pairs, evidence_of in parts:
        rows, slopes = _rows(robot, fit.calibrated.load, pairs)
        if len(rows.q) < FEWEST:
            continue
        evidence = evidence_of(posterior, rows, slopes)
        quantities = quantities_of(robot, rows)
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
    robot: Robot,
    load: Load,
    pairs: Sequence[Unseen],
) -> tuple[PatternRows, list[Slopes]]:
    """Return the samples of placements, thinned out where there are many, and their slopes."""
    by_placement = [(posterior, m) for posterior, group in pairs for m in group]
    total = sum(len(m.positions) for _, m in by_placement)
    step = -(-total // MOST)
    parts: list[list[np.ndarray]] = []
    slopes: list[Slopes] = []
    for k, (posterior, m) in enumerate(by_placement):
        q = m.positions
        points, J, by_joints = posterior.linearise(load.samples(robot, m))
        still = m.at_rest(points)
        frames = fit_frames([(still, m)])
        errors = still - targets(still, m, frames)
        if frames:
            widths = np.repeat([TURN, SEAT], 3)
            seats = widths * frames[m.frame].slopes(m.points)
        else:
            in_socket = np.repeat(np.eye(len(m.counts)), m.counts, axis=0)
            seats = SEAT * np.kron(in_socket, np.eye(3)).reshape(*points.shape, -1)
        time = m.order / max(len(q) - 1, 1)
        placement = np.full(len(q), k)
        slopes.append((posterior, J[::step]))
        columns = (q, errors, by_joints, points, time, placement, seats)
        parts.append([column[::step] for column in columns])
    *columns, seats = zip(*parts, strict=True)
    joined = [np.concatenate(column) for column in columns]
    by_places = block_diagonal(map(rows_of, seats))
    return PatternRows._make([*joined, by_places]), slopes


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
    errors = np.sum(rows.errors * directions, axis=1)
    at = quantity.at
    grid = np.linspace(float(at.min()), float(at.max()), GRID)
    weights = _weights_of_neighbours(grid, at)
    band = BAND * np.sqrt(weights**2 @ evidence.deviations**2)
    mean_square = float(np.sum(field**2)) / len(field)
    step = -(-len(at) // DRAWN)
    drawn = {
        "at": at[::step],
        "errors": errors[::step],
        "grid": grid,
        "mean": weights @ errors,
        "band": band,
    }
    return ErrorPattern(
        over=over,
        unit=quantity.unit,
        along=quantity.along,
        **{name: rounded(values, 7) for name, values in drawn.items()},
        size=mean_square**0.5,
        log_odds=log_odds - float(np.log(tried)),
    )


def _weights_of_neighbours(
    grid: np.ndarray,
    at: np.ndarray,
) -> np.ndarray:
    """Return the weights of samples in the running mean over a grid, shape (GRID, N)."""
    width = NEIGHBOURS * max(float(np.ptp(at)), 1e-9)
    away = (grid[:, None] - at) / width
    weights = np.exp(-0.5 * away**2) + 1e-12
    return weights / weights.sum(axis=1, keepdims=True)


def _drift_directions(
    rows: PatternRows,
    field: np.ndarray,
) -> np.ndarray:
    """Return the direction of the mean drift of each sample's placement, shape (N, 3)."""
    directions = np.zeros_like(field)
    for k in np.unique(rows.placement):
        is_here = rows.placement == k
        time = rows.time[is_here]
        directions[is_here] = unit((time - time.mean()) @ field[is_here])
    return directions


ERROR_PATTERNS = Study("error_patterns", error_patterns)

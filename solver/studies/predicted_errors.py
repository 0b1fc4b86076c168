"""Predicted errors of distances in the workspace and near recorded places, and poses near these."""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from ..identification.data import Load, Measurement
from ..identification.inference import Posterior
from ..identification.robot import BallModel, Robot, workspace
from ..poses import damped_steps
from ..results import DistanceDeviation
from .projections import bisected, pair_lengths
from .uncertainty import distance_deviations

SWAY = 0.3
"""Standard deviation of a posture from the one that it begins at [rad], before the ball is led."""
ROUNDS, TURN = 4, 2 * np.pi
DAMPING = 1e-4
"""Keeps steps short where the arm is stretched out and hardly reaches further."""
OFF = 0.01
"""Largest distance from its place at which a ball counts as led there, in lengths of the arm."""


def arm_length(robot: Robot) -> float:
    """Return the sum of the lengths of all origins [m]."""
    return float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())


def poses_near(
    robot: Robot,
    recorded: np.ndarray,
    counts: tuple[int, int],
    margin: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return configurations like those recorded, with the ball at places near theirs.

    Args:
        robot: The nominal robot, which puts the ball there; that is near enough.
        recorded: Joint positions, shape (N, m) [rad].
        counts: Number of places, and of postures at each; those out of limits or reach are left.
        margin: Standard deviation of a place from a recorded one, per axis [m].

    Returns:
        Joint positions, shape (M, m) [rad], and the index of each one's place, shape (M,).
    """
    generator = np.random.default_rng(0)
    ball = BallModel(robot, [])

    def any_of_recorded(count: int) -> np.ndarray:
        return recorded[generator.integers(len(recorded), size=count)]

    place_count, posture_count = counts
    q = any_of_recorded(place_count)
    centres = ball.points(ball.nominal, q)
    centres = centres + generator.normal(0, margin, centres.shape)
    places = np.repeat(np.arange(place_count), posture_count)
    targets = centres[places]
    q = any_of_recorded(len(places))
    q = q + generator.normal(0, SWAY, q.shape)
    for _ in range(ROUNDS):
        linear = ball.linearise(ball.nominal, q)
        damping = DAMPING * np.sum(linear.by_joints**2, axis=(1, 2))[:, None, None]
        steps = damped_steps(linear.by_joints, targets - linear.points, damping)
        q = q + steps.clip(-SWAY, SWAY)
    offsets = ball.points(ball.nominal, q) - targets
    is_there = np.linalg.norm(offsets, axis=1) < OFF * arm_length(robot)
    is_there &= _within_limits(robot, recorded, q)
    return q[is_there], places[is_there]


def _within_limits(
    robot: Robot,
    recorded: np.ndarray,
    q: np.ndarray,
) -> np.ndarray:
    """Return a mask of configurations within the joints' limits, shape (N,).

    Some controllers count whole turns, by which readings are beyond a joint's limits.
    """
    middle: np.ndarray = np.median(recorded, axis=0)
    excess = middle - middle.clip(robot.lower, robot.upper)
    turns = np.ceil(np.abs(excess) / TURN) * np.sign(excess)
    inside = q - TURN * turns
    return np.all((inside >= robot.lower) & (inside <= robot.upper), axis=1)


WITHIN_ONE, LARGE_GAP = 0.6827, 4.0
"""Share within a deviation; and deviations from which on a gap counts from one side only."""
NEAR, NEARBY = 0.06, 60
"""Standard deviation per axis of a place near a recorded one [m], and how many are thought of."""
PAIRS, LIKE = 200, 5
"""Random distances in the workspace, and recorded postures that are like one of them."""


def likely_errors(
    gap: np.ndarray,
    deviation: np.ndarray,
) -> np.ndarray:
    """Return what 68 % of the errors gap + deviation z do not exceed in size, shape (N,) [m]."""
    phi = np.vectorize(NormalDist().cdf)
    ratios = np.linspace(0, LARGE_GAP, 31)

    def too_few(sizes: np.ndarray) -> np.ndarray:
        share = phi(sizes - ratios) - phi(-sizes - ratios)
        return share <= WITHIN_ONE

    sizes = bisected(too_few, ratios, ratios + 1, rounds=20)
    ratio = np.abs(gap) / deviation
    size = np.interp(ratio, ratios, sizes)
    beyond = np.maximum(ratio - LARGE_GAP, 0)
    return deviation * (size + beyond)


def predicted_errors(
    posterior: Posterior,
    load: Load,
    q: np.ndarray,
    exported: np.ndarray | None = None,
) -> DistanceDeviation:
    """Return the predicted errors of distances between pairs of poses."""
    poses = load.at(posterior.model.robot, q)
    distances, deviation = distance_deviations(posterior, poses)
    export_error = None
    if exported is not None:
        points = posterior.model.ball.points(exported, q)
        errors = likely_errors(pair_lengths(points) - distances, deviation)
        export_error = float(np.median(errors))
    return DistanceDeviation(
        median=float(np.median(deviation)),
        worst=float(deviation.max()),
        length=float(np.median(distances)),
        alone=export_error,
    )


def workspace_errors(
    posterior: Posterior,
    load: Load,
    exported: np.ndarray | None = None,
) -> DistanceDeviation:
    """Return the predicted errors of distances between random poses."""
    q = workspace(posterior.model.robot, 2 * PAIRS)
    return predicted_errors(posterior, load, q, exported)


def errors_near(
    posterior: Posterior,
    load: Load,
    recorded: Sequence[Measurement],
    exported: np.ndarray | None,
) -> DistanceDeviation | None:
    """Return the predicted errors of distances near recorded places, where they are largest.

    See :func:`neighbourhoods`; both ends of a distance are near one place.
    """
    nearby = neighbourhoods(posterior.model.robot, recorded)
    return max(
        (predicted_errors(posterior, load, q, exported) for q in nearby),
        key=lambda deviation: deviation.alone or deviation.median,
        default=None,
    )


def neighbourhoods(
    robot: Robot,
    recorded: Sequence[Measurement],
) -> list[np.ndarray]:
    """Return an even number of poses near each recorded place that has two in reach.

    Near is some 0.1 m from a place, in configurations like those recorded there; of measured
    points, as near to one recorded posture as others that are like it.
    """
    nearby: list[np.ndarray] = []
    for m in recorded:
        q = _about(m.positions)
        if m.kind != "points":
            q, _ = poses_near(robot, m.positions, (NEARBY, 1), NEAR)
        if len(q) > 1:
            nearby.append(q[: len(q) // 2 * 2])
    return nearby


def _about(recorded: np.ndarray) -> np.ndarray:
    """Return configurations about those recorded, of shape (N, m), as near as others are [rad].

    With q_j one of the nearest to q_i, they are q_i + u (q_j - q_i), with u between -1 and 1.
    """
    generator = np.random.default_rng(0)
    i = generator.integers(len(recorded), size=NEARBY)
    gaps = np.linalg.norm(recorded[i, None] - recorded, axis=2)
    alike = np.argsort(gaps, axis=1)[:, :LIKE]
    j = generator.permuted(alike, axis=1)[:, 0]
    u = generator.uniform(-1, 1, size=(NEARBY, 1))
    return recorded[i] + u * (recorded[j] - recorded[i])

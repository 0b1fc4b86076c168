"""Configurations to which the exported geometry is fitted: imagined ones, and the samples."""

from dataclasses import dataclass

import numpy as np

from ...data import Load
from ...robot import BallModel, Robot
from ..inference import Posterior

PLACES, POSTURES = 40, 20
"""Number of simulated places, and of postures at each."""
AWAY = 0.15
"""Standard deviation of a place from the one recorded, per axis, as a share of the arm's length."""
SWAY = 0.3
"""Standard deviation of a posture from the one recorded [rad], before the ball is put back."""
COMMON = 0.3
"""Share that counts of the error that all postures at a place have in common. Their differences
make a tool miss a point that was taught in another posture; a common error shifts the place."""
RECORDED = 10.0
"""Weight of a recorded sample beside a simulated one."""
ROUNDS, TURN = 4, 2 * np.pi
DAMPING = 1e-4
"""Keeps steps short where the arm is stretched out and hardly reaches further."""


@dataclass(frozen=True)
class Poses:
    """Configurations with the ball at some places."""

    positions: np.ndarray
    """Shape (N, m) [rad]."""
    places: np.ndarray
    """Index of the place of each, shape (N,)."""
    targets: np.ndarray
    """Position of the ball, shape (N, 3) [m]."""
    weights: np.ndarray
    """Weight of each, shape (N,)."""


def simulated_poses(full: Posterior, load: Load) -> Poses:
    """Return configurations like those recorded, with the ball at places near those recorded."""
    # The nominal robot puts it there, which is near enough; what is out of limits or reach is left.
    robot = full.model.robot
    away = AWAY * float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())
    q, places = poses_near(robot, full.data.positions, (PLACES, POSTURES), away)
    targets = full.predict(q, load.moments(robot, q, None))
    return Poses(q, places, targets, np.ones(len(q)))


def poses_near(
    robot: Robot, recorded: np.ndarray, counts: tuple[int, int], away: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return configurations like those recorded, with the ball at places near theirs."""
    generator = np.random.default_rng(0)
    ball = BallModel(robot, [])
    length = float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())
    around = recorded[generator.integers(len(recorded), size=counts[0])]
    centres = ball.points(np.empty(0), around)
    centres = centres + generator.normal(0, away, centres.shape)
    places = np.repeat(np.arange(counts[0]), counts[1])
    q = recorded[generator.integers(len(recorded), size=len(places))]
    q = q + generator.normal(0, SWAY, q.shape)
    for _ in range(ROUNDS):
        linear = ball.linearise(np.empty(0), q)
        off = (centres[places] - linear.points)[:, :, None]
        q = q + _back(linear.by_joints, off).clip(-SWAY, SWAY)
    off = np.linalg.norm(ball.points(np.empty(0), q) - centres[places], axis=1)
    lower, upper = (np.array([getattr(j, k) for j in robot.actuated]) for k in ("lower", "upper"))
    # Some controllers count whole turns, by which readings are beyond a joint's limits.
    middle = np.median(recorded, axis=0)
    above, below = (np.ceil(np.maximum(d, 0) / TURN) for d in (middle - upper, lower - middle))
    inside = q - TURN * (above - below)
    kept = (off < 0.01 * length) & np.all((inside >= lower) & (inside <= upper), axis=1)
    return q[kept], places[kept]


def _back(slopes: np.ndarray, off: np.ndarray) -> np.ndarray:
    """Return damped steps of the joints that shift the balls, shape (N, m)."""
    across = slopes.swapaxes(1, 2)
    squares = slopes @ across
    damping: np.ndarray = DAMPING * np.sum(slopes**2, axis=(1, 2))
    forces = np.linalg.solve(squares + damping[:, None, None] * np.eye(3), off)
    return (across @ forces).reshape(len(slopes), -1)


def recorded_poses(full: Posterior) -> Poses:
    """Return the samples, with the ball where the full model has the socket."""
    # A measured ball is all that its place has in common, so its weight makes up for COMMON.
    seated = full.data.sockets >= 0
    measured = np.flatnonzero(~seated & ~full.data.turned)
    alone = Poses(
        full.data.positions[measured],
        np.arange(len(measured)),
        full.points[measured],
        RECORDED / COMMON**2 * full.weights[measured],
    )
    order = np.argsort(full.data.sockets[seated], kind="stable")
    sockets = full.data.sockets[seated][order]
    weights = RECORDED * full.weights[seated][order]
    poses = Poses(full.data.positions[seated][order], sockets, full.centres[sockets], weights)
    return joined(poses, alone)


def joined(one: Poses, other: Poses) -> Poses:
    """Return both one's and the other's poses; their places are different ones."""
    return Poses(
        np.concatenate([one.positions, other.positions]),
        np.concatenate([one.places, other.places + 1 + one.places.max(initial=-1)]),
        np.concatenate([one.targets, other.targets]),
        np.concatenate([one.weights, other.weights]),
    )


def apart(values: np.ndarray, places: np.ndarray, common: float = COMMON) -> np.ndarray:
    """Return values, of shape (N, ...), without most of what those at one place have in common."""
    begins = starts(places)
    counts = np.diff([*begins.tolist(), len(places)])
    sums = np.add.reduceat(values, begins, axis=0)
    means = sums / counts.reshape(-1, *[1] * (values.ndim - 1))
    return values - (1 - common) * np.repeat(means, counts, axis=0)


def starts(places: np.ndarray) -> np.ndarray:
    """Return where the poses of each place begin."""
    return np.flatnonzero(np.diff(places, prepend=-1))

"""The best geometry for programs that correct nothing: what ``calibrated.urdf`` holds."""

from dataclasses import dataclass, replace

import numpy as np

from ...data import Load
from ...robot import BallModel, Robot
from ..inference import Posterior
from ..model.effects import JOINT_OFFSET
from .joint_offsets import with_joint_offsets

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
SEATING_DEVIATION = 3e-4
"""Standard deviation to which the geometry is to follow the full model [m]; prior against data."""
CONFIDENCE = 1.0
"""Standard deviations by which a change has to be for the better."""
CHANCE_SHARE = 0.5
"""Difference of two geometries by chance, as a share of the error of the better one."""


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
    # a place for each socket, and then one for each measured ball
    rows = np.flatnonzero(~full.data.turned)
    places = full.data.sockets[rows]
    places = np.where(places >= 0, places, full.data.socket_count + rows)
    order = np.argsort(places, kind="stable")
    rows, places = rows[order], places[order]
    targets, weights = full.points[rows].copy(), RECORDED * full.weights[rows]
    seated = places < full.data.socket_count
    targets[seated] = full.centres[places[seated]]
    # A measured ball is all that its place has in common, so its weight makes up for COMMON.
    weights[~seated] /= COMMON**2
    return Poses(full.data.positions[rows], places, targets, weights)


def without_common(values: np.ndarray, places: np.ndarray, common: float = COMMON) -> np.ndarray:
    """Return values, of shape (N, ...), without most of what those at one place have in common."""
    begins = starts(places)
    counts = np.diff([*begins.tolist(), len(places)])
    sums = np.add.reduceat(values, begins, axis=0)
    means = sums / counts.reshape(-1, *[1] * (values.ndim - 1))
    return values - (1 - common) * np.repeat(means, counts, axis=0)


def starts(places: np.ndarray) -> np.ndarray:
    """Return where the poses of each place begin."""
    return np.flatnonzero(np.diff(places, prepend=-1))


def project_to_geometry(full: Posterior, load: Load, alone: np.ndarray | None = None) -> np.ndarray:
    """Return the best geometry for programs that correct nothing, shape (geometry,) [m, rad].

    ``alone`` is the geometry that the samples alone give, by the paper's cost, which the result is
    not to be worse than; None where more is known than its cost can tell.
    """
    rigid = not full.deflection.without(JOINT_OFFSET.name).extensions
    if rigid and alone is None:
        return with_joint_offsets(full)
    simulated = simulated_poses(full, load)
    if alone is not None and not len(simulated.places):
        return alone
    closest = with_joint_offsets(full) if rigid else _closest(full, load, simulated, alone)
    return closest if alone is None else _weighted_mean(full, load, simulated, closest, alone)


def _closest(full: Posterior, load: Load, simulated: Poses, alone: np.ndarray | None) -> np.ndarray:
    """Return the geometry that makes (A12) least, without k where the samples have no own."""
    model, n = full.model, full.model.geometry
    start, recorded, uncertainty = with_joint_offsets(full), recorded_poses(full), None
    off_prior = full.values - model.ball.nominal  # how far from its mean the start is
    if alone is not None:
        start, off_prior = alone, np.zeros(n)
        recorded = replace(recorded, targets=model.ball.points(alone, recorded.positions))
        uncertainty = _slope_covariance(full, load, simulated, alone)
    prior = np.zeros((n, n))
    for group in full.groups:
        inside = group.members < n
        if inside.any():
            own = group.members[inside]
            prior[np.ix_(own, own)] = group.precision(group.width, inside)
            off_prior[own] -= group.mean[inside] if alone is None else 0.0
    hessian, slope = prior, -prior @ off_prior
    for poses in (simulated, recorded):
        errors, J = _linear(model.ball, start, poses)
        hessian, slope = hessian + J.T @ J, slope - J.T @ errors
    return start + _cautious_step(hessian, slope, uncertainty)


def _linear(ball: BallModel, values: np.ndarray, poses: Poses) -> tuple[np.ndarray, np.ndarray]:
    """Return the weighted errors at some poses, shape (3 N,), and their derivatives."""
    linear = ball.linearise(values, poses.positions)
    root = np.sqrt(poses.weights) / SEATING_DEVIATION
    errors = without_common(linear.points - poses.targets, poses.places) * root[:, None]
    slopes = without_common(linear.by_parameters, poses.places) * root[:, None, None]
    return errors.ravel(), slopes.reshape(errors.size, -1)


def _slope_covariance(full: Posterior, load: Load, poses: Poses, start: np.ndarray) -> np.ndarray:
    """Return the covariance of the squared errors' slope, by the model and by chance of places."""
    model, q = full.model, poses.positions
    errors, J = _linear(model.ball, start, poses)
    _, slopes, _ = model.linearise(full.x, q, load.moments(model.robot, q, None))
    across = J.T @ without_common(slopes, poses.places).reshape(len(J), -1) / SEATING_DEVIATION
    by_place = np.add.reduceat(
        (J * errors[:, None]).reshape(len(q), 3, -1).sum(axis=1), starts(poses.places)
    )
    by_place = by_place - by_place.mean(axis=0)
    return across @ full.covariance[: model.size, : model.size] @ across.T + by_place.T @ by_place


def _cautious_step(
    hessian: np.ndarray, slope: np.ndarray, uncertainty: np.ndarray | None
) -> np.ndarray:
    """Return the s that minimises s^T H s - 2 s^T g + 2 CONFIDENCE sqrt(s^T U s)."""
    # (H + r U) s = g, with r such that r sqrt(s^T U s) = CONFIDENCE; zero if no r leaves so much.
    unit = 1 / np.sqrt(np.diag(hessian))
    root = np.linalg.inv(np.linalg.cholesky(hessian * unit[:, None] * unit)) * unit
    if uncertainty is None or not uncertainty.any():
        return root.T @ (root @ slope)
    widths, axes = np.linalg.eigh(root @ uncertainty @ root.T)
    widths = widths.clip(min=1e-9 * widths.max())
    along = axes.T @ root @ slope
    if np.sum(along**2 / widths) <= CONFIDENCE**2:
        return np.zeros_like(slope)
    least, most = 1e-12 / widths.max(), 1e12 / widths.min()
    for _ in range(60):
        r = (least * most) ** 0.5
        deviations = np.sum(widths * (r * along / (1 + r * widths)) ** 2) ** 0.5
        least, most = (r, most) if deviations < CONFIDENCE else (least, r)
    return root.T @ axes @ (along / (1 + least * widths))


def _weighted_mean(
    full: Posterior, load: Load, poses: Poses, closest: np.ndarray, alone: np.ndarray
) -> np.ndarray:
    """Return the weighted mean of two geometries."""
    model, q = full.model, poses.positions
    _, slopes, by_joints = model.linearise(full.x, q, load.moments(model.robot, q, None))
    rows = without_common(slopes, poses.places, 0.0).reshape(-1, model.size)
    variance = float(np.sum((rows @ full.covariance[: model.size, : model.size]) * rows))
    variance += float(np.trace(full.noise.as_gaussian(by_joints), axis1=1, axis2=2).sum())
    off, other = (
        without_common(model.ball.points(values, q) - poses.targets, poses.places, 0.0)
        for values in (closest, alone)
    )
    square = float(np.sum((off - other) ** 2))
    weight = square / (square + CHANCE_SHARE**2 * (float(np.sum(off**2)) + variance))
    return alone + weight * (closest - alone) if np.isfinite(weight) else closest

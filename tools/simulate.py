"""Synthetic recordings of an arm whose true kinematics are known.

A person's session is imitated: the ball sits in a socket, and the arm is guided to random
configurations within its limits, its last link tilted away from the vertical by as much as the
printed socket allows. What is written down are the joint positions that put the *true* ball there.
"""

from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from .. import MukcaError
from ..recorder.dataset import Placement, Sample
from ..solver.auto.deflection import Deflection
from ..solver.robot.kinematics import (
    BallModel,
    ball_position,
    gravity_torques,
    link_frames,
    workspace,
)
from ..solver.robot.urdf import Robot
from ..solver.robot.urdf_text import Origin

__all__ = [
    "Base",
    "Imperfection",
    "SimulationError",
    "perturb",
    "reachable_bases",
    "record",
]

BATCH = 256
MAX_TILT = np.deg2rad(50)
"""How far the neck of the ball leans from the vertical [rad]; the printed socket allows 60 deg."""


class SimulationError(MukcaError):
    """An arm that cannot do what is asked of it."""


@dataclass(frozen=True)
class Base:
    """Where a socket base stands: its sockets' centres in the robot's base frame."""

    name: str
    centre: np.ndarray
    """Between sockets 0 and 1, shape (3,) [m]."""
    direction: np.ndarray
    """Unit vector from socket 0 to socket 1."""
    distance: float = 0.05
    """Between the sockets' centres [m]."""

    @property
    def sockets(self) -> tuple[np.ndarray, np.ndarray]:
        """The centres of sockets 0 and 1."""
        half = 0.5 * self.distance * self.direction
        return self.centre - half, self.centre + half


def perturb(
    robot: Robot, generator: np.random.Generator, translation: float, angle: float
) -> Robot:
    """Return an arm like the nominal one, its actuated joints' and ball's origins a little off.

    Its size is that of the nominal arm: links are machined to better than 0.1 %, and what is off
    by millimetres is off in all directions.

    Args:
        robot: The nominal arm.
        generator: Source of randomness.
        translation: Standard deviation of x, y, z [m].
        angle: Standard deviation of roll, pitch, yaw [rad]; the ball's own are left, since they
            have no effect.
    """
    moved = [joint.actuated or joint is robot.ball_joint for joint in robot.joints]
    joints = tuple(
        replace(joint, origin=_shifted(joint.origin, generator, translation, angle))
        if free
        else joint
        for joint, free in zip(robot.joints, moved, strict=True)
    )
    arm = replace(robot, joints=joints)
    for _ in range(4):  # fixed joints keep their lengths, so the others take their part
        ratio = _size(robot) / _size(arm)
        joints = tuple(
            replace(joint, origin=_scaled(joint.origin, ratio)) if free else joint
            for joint, free in zip(arm.joints, moved, strict=True)
        )
        arm = replace(arm, joints=joints)
    return arm


def _size(robot: Robot) -> float:
    """Return the size of the cloud of ball positions in the workspace [m]."""
    points = BallModel(robot, []).points(np.empty(0), workspace(robot, 200))
    return float(np.linalg.norm(points - points.mean(axis=0)))


def _scaled(origin: Origin, ratio: float) -> Origin:
    x, y, z = (np.array(origin.xyz) * ratio).tolist()
    return Origin((x, y, z), origin.rpy)


def _shifted(
    origin: Origin, generator: np.random.Generator, translation: float, angle: float
) -> Origin:
    x, y, z = (np.array(origin.xyz) + generator.normal(0, translation, 3)).tolist()
    roll, pitch, yaw = (np.array(origin.rpy) + generator.normal(0, angle, 3)).tolist()
    return Origin((x, y, z), (roll, pitch, yaw))


class Guide:
    """Finds configurations that put the ball at points: what the user's hand does."""

    def __init__(self, robot: Robot) -> None:
        q = ca.SX.sym("q", len(robot.actuated))
        origins = ca.DM(robot.origins.ravel())
        p = ca.SX(ball_position(robot.joints, origins, q))
        neck = ca.SX(link_frames(robot.joints, origins, q)[-1][0])[:, 2]
        pose = ca.vertcat(p, neck)
        function = ca.Function("pose", [q], [pose, ca.densify(ca.jacobian(pose, q))], {"cse": True})
        self.robot = robot
        self._poses = function.map(BATCH)
        # Arms with endless or very wide joints are guided through one turn only.
        self.lower = np.array([max(j.lower, -np.pi) for j in robot.actuated])
        self.upper = np.array([min(j.upper, np.pi) for j in robot.actuated])

    def reach(
        self, points: np.ndarray, generator: np.random.Generator, rounds: int = 40
    ) -> np.ndarray:
        """Return one random configuration within the limits for each point.

        Args:
            points: Where the ball is to be, shape (N, 3) [m].
            generator: Source of randomness.
            rounds: How many batches of random starts may bring nothing.

        Returns:
            Joint positions, shape (N, m).

        Raises:
            SimulationError: A point is out of reach.
        """
        found = np.full((len(points), len(self.lower)), np.nan)
        failures = 0
        while (missing := np.flatnonzero(np.isnan(found[:, 0]))).size:
            if failures == rounds:
                where = np.round(points[missing[0]], 3).tolist()
                raise SimulationError(f"{self.robot.name}: cannot reach {where}")
            rows = np.resize(missing, BATCH)
            q, arrived = self._solve(points[rows], generator)
            found[rows[arrived]] = q[arrived]
            failures = 0 if arrived.any() else failures + 1
        return found

    def _solve(
        self, points: np.ndarray, generator: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return damped Newton solutions from random starts, and which of them arrived."""
        q = generator.uniform(self.lower, self.upper, (BATCH, len(self.lower)))
        targets = np.concatenate([points, _random_necks(generator)], axis=1)
        for step in range(30):
            pose, J = self._linear(q)
            error = targets - pose
            damping = 1e-4 if step < 18 else 1e-10
            JJ = J @ J.transpose(0, 2, 1) + damping * np.eye(6)
            dq = (J.transpose(0, 2, 1) @ np.linalg.solve(JJ, error[:, :, None]))[:, :, 0]
            q = q + dq * np.minimum(1.0, 0.5 / np.abs(dq).max(axis=1, keepdims=True).clip(1e-9))
        error = targets - self._linear(q)[0]
        exact = np.linalg.norm(error[:, :3], axis=1) < 1e-12
        tilted = np.linalg.norm(error[:, 3:], axis=1) < 1e-6
        inside = np.all((self.lower < q) & (q < self.upper), axis=1)
        return q, exact & tilted & inside

    def _linear(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return ball and neck, shape (B, 6), and their derivatives, shape (B, 6, m)."""
        pose, by_q = self._poses(q.T)
        return pose.full().T, by_q.full().T.reshape(BATCH, -1, 6).transpose(0, 2, 1)


def _random_necks(generator: np.random.Generator) -> np.ndarray:
    """Return directions within the allowed tilt of straight down, even over the cap."""
    height = generator.uniform(np.cos(MAX_TILT), 1.0, BATCH)
    angle = generator.uniform(-np.pi, np.pi, BATCH)
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), -height], axis=1)


@dataclass(frozen=True)
class Imperfection:
    """What else is not ideal in an arm and its recording."""

    noise: float = 0.0
    """Standard deviation of the ball's seat, per axis [m]."""
    deflection: Deflection = field(default_factory=Deflection)
    """Joint compliance and transmission error."""
    backlash: float = 0.0
    """Full play of each joint [rad]; the hand pushes it to either side at random."""
    hand: float = 0.0
    """Standard deviation per axis of a force of the hand on the ball [N]; it is then measured:
    the samples carry joint efforts."""


def record(
    arm: Robot,
    base: Base,
    generator: np.random.Generator,
    *,
    samples: int = 30,
    noise: float = 0.0,
    imperfection: Imperfection | None = None,
) -> Placement:
    """Return a placement recorded with an arm.

    Args:
        arm: With its true kinematics.
        base: Where the sockets are.
        generator: Source of randomness.
        samples: Configurations in each socket.
        noise: Standard deviation of the ball's seat, per axis [m].
        imperfection: What else is not ideal; its own noise counts then.

    Raises:
        SimulationError: The base is out of the arm's reach.
    """
    how = imperfection or Imperfection(noise)
    seats = np.repeat(base.sockets, samples, axis=0)
    seats = seats + generator.normal(0, 1, seats.shape) * how.noise
    true = Guide(arm).reach(seats, generator)
    torques = gravity_torques(arm, true)
    if how.hand:
        force = generator.normal(0, how.hand, (len(true), 3))
        slopes = BallModel(arm, []).linearise(np.empty(0), true).by_joints
        torques = torques - np.einsum("nij,ni->nj", slopes, force)
    read = _readings(true, torques, how.deflection)
    read = read + generator.choice([-0.5, 0.5], read.shape) * how.backlash
    efforts = map(tuple, torques.tolist()) if how.hand else [None] * len(read)
    found = tuple(
        Sample(tuple(q), socket=i // samples, effort=effort)
        for i, (q, effort) in enumerate(zip(read.tolist(), efforts, strict=True))
    )
    return Placement(base.name, found, arm.joint_names, base.distance)


def _readings(true: np.ndarray, torques: np.ndarray, deflection: Deflection) -> np.ndarray:
    """Return what the encoders read at true joint positions: the inverse of the deflection."""
    read = true
    for _ in range(8):  # contracts by the slope of the deflection, some 1e-3, each time
        read = true - (deflection.true_positions(read, torques) - read)
    return read


def reachable_bases(
    robot: Robot, generator: np.random.Generator, count: int, distance: float = 0.05
) -> list[Base]:
    """Return places for the base that are spread over an arm's workspace and within its reach.

    They stand on a table at the height of the robot's base or up to a quarter of its reach above,
    each far from those before.

    Raises:
        SimulationError: No such places were found.
    """
    guide = Guide(robot)
    reach = float(np.linalg.norm(robot.origins[:, :3], axis=1).sum())
    bases: list[Base] = []
    for _ in range(400):
        radius, angle = generator.uniform(0.35, 0.65) * reach, generator.uniform(-2.0, 2.0)
        height = generator.uniform(0.0, 0.25) * reach
        centre = np.array([radius * np.cos(angle), radius * np.sin(angle), height])
        turn = generator.uniform(-np.pi, np.pi)
        base = Base(
            f"placement_{len(bases)}",
            centre,
            np.array([np.cos(turn), np.sin(turn), 0.0]),
            distance,
        )
        apart = all(np.linalg.norm(centre - other.centre) > 0.2 * reach for other in bases)
        if apart and _reachable(guide, base, generator):
            bases.append(base)
        if len(bases) == count:
            return bases
    raise SimulationError(f"{robot.name}: found {len(bases)} of {count} places for the base")


def _reachable(guide: Guide, base: Base, generator: np.random.Generator) -> bool:
    """Tell whether several ways lead to both sockets, as a person would see at once."""
    try:
        guide.reach(np.repeat(base.sockets, 5, axis=0), generator, rounds=2)
    except SimulationError:
        return False
    return True

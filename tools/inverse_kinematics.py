"""Finds joint positions that put the ball where it should be, with its neck near the vertical.

This is the inverse kinematics of a person's hand that guides the arm into a socket. Many random
starts go side by side, so that the answers are spread over all that the arm can do.
"""

import casadi as ca
import numpy as np

from .. import MukcaError
from ..solver.robot.kinematics import ball_position, link_frames
from ..solver.robot.urdf import Robot

__all__ = ["MAX_TILT", "Guide", "SimulationError"]

BATCH = 256
"""Random starts that are followed at once."""
MAX_TILT = np.deg2rad(50)
"""How far the neck of the ball leans from the vertical [rad]; the printed socket allows 60 deg."""


class SimulationError(MukcaError):
    """An arm that cannot do what is asked of it."""


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
        reached = np.full((len(points), len(self.lower)), np.nan)
        failures = 0
        while (missing := np.flatnonzero(np.isnan(reached[:, 0]))).size:
            if failures == rounds:
                where = np.round(points[missing[0]], 3).tolist()
                raise SimulationError(f"{self.robot.name}: cannot reach {where}")
            rows = np.resize(missing, BATCH)
            q, arrived = self._solve(points[rows], generator)
            reached[rows[arrived]] = q[arrived]
            failures = 0 if arrived.any() else failures + 1
        return reached

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

"""Inverse kinematics: joint positions that put the ball at points, its neck near the vertical.

It imitates a person's hand that guides the arm into a socket. Many random starts are followed at
once, so that the solutions are spread over all that the arm can do.
"""

from dataclasses import dataclass

import numpy as np

from ...errors import MukcaError
from ..identification.robot import (
    Robot,
    SegmentLayout,
    cross,
    frames_of,
    one_turn,
)

BATCH = 256
"""Random starts that are drawn at once."""
FIRST = 64
"""Number of them that are followed first, and then all others."""
MARGIN = 0.1
"""A start that is this far outside of the limits at the target stays outside [rad, m]."""
MAX_STEP = 0.5
"""Largest step of a joint on its way to the target [rad, m]."""
MAX_TILT = np.deg2rad(50)
"""Largest lean of the ball's neck from the vertical [rad]; the printed socket allows 60 deg."""


class SimulationError(MukcaError):
    """An arm that cannot do what is asked of it."""


@dataclass(frozen=True)
class NewtonSteps:
    """Damped Newton steps: their number, and when they end."""

    rounds: int
    damping: float
    tolerance: float
    """A smaller step is the last one [rad, m]."""


COARSE = NewtonSteps(rounds=18, damping=1e-4, tolerance=1e-5)
FINE = NewtonSteps(rounds=12, damping=1e-10, tolerance=1e-7)


def damped_steps(
    J: np.ndarray,
    errors: np.ndarray,
    damping: float | np.ndarray,
) -> np.ndarray:
    """Return J^T (J J^T + d 1)^-1 e: steps of joints that lead balls to targets, shape (N, m).

    Of derivatives J, shape (N, k, m), and what is left to the targets, errors e, (N, k).
    """
    across = J.swapaxes(1, 2)
    damped = J @ across + damping * np.eye(errors.shape[1])
    return (across @ np.linalg.solve(damped, errors[:, :, None]))[:, :, 0]


class InverseKinematics:
    """Finds configurations that put the ball at points."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        layout = SegmentLayout(robot.joints, len(robot.actuated))
        self._chain = layout.chain(frames_of(robot.joints))
        # Fewer than six joints cannot lean the neck to all sides: any lean within the cap will do.
        self._leans_freely = len(robot.actuated) >= 6
        self.lower, self.upper = one_turn(robot)
        self._turning = (
            np.array([joint.type for joint in robot.actuated]) != "prismatic"
        )
        limits = np.abs([robot.lower, robot.upper])
        slides = limits.max(axis=0)[~self._turning]
        lengths = np.linalg.norm(robot.origins[:, :3], axis=1)
        self.longest = float(lengths.sum() + slides.sum())
        """No point farther from the base is in reach [m]."""

    def reach(
        self,
        points: np.ndarray,
        generator: np.random.Generator,
        rounds: int = 40,
    ) -> np.ndarray:
        """Return a random configuration within the limits for each point, (N, 3) [m], shape (N, m).

        So many ``rounds`` of random starts may bring nothing.

        Raises:
            SimulationError: A point is out of reach.
        """
        too_far = np.linalg.norm(points, axis=1) > self.longest
        if too_far.any():
            raise self._out_of_reach(points[too_far][0])
        reached = np.full((len(points), len(self.lower)), np.nan)
        failures = 0
        while (rows := np.flatnonzero(np.isnan(reached[:, 0]))).size:
            if failures == rounds:
                raise self._out_of_reach(points[rows[0]])
            arrived = self._round(points, reached, rows, generator)
            failures = 0 if arrived else failures + 1
        return reached

    def arrivals(
        self,
        point: np.ndarray,
        generator: np.random.Generator,
    ) -> np.ndarray:
        """Return the configurations in which a batch of random starts reach a point, (N, m).

        Args:
            point: Where the ball is to be, shape (3,) [m].
            generator: It draws the starts, of which few or none may arrive.
        """
        if np.linalg.norm(point) > self.longest:
            return np.zeros((0, len(self.lower)))
        starts, necks = self._random_starts(generator)
        points = np.tile(point, (BATCH, 1))
        q, arrived = self._follow(starts, np.hstack([points, necks]))
        return q[arrived]

    def _out_of_reach(self, point: np.ndarray) -> SimulationError:
        """Return the error for a point that no start reached."""
        place = np.round(point, 3).tolist()
        return SimulationError(f"{self.robot.name}: cannot reach {place}")

    def _round(
        self,
        points: np.ndarray,
        reached: np.ndarray,
        failures: np.ndarray,
        generator: np.random.Generator,
    ) -> bool:
        """Follow a batch of random starts, the last few first; return True if any arrived."""
        starts, necks = self._random_starts(generator)
        rows = np.resize(failures, BATCH)
        others, first = np.split(np.arange(BATCH), [BATCH - FIRST])
        for batch in (first, others):
            open_rows = np.isnan(reached[rows[batch], 0])
            some = batch[open_rows]
            if not some.size:
                continue
            targets = np.hstack([points[rows[some]], necks[some]])
            q, arrived = self._follow(starts[some], targets)
            reached[rows[some[arrived]]] = q[arrived]
        return not np.isnan(reached[failures, 0]).all()

    def _random_starts(
        self,
        generator: np.random.Generator,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return joint positions, (BATCH, m), and directions of necks, even over the cap."""
        shape = BATCH, len(self.lower)
        positions = generator.uniform(self.lower, self.upper, shape)
        height = generator.uniform(np.cos(MAX_TILT), 1.0, BATCH)
        angle = generator.uniform(-np.pi, np.pi, BATCH)
        radius = np.sqrt(1 - height**2)
        x = radius * np.cos(angle)
        y = radius * np.sin(angle)
        return positions, np.column_stack([x, y, -height])

    def _follow(
        self,
        q: np.ndarray,
        targets: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return damped Newton solutions from some starts, and which of them arrived."""
        q = q.copy()
        self._iterate(q, targets, np.arange(len(q)), COARSE)
        turns = np.round(q / (2 * np.pi)) * self._turning
        q -= 2 * np.pi * turns
        # Many are outside the limits, and stay there: the others are worth the last steps.
        above = q - self.upper
        beyond = np.maximum(self.lower - q, above).max(axis=1)
        feasible = np.flatnonzero(beyond < MARGIN)
        goals = targets if self._leans_freely else targets[:, :3]
        self._iterate(q, goals, feasible, FINE)
        arrived = np.zeros(len(q), dtype=bool)
        arrived[feasible] = self._has_arrived(q[feasible], targets[feasible])
        return q, arrived

    def _has_arrived(
        self,
        q: np.ndarray,
        targets: np.ndarray,
    ) -> np.ndarray:
        """Return True where a configuration is within the limits, and reaches its target, (N,)."""
        pose, _ = self.ball_and_neck(q)
        error = targets - pose
        exact = np.linalg.norm(error[:, :3], axis=1) < 1e-12
        tilted = np.linalg.norm(error[:, 3:], axis=1) < 1e-6
        if not self._leans_freely:
            tilted = pose[:, 5] < -np.cos(MAX_TILT)
        within = (self.lower < q) & (q < self.upper)
        return exact & tilted & within.all(axis=1)

    def _iterate(
        self,
        q: np.ndarray,
        targets: np.ndarray,
        moving: np.ndarray,
        steps: NewtonSteps,
    ) -> None:
        """Take damped Newton steps in some rows of q until they arrive.

        Targets of three numbers are those of the ball alone.
        """
        rows = targets.shape[1]
        for _ in range(steps.rounds):
            if not moving.size:
                break
            pose, jacobian = self.ball_and_neck(q[moving])
            errors = targets[moving] - pose[:, :rows]
            dq = damped_steps(jacobian[:, :rows], errors, steps.damping)
            longest = np.abs(dq).max(axis=1).clip(1e-9)
            dq *= np.minimum(1.0, MAX_STEP / longest)[:, None]
            q[moving] += dq
            goes_on = np.minimum(longest, MAX_STEP) > steps.tolerance
            moving = moving[goes_on]

    def ball_and_neck(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return ball and neck, shape (N, 6), and their derivatives, shape (N, 6, m)."""
        chain = self._chain
        segments = chain.at(q)
        neck = chain.rotation(segments)[:, :, 2]
        motions = chain.layout.by_q
        shifts = segments.by_rows(motions, motions.shifts(chain.ball_seen(segments)))
        turns = segments.by_rows(motions, motions.turns[:, :, None])
        of_neck = cross(turns, neck[:, :, None])
        return np.hstack([chain.ball(segments).T, neck]), np.hstack([shifts, of_neck])

"""Inverse kinematics: joint positions that put the ball at points, its neck near the vertical.

It imitates a person's hand that guides the arm into a socket. Many random starts are followed at
once, so that the solutions are spread over all that the arm can do.
"""

from functools import lru_cache

import casadi as ca
import numpy as np

from ...errors import MukcaError
from .kinematics import frames_and_motions, written_frames
from .row_function import RowFunction
from .urdf import Joint, Robot

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


class InverseKinematics:
    """Finds configurations that put the ball at points."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._pose = _pose(robot.joints)
        # Fewer than six joints cannot lean the neck to all sides: any lean within the cap will do.
        self._leans_freely = len(robot.actuated) >= 6
        self.lower, self.upper = _one_turn(robot)
        self._turning = np.array(
            [joint.type != "prismatic" for joint in robot.actuated]
        )
        slides = np.abs([robot.lower, robot.upper]).max(axis=0)[~self._turning]
        lengths: np.ndarray = np.linalg.norm(robot.origins[:, :3], axis=1)
        self.longest = float(lengths.sum() + slides.sum())
        """No point farther from the base is in reach [m]."""

    def reach(
        self, points: np.ndarray, generator: np.random.Generator, rounds: int = 40
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

    def arrivals(self, point: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """Return the configurations in which a batch of random starts reach a point, (N, m).

        Args:
            point: Where the ball is to be, shape (3,) [m].
            generator: It draws the starts, of which few or none may arrive.
        """
        if np.linalg.norm(point) > self.longest:
            return np.zeros((0, len(self.lower)))
        starts, necks = self._random_starts(generator)
        q, arrived = self._follow(
            starts, np.hstack([np.tile(point, (BATCH, 1)), necks])
        )
        return q[arrived]

    def _out_of_reach(self, point: np.ndarray) -> SimulationError:
        return SimulationError(
            f"{self.robot.name}: cannot reach {np.round(point, 3).tolist()}"
        )

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
        for batch in np.split(np.arange(BATCH), [BATCH - FIRST])[::-1]:
            some = batch[np.isnan(reached[rows[batch], 0])]
            if some.size:
                targets = np.hstack([points[rows[some]], necks[some]])
                q, arrived = self._follow(starts[some], targets)
                reached[rows[some[arrived]]] = q[arrived]
        return not np.isnan(reached[failures, 0]).all()

    def _random_starts(
        self, generator: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return joint positions, and directions of necks that are even over the cap of tilts."""
        starts = generator.uniform(self.lower, self.upper, (BATCH, len(self.lower)))
        height = generator.uniform(np.cos(MAX_TILT), 1.0, BATCH)
        angle = generator.uniform(-np.pi, np.pi, BATCH)
        radius = np.sqrt(1 - height**2)
        necks = np.column_stack(
            [radius * np.cos(angle), radius * np.sin(angle), -height]
        )
        return starts, necks

    def _follow(
        self, q: np.ndarray, targets: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return damped Newton solutions from some starts, and which of them arrived."""
        q = q.copy()
        self._iterate(q, targets, np.arange(len(q)), follows=False)
        turns = np.round(q / (2 * np.pi)) * self._turning
        q -= 2 * np.pi * turns
        # Many are outside the limits, and stay there: the others are worth the last steps.
        beyond = np.maximum(self.lower - q, q - self.upper).max(axis=1)
        feasible = np.flatnonzero(beyond < MARGIN)
        self._iterate(q, targets, feasible, follows=True)
        pose = self.ball_and_neck(q[feasible])[0]
        error = targets[feasible] - pose
        exact = np.linalg.norm(error[:, :3], axis=1) < 1e-12
        tilted = np.linalg.norm(error[:, 3:], axis=1) < 1e-6
        if not self._leans_freely:
            tilted = pose[:, 5] < -np.cos(MAX_TILT)
        within = (self.lower < q) & (q < self.upper)
        inside = within[feasible].all(axis=1)
        arrived = np.zeros(len(q), dtype=bool)
        arrived[feasible] = exact & tilted & inside
        return q, arrived

    def _iterate(
        self, q: np.ndarray, targets: np.ndarray, moving: np.ndarray, *, follows: bool
    ) -> None:
        """Take damped Newton steps in some rows of q until they arrive."""
        rounds, damping, tolerance = (12, 1e-10, 1e-7) if follows else (18, 1e-4, 1e-5)
        rows = 3 if follows and not self._leans_freely else 6
        for _ in range(rounds):
            if not moving.size:
                break
            pose, J = self.ball_and_neck(q[moving])
            error = (targets[moving] - pose)[:, :rows, None]
            slope = J[:, :rows]
            transposed = slope.transpose(0, 2, 1)
            JJ = slope @ transposed + damping * np.eye(rows)
            dq = (transposed @ np.linalg.solve(JJ, error))[:, :, 0]
            longest = np.abs(dq).max(axis=1).clip(1e-9)
            dq *= np.minimum(1.0, MAX_STEP / longest)[:, None]
            q[moving] += dq
            moving = moving[np.minimum(longest, MAX_STEP) > tolerance]

    def ball_and_neck(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return ball and neck, shape (N, 6), and their derivatives, shape (N, 6, m)."""
        N, m = q.shape
        pose, by_q = self._pose(q)
        return pose, by_q.reshape(N, 6, m)


@lru_cache(maxsize=16)
def _pose(joints: tuple[Joint, ...]) -> RowFunction:
    """Return ball, neck and their derivatives as a function of joint positions."""
    q = ca.SX.sym("q", sum(joint.actuated for joint in joints))
    frames, _, motions = frames_and_motions(joints, written_frames(joints), q)
    R, ball = map(ca.SX, frames[-1])
    neck = R[:, 2]
    columns = [
        ca.vertcat(motion.shift(ball), ca.cross(motion.turn, neck))
        for motion in motions
    ]
    return RowFunction("pose", [q], [ca.vertcat(ball, neck), ca.horzcat(*columns)])


def _one_turn(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits of all joints, within -180 to 180 degrees: a hand guides no farther."""
    return np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)


def workspace(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Return random joint positions within the joints' limits, shape (count, m) [rad].

    Joints that turn farther stay within -180 to 180 degrees.
    """
    size = count, len(robot.actuated)
    return np.random.default_rng(seed).uniform(*_one_turn(robot), size)

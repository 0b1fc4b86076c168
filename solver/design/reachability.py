"""Poses to which a hand can lead the arm, with the ball in a socket."""

from functools import cached_property

import numpy as np

from ..identification.robot import Robot, link_poses, workspace
from ..poses import InverseKinematics, damped_steps

MARGIN = 0.05
"""Distance of a pose from each end of a joint's range, as a share of it."""
TABLE = 0.03
"""Least height of each link's frame above the table [m]."""
MOVES = 0.15
"""A frame that moves by less than this is part of the robot's foot [m]."""
STEPS = 16
"""Steps of a way from pose to pose that are looked at."""
OFF = 1e-3
"""The ball is this near to its seat on a way that it follows [m]."""
LEAN = np.deg2rad(58)
"""Lean of the ball's neck on a way; the printed socket allows 60 deg [rad]."""
BATCHES = 40
"""Batches of random starts: where few arrive, fewer poses do, so that the guide answers soon."""
FUTILE = 3
"""A place that none of so many batches reached is out of reach."""
FOOT = 0.03
"""The ball's centre is about so high above the table [m]."""


class Reach:
    """Finds poses that a hand can reach, from random starts.

    No joint turns farther than ``turn`` [rad] from where a session began.
    """

    def __init__(
        self,
        robot: Robot,
        turn: float = np.inf,
    ) -> None:
        self.robot = robot
        self.turn = turn
        self._guide = InverseKinematics(robot)
        self._generator = np.random.default_rng(0)

    def poses(self, centre: np.ndarray, count: int) -> np.ndarray:
        """Return poses with the ball at a place, spread over all that is reachable.

        Inside the limits with a margin, the ball's neck within the socket's cone, and no link
        that moves below the table, on which the robot stands, or the socket if that is lower.

        Args:
            centre: The socket's, shape (3,) [m].
            count: How many are wanted; fewer may be found.

        Returns:
            Joint positions, shape (N, m); N is 0 where the place is out of reach.
        """
        reached = np.zeros((0, len(self._guide.lower)))
        for batch in range(BATCHES):
            q = self._guide.arrivals(centre, self._generator)
            is_allowed = self._allowed(q, centre)
            reached = np.concatenate([reached, q[is_allowed]])
            is_futile = batch > FUTILE and not len(reached)
            if len(reached) >= count or is_futile:
                break
        return reached[:count]

    def poses_between(
        self,
        centre: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        count: int,
    ) -> np.ndarray:
        """Return poses with the ball at a place, and each joint between two bounds.

        Args:
            centre: The socket's, shape (3,) [m].
            lower: The least positions of the joints, shape (m,) [rad], [m].
            upper: Their greatest, shape (m,).
            count: Number of random starts; fewer arrive.
        """
        starts = self._generator.uniform(lower, upper, (count, len(lower)))
        seats = np.tile(centre, (count, 1))
        q = self._led(starts, seats)
        is_between = np.all((q >= lower) & (q <= upper), axis=1)
        return q[is_between & self._is_seated(q, seats) & self._allowed(q, centre)]

    def _allowed(
        self,
        q: np.ndarray,
        centre: np.ndarray,
        gap: float = MARGIN,
    ) -> np.ndarray:
        """Return a mask of poses that are clear of the limits and of the table, shape (N,)."""
        lower = self._guide.lower
        upper = self._guide.upper
        margin = gap * (upper - lower)
        is_inside = (q > lower + margin) & (q < upper - margin)
        heights = link_poses(self.robot.joints, q)[:, self._moving, 2, 3]
        is_above = heights > min(0.0, centre[2] - FOOT) + TABLE
        return np.all(np.column_stack([is_inside, is_above]), axis=1)

    def seated(self, start: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Return a mask of poses that are reached while the ball stays in its socket, shape (N,).

        All joints turn evenly, as far as the ball lets them, from ``start``, shape (m,), to
        ``ends``, shape (N, m).
        """
        q = np.tile(start, (len(ends), 1))
        before = self._balls(q)
        after = self._balls(ends)
        largest = 3 * _turns(start, ends) / STEPS + 1e-3
        masks: list[np.ndarray] = []
        for step in range(STEPS, 1, -1):
            share = (step - 1) / STEPS
            seats = after + (before - after) * share
            position = self._led(q + (ends - q) / step, seats)
            masks += [
                self._is_seated(position, seats),
                self._allowed(position, after[0], gap=0.0),
                _turns(q, position) < largest,
            ]
            q = position
        masks.append(_turns(q, ends) < largest)
        return np.all(masks, axis=0)

    def _is_seated(self, q: np.ndarray, seats: np.ndarray) -> np.ndarray:
        """Return a mask of poses whose balls are in their seats, and lean little, shape (N,)."""
        pose, _ = self._guide.ball_and_neck(q)
        is_near = np.linalg.norm(seats - pose[:, :3], axis=1) < OFF
        return is_near & (pose[:, 5] < -np.cos(LEAN))

    def _led(self, q: np.ndarray, seats: np.ndarray) -> np.ndarray:
        """Return poses near some with their balls in seats, shape (N, m).

        Each of three steps is J^T (J J^T + 1e-6)^-1 times what a ball falls short of its seat by.
        """
        for _ in range(3):
            pose, slopes = self._guide.ball_and_neck(q)
            q = q + damped_steps(slopes[:, :3], seats - pose[:, :3], 1e-6)
        return q

    def _balls(self, q: np.ndarray) -> np.ndarray:
        poses, _ = self._guide.ball_and_neck(q)
        return poses[:, :3]

    @cached_property
    def _moving(self) -> np.ndarray:
        """Indices of the frames that move, the ball's left out."""
        links = link_poses(self.robot.joints, workspace(self.robot, 50))
        spans = np.ptp(links[:, :-1, :, 3], axis=0)
        return np.flatnonzero(spans.max(axis=1) > MOVES)


def _turns(start: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the largest turn of a joint from poses to others, shape (N,) [rad]."""
    return np.abs(ends - start).max(axis=1)

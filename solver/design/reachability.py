"""Poses to which a hand can lead the arm, with the ball in a socket."""

from functools import cached_property

import casadi as ca
import numpy as np

from ..robot import InverseKinematics, Robot, RowFunction, SimulationError, link_frames, workspace

MARGIN = 0.05
"""Distance of a pose from each end of a joint's range, as a share of it."""
TABLE = 0.03
"""Least height of each link's frame above the table [m]."""
MOVES = 0.15
"""A frame that moves by less than this is part of the robot's foot [m]."""
FOOT = 0.03
"""The ball's centre is about so high above the table [m]."""


class Reach:
    """Finds poses that a hand can reach.

    Args:
        robot: The nominal robot.
        seed: Of the random starts.
    """

    def __init__(self, robot: Robot, seed: int = 0) -> None:
        self.robot = robot
        self._guide = InverseKinematics(robot)
        self._generator = np.random.default_rng(seed)

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
        for _ in range(4):
            try:
                q = self._guide.reach(np.tile(centre, (count, 1)), self._generator, rounds=2)
            except SimulationError:
                break
            reached = np.concatenate([reached, q[self._allowed(q, centre)]])
            if len(reached) >= count:
                break
        return reached[:count]

    def _allowed(self, q: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """Return a mask of poses that are clear of the limits and of the table, shape (N,)."""
        margin = MARGIN * (self._guide.upper - self._guide.lower)
        inside = np.all((q > self._guide.lower + margin) & (q < self._guide.upper - margin), axis=1)
        height = self._frames(q)[0].reshape(len(q), -1, 3)[:, self._moving, 2]
        return inside & np.all(height > min(0.0, centre[2] - FOOT) + TABLE, axis=1)

    @cached_property
    def _moving(self) -> np.ndarray:
        """Indices of the frames that move, the ball's left out."""
        places = self._frames(workspace(self.robot, 50))[0].reshape(50, -1, 3)[:, :-1]
        return np.flatnonzero(np.ptp(places, axis=0).max(axis=1) > MOVES)

    @cached_property
    def _frames(self) -> RowFunction:
        return skeleton(self.robot)


def skeleton(robot: Robot) -> RowFunction:
    """Return the places of the joints' child links as a function of joint positions.

    The values of the function are x, y, z of each joint in turn, shape (N, 3 joints) [m].
    """
    q = ca.SX.sym("q", len(robot.actuated))
    frames = link_frames(robot.joints, ca.DM(robot.origins.ravel()), q)
    places = ca.vertcat(*(ca.SX(p) for _, p in frames))
    return RowFunction("skeleton", [q], [ca.densify(places)])

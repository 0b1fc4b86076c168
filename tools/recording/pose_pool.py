"""Poses that a hand can reach with the ball in a socket, new ones, by the nominal model."""

import math
from collections.abc import Sequence

import numpy as np

from ...recorder import Sample
from ...recorder.session import NO_ANSWERS, Answers
from ...solver import design, diagnostics
from ...solver.identification.data import CALIPER_DEVIATION
from ...solver.identification.model import Noise, extend
from ...solver.identification.robot import Robot, choose_parameters

Captures = Sequence[Sample]
"""Samples of a session so far."""
ALIKE = np.deg2rad(5)
"""A pose that turns every joint less than this from a sample, or from one that was followed, is no
new one [rad]."""
CANDIDATES = 600
"""Number of compared poses."""
STARTS = 4 * CANDIDATES
"""Number of starts of poses where the samples went: few of them arrive in their socket."""
BESIDE = np.deg2rad(10)
"""So far beyond all samples a hand may still lead each joint [rad]."""
NEIGHBOURS = 0.1
"""Share of all poses that are dropped with one that cannot be taken."""
SEAT = Noise(1e-4, 0.0)
"""Noise of a sample, before there are enough to estimate it [m]."""


class PosePool:
    """Poses in each socket, no joint farther than ``turn`` from the session's begin [rad]."""

    def __init__(self, robot: Robot, turn: float) -> None:
        self.reach = design.Reach(robot)
        self.model = extend(robot, choose_parameters(robot))
        self._turn = turn
        self._poses: dict[int, np.ndarray] = {}
        self._answers = NO_ANSWERS

    def heed(self, answers: Answers) -> None:
        """Hold to what the operator has answered: which poses cannot be taken."""
        self._answers = answers

    def centre(self, samples: Captures, socket: int) -> np.ndarray | None:
        """Return a socket's position by the nominal model [m]; None without a sample in it."""
        q = positions_in(samples, socket)
        if not len(q):
            return None
        points = self.model.ball.points(self.model.ball.nominal, q)
        return np.asarray(np.median(points, axis=0))

    def place_beside(self, recorded: Sequence[Captures]) -> np.ndarray:
        """Return a place of the base, far from those of some samples, shape (3,) [m]."""
        ball = self.model.ball
        q = [np.array([s.position for s in samples]) for samples in recorded]
        points = [ball.points(ball.nominal, positions) for positions in q]
        return diagnostics.farthest_place(np.array([p.mean(axis=0) for p in points]))

    def with_distance(
        self,
        state: design.ParameterCovariance,
        samples: Captures,
        socket: int = 0,
    ) -> design.ParameterCovariance:
        """Return a covariance with the measured distance of two sockets, from ``socket`` on."""
        first = self.centre(samples, 0)
        second = self.centre(samples, 1)
        if first is None or second is None:
            return state
        along = (second - first) / np.linalg.norm(second - first).clip(1e-6)
        return state.with_lengths(
            {socket: -along, socket + 1: along}, CALIPER_DEVIATION
        )

    def lifted(
        self,
        samples: Captures,
        position: Sequence[float] | None,
        target: Sequence[float],
    ) -> bool:
        """Return whether the ball must leave its socket on the way to a target."""
        start = samples[-1].position if position is None else position
        return not self.reach.seated(np.array(start), np.array([target]))[0]

    def candidates(self, samples: Captures, socket: int) -> np.ndarray:
        """Return new poses with the ball in a socket, shape (N, m); none before its first."""
        centre = self.centre(samples, socket)
        if centre is None:
            # Where samples lay that were taken back tells nothing.
            self._poses.pop(socket, None)
            return np.zeros((0, len(self.model.robot.actuated)))
        taken = np.array([s.position for s in samples])
        if self._answers.confined:
            lower, upper = taken.min(axis=0) - BESIDE, taken.max(axis=0) + BESIDE
            poses = self.reach.poses_between(centre, lower, upper, STARTS)
            if not len(poses):
                poses = positions_in(samples, socket)
        else:
            # They are spread over all that is reachable, as far as joints may turn.
            if socket not in self._poses:
                poses = self.reach.poses(centre, CANDIDATES)
                within_turn = np.abs(poses - taken[0]).max(axis=1) <= self._turn
                self._poses[socket] = poses[within_turn] if within_turn.any() else poses
            poses = self._poses[socket]
        for pose in self._answers.avoided:
            distances = np.abs(poses - pose).max(axis=1)
            poses = poses[distances >= np.quantile(distances, NEIGHBOURS)]
        former = np.array([*taken.tolist(), *self._answers.followed])
        turns = poses[:, None] - former
        turns -= math.tau * np.round(turns / math.tau)  # no slide is that long
        turns = np.abs(turns).max(axis=2).min(axis=1)
        return poses[turns >= min(ALIKE, turns.max(initial=0.0))]


def positions_in(samples: Captures, socket: int) -> np.ndarray:
    """Return the configurations of a socket's samples, shape (N, m)."""
    return np.array([s.position for s in samples if s.socket == socket])

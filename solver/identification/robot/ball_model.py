"""The ball's position by the numbers of the joints' frames, with its derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache, partial
from typing import Any, Literal

import casadi as ca
import numpy as np

from .kinematics import (
    JointFrame,
    frames_and_motions,
    frames_of_origins,
    rotation_rpy,
)
from .rotations import angles_near, rotation_vectors, turns_and_rates
from .segments import SegmentChain, SegmentLayout, Segments
from .swept_volume import log_volume
from .urdf import Robot

RotationNumbers = Literal["vector", "rpy"]
"""Meaning of the three numbers of a joint's rotation: a rotation vector in the joint's frame, zero
for the nominal robot, or the roll, pitch and yaw of its origin."""


@dataclass(frozen=True)
class Linearisation:
    """Ball positions of N samples, and their derivatives."""

    points: np.ndarray
    """Ball centres, shape (N, 3) [m]."""
    by_parameters: np.ndarray
    """Derivatives by the n free parameters, shape (N, 3, n)."""
    by_joints: np.ndarray
    """Derivatives by the m joint positions, shape (N, 3, m), or with tilts (N, 3, 3 m)."""


def nominal_balls(robot: Robot, positions: np.ndarray) -> np.ndarray:
    """Return where a robot's own model has the ball at joint positions (N, m), shape (N, 3) [m]."""
    model = BallModel(robot, free=[])
    return model.points(np.empty(0), positions)


class BallModel:
    """The ball's centre as a function of some free origin numbers and the joint positions.

    Args:
        robot: The robot.
        free: Variable origin numbers, as indices into ``robot.origins.ravel()`` (six for each
            joint); all others stay as the URDF has them.
        rotation_numbers: What the last three of each joint's six numbers are.
    """

    def __init__(
        self,
        robot: Robot,
        free: Sequence[int],
        rotation_numbers: RotationNumbers = "vector",
    ) -> None:
        self.robot = robot
        self.rotation_numbers: RotationNumbers = rotation_numbers
        self.free = np.array(free, dtype=int)
        self._origins = robot.origins
        self._frames = frames_of_origins(self._origins)
        self._given = self._origins.copy()
        if rotation_numbers == "vector":
            self._given[:, 3:] = 0.0
        numbers = self._given.ravel()
        self.nominal: np.ndarray = numbers[self.free]
        angles = self.free[self.free % 6 >= 3]
        self._turned = np.unique(angles // 6)
        self._layout = cache(partial(SegmentLayout, robot.joints, free=self.free))
        # several values are computed of the same segments in turn
        self._chain = lru_cache(maxsize=2)(self._chain_of)

    def __reduce__(self) -> tuple[Any, ...]:
        """Go to other processes without what was compiled here."""
        arguments = self.robot, self.free.tolist(), self.rotation_numbers
        return BallModel, arguments

    @property
    def function(self) -> Any:
        """The ball's position as a CasADi function of the free numbers and one configuration.

        Rotations are roll, pitch and yaw.
        """
        assert self.rotation_numbers == "rpy"
        x = ca.SX.sym("x", len(self.free))
        q = ca.SX.sym("q", len(self.robot.actuated))
        numbers = ca.SX(self._given.ravel())
        numbers[self.free.tolist()] = x
        frames: list[JointFrame] = []
        for i in range(len(self._given)):
            row = numbers[6 * i : 6 * i + 6]
            frames.append(JointFrame(row[:3], rotation_rpy(row[3:])))
        links, _ = frames_and_motions(self.robot.joints, frames, q)
        outputs = [ca.densify(links[-1].p)]
        return ca.Function("ball", [x, q], outputs, ["x", "q"], ["p"])

    def frames(self, parameters: np.ndarray) -> np.ndarray:
        """Return the frames [p | R | axes] of all joints in the links before them, (joints, 3, 7).

        Arguments are those of :meth:`points`. By a rotation vector w a joint's R is R exp(w).
        """
        numbers = self._numbers(parameters)
        if self.rotation_numbers == "rpy":
            return frames_of_origins(numbers)
        frames = self._frames.copy()
        frames[:, :, 0] = numbers[:, :3]
        vectors = numbers[self._turned, 3:]
        turns, rates = turns_and_rates(vectors)
        R = frames[self._turned, :, 1:4] @ turns
        frames[self._turned, :, 1:4] = R
        frames[self._turned, :, 4:] = R @ rates
        return frames

    def _numbers(self, parameters: np.ndarray) -> np.ndarray:
        """Return the numbers of all joints, shape (joints, 6)."""
        numbers = self._given.copy()
        numbers.ravel()[self.free] = parameters
        return numbers

    def origins(self, parameters: np.ndarray) -> np.ndarray:
        """Return the origins of all joints for values of the free numbers, shape (joints, 6).

        Of the angles that make a rotation they are the nearest to those written.
        """
        origins = self._numbers(parameters)
        if self.rotation_numbers == "rpy":
            return origins
        turned = origins[:, 3:].any(axis=1)
        origins[:, 3:] = self._origins[:, 3:]
        frames = self.frames(parameters)
        for i in np.flatnonzero(turned).tolist():
            R = frames[i, :, 1:4]
            origins[i, 3:] = angles_near(R, self._origins[i, 3:])
        return origins

    def parameters_at(self, origins: np.ndarray) -> np.ndarray:
        """Return the free numbers of an arm with such origins, shape (joints, 6), as (n,)."""
        numbers = origins.astype(float)
        if self.rotation_numbers == "vector":
            R = frames_of_origins(origins)[:, :, 1:4]
            R_nominal = self._frames[:, :, 1:4]
            changes = R_nominal.swapaxes(1, 2) @ R
            numbers[:, 3:] = rotation_vectors(changes)
        return numbers.ravel()[self.free]

    def slopes_of(
        self,
        model: "BallModel",
        parameters: np.ndarray,
    ) -> np.ndarray:
        """Return the derivatives of its free numbers by another model's, for the same frames.

        The other model has the same chain and free numbers, with values of shape (n,).
        """
        origins = model.origins(parameters)
        own_parameters = self.parameters_at(origins)
        axes = self.frames(own_parameters)[:, :, 4:]
        axes_before = model.frames(parameters)[:, :, 4:]
        slopes = np.eye(6 * len(axes))
        for i in self._turned.tolist():
            rotation = slice(6 * i + 3, 6 * i + 6)
            slopes[rotation, rotation] = np.linalg.solve(axes[i], axes_before[i])
        return slopes[np.ix_(self.free, self.free)]

    def turns(self, parameters: np.ndarray) -> np.ndarray:
        """Return the turn of the whole robot about the base's axes, shape (3, n) [rad/rad].

        Only the angles of origins up to the first joint that moves turn it.
        """
        moving = self.robot.actuated
        first = self.robot.joints.index(moving[0])
        q = np.zeros((1, len(moving)))
        turns = self.rotations(parameters, q).by_parameters[0]
        return np.where(self.free // 6 <= first, turns, 0.0)

    def points(
        self,
        parameters: np.ndarray,
        positions: np.ndarray,
    ) -> np.ndarray:
        """Return the ball's centres in the base frame, shape (N, 3) [m].

        The free numbers have values of shape (n,) [m, rad]; joint positions have shape (N, m)
        [rad], or with tilts (N, 3 m).
        """
        chain, segments = self._at(parameters, positions)
        return np.ascontiguousarray(chain.ball(segments).T)

    def linearise(
        self,
        parameters: np.ndarray,
        positions: np.ndarray,
    ) -> Linearisation:
        """Return the ball's centres and their derivatives; arguments as for :meth:`points`."""
        chain, segments = self._at(parameters, positions)
        ball = chain.ball_seen(segments)
        by_parameters, by_joints = (
            segments.by_rows(motions, motions.shifts(ball))
            for motions in (chain.by_frames, chain.layout.by_q)
        )
        return Linearisation(chain.ball(segments).T, by_parameters, by_joints)

    def rotations(
        self,
        parameters: np.ndarray,
        positions: np.ndarray,
    ) -> Linearisation:
        """Return rotations of the ball's link, shape (N, 3, 3), in place of the points.

        Derivatives are turns about the base's axes, shapes (N, 3, n) and (N, 3, m) [rad/rad].
        """
        chain, segments = self._at(parameters, positions)
        by_parameters, by_joints = (
            segments.by_rows(motions, motions.turns[:, :, None])
            for motions in (chain.by_frames, chain.layout.by_q)
        )
        return Linearisation(chain.rotation(segments), by_parameters, by_joints)

    def log_volume(
        self,
        parameters: np.ndarray,
        positions: np.ndarray,
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the mean logarithm of the volume that the ball sweeps, and its derivatives.

        A small box of joint positions becomes one of ball positions sqrt(det(Jq Jq^T)) times as
        large; with less than three joints there is none, and all are zero. Derivatives are by the
        free numbers, shape (n,), and by a turn of each joint in all positions, shape (m,).
        """
        if positions.shape[1] < 3:
            return 0.0, np.zeros(len(self.free)), 0 * positions[0]
        chain, segments = self._at(parameters, positions)
        return log_volume(chain, segments)

    def _at(
        self,
        parameters: np.ndarray,
        positions: np.ndarray,
    ) -> tuple[SegmentChain, Segments]:
        """Return the chain, and its segments at joint positions."""
        rows = np.ascontiguousarray(positions, dtype=float)
        numbers = parameters.astype(float)
        chain = self._chain(numbers.tobytes(), rows.shape[1])
        return chain, _segments_at(chain, rows.shape, rows.tobytes())

    def _chain_of(self, parameters: bytes, columns: int) -> SegmentChain:
        """Return the chain for values of the free numbers."""
        frames = self.frames(np.frombuffer(parameters))
        return self._layout(columns).chain(frames)


@lru_cache(maxsize=2)  # of all models: those of many samples are large
def _segments_at(
    chain: SegmentChain, shape: tuple[int, int], positions: bytes
) -> Segments:
    """Return the segments of a chain at joint positions as bytes."""
    q = np.frombuffer(positions).reshape(shape)
    return chain.at(q)

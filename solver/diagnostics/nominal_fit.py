"""A quick fit of the nominal model: its ball put right, and joint offsets, for many readings."""

from collections.abc import Sequence

import numpy as np

from ..identification.effects import JOINT_OFFSET
from ..identification.robot import BallModel, Robot, choose_parameters
from .hypotheses import BALL, SeatSamples, means, medians, robust_weights, typical

MAX_OFFSET = np.deg2rad(30)
"""Prior standard deviation of joint offsets in a search [rad]."""
ITERATIONS = 6
"""Iterations for the ball's place, and joint offsets."""
TURN = 1.0
"""Width of the prior of a frame's turn in a step [rad]."""


class NominalFit:
    """The nominal model of an arm; with ``zeros`` its joints have offsets, too."""

    def __init__(
        self,
        robot: Robot,
        *,
        zeros: bool,
    ) -> None:
        self._robot = robot
        self._zeros = zeros
        of_place = [
            p.index for p in choose_parameters(robot) if p.of_ball and p.unit == "m"
        ]
        self._place = BallModel(robot, of_place)

    def errors(self, variants: Sequence[SeatSamples]) -> list[float]:
        """Return the mean errors by the nominal model, its ball put right, of each reading [m]."""
        joints = np.arange(len(self._robot.actuated) if self._zeros else 0)
        of_variants = np.tile(joints, (len(variants), 1))
        _, errors = self._seeds(variants, of_variants, JOINT_OFFSET.typical_shift)
        return errors.tolist()

    def offsets(
        self, variants: Sequence[SeatSamples], joints: np.ndarray
    ) -> np.ndarray:
        """Return the best offsets of joints, shape (V, J), by the nominal model [rad]."""
        offsets, _ = self._seeds(variants, joints, MAX_OFFSET)
        return offsets[:, 3:]

    def _seeds(
        self,
        variants: Sequence[SeatSamples],
        joints: np.ndarray,
        width: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return errors of the ball's place, and joint offsets, (V, 3 + J); and errors left."""
        samples = variants[0]
        values = self._values(variants, joints)
        points = values[..., 0]
        N, V, _ = points.shape
        J, turns = joints.shape[1], 3 * len(samples.frames)
        widths = np.array([BALL] * 3 + [width] * J + [TURN] * turns)
        offsets = np.zeros((V, 3 + J))
        R = samples.aligned(points, np.ones((N, V)))
        places = points - samples.offsets(R)
        e = places - medians(places, samples)[samples.sockets]
        noise = typical(e)
        for _ in range(ITERATIONS):
            noise = typical(e)
            weights = robust_weights(e, noise)
            placed = values
            if samples.frames:  # the turns of frames are behind the other unknowns
                balls = points - np.einsum("nvij,vj->nvi", values[..., 1:], offsets)
                arms = samples.offsets(samples.aligned(balls, weights))
                places = (points - arms)[..., None]
                by_turns = samples.by_turns(arms)
                placed = np.concatenate([places, values[..., 1:], by_turns], axis=3)
            centred = placed - means(placed, samples, weights)[samples.sockets]
            by_variant = centred.swapaxes(0, 1).reshape(V, 3 * N, -1)
            off, slopes = by_variant[..., :1], by_variant[..., 1:]
            of_rows = np.repeat(weights.T, 3, axis=1)[:, :, None]
            A = (slopes * of_rows).swapaxes(1, 2)
            prior = np.eye(len(widths)) * (noise[:, None, None] / widths) ** 2
            steps = np.linalg.solve(A @ slopes + prior, A @ off)
            offsets = steps[:, : 3 + J, 0]
            remainder = off - slopes @ steps
            e = remainder.reshape(V, N, 3).swapaxes(0, 1)
        weights = robust_weights(e, noise)
        errors = np.linalg.norm(e, axis=2)
        return offsets, np.average(errors, axis=0, weights=weights)

    def _values(
        self, variants: Sequence[SeatSamples], joints: np.ndarray
    ) -> np.ndarray:
        """Return balls, and derivatives by their place and by joints, (N, V, 3, 1 + 3 + J)."""
        q = np.stack([variant.q for variant in variants], axis=1)
        N, V, m = q.shape
        linear = self._place.linearise(self._place.nominal, q.reshape(-1, m))
        points = linear.points.reshape(N, V, 3, 1)
        by_place = linear.by_parameters.reshape(N, V, 3, 3)
        by_all_joints = linear.by_joints.reshape(N, V, 3, m)
        by_joints = np.take_along_axis(by_all_joints, joints[None, :, None], axis=3)
        return np.concatenate([points, by_place, by_joints], axis=3)

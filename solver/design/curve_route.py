"""Poses for an arm whose joints have error curves, chosen by what the curves leave unknown.

A curve is known near the angles that were sampled, so that a pose teaches most where its joints
stand as they stood in no other. Curves have too many unknowns to be carried along, and samples are
few. So with K the covariance of what all poses of the pools would show, and of the distances d of
the workspace, by the geometry's prior and the Gaussian processes of the curves, samples s leave

    K_dd - K_ds (K_ss + I)^-1 K_sd
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..bayes.model import submatrix
from ..bayes.model.effects import CURVE, TYPICAL_LENGTH, kernel
from ..robot import workspace
from .information import ParameterCovariance
from .pose_route import Annealing

POOL, PAIRS = 150, 100
"""Poses of a pool, and distances, of which the covariance is."""


class CurveAnnealing(Annealing):
    """State of the annealing whose covariance is kept as the rows of K that are sampled.

    ``known`` is from before the first sample, in the sockets of all placements; ``taken`` are the
    samples so far, shape (N, m) [rad], and their socket; the others as for :func:`plan_poses`.
    """

    sweeps = 25
    slack = np.array([1.02, 1.04]) ** 2

    def __init__(
        self,
        state: ParameterCovariance,
        taken: Sequence[tuple[np.ndarray, int]],
        pools: Mapping[int, np.ndarray],
        order: Sequence[int],
        start: np.ndarray | None,
    ) -> None:
        pools = {k: pool[:POOL] for k, pool in pools.items()}
        sizes = [0, *np.cumsum([len(q) for q in pools.values()]).tolist()]
        triples = np.arange(3 * sizes[-1]).reshape(-1, 3)
        rows = {k: triples[a:b] for k, a, b in zip(pools, sizes, sizes[1:], strict=False)}
        joint, lengths = _joint_covariance(state, [*taken, *((q, k) for k, q in pools.items())])
        t = 3 * sum(len(q) for q, _ in taken)
        solved = np.linalg.solve(joint[:t, :t] + np.eye(t), joint[:t, t:])
        scale = lengths / np.linalg.norm(lengths)
        projection = np.vstack([scale, np.eye(PAIRS) - np.outer(scale, scale)]) / PAIRS**0.5
        remainder = joint[t:, t:] - joint[t:, :t] @ solved
        n = triples.size
        remainder = np.concatenate([remainder[:n], projection @ remainder[n:]])
        self.joint = np.concatenate([remainder[:, :n], remainder[:, n:] @ projection.T], axis=1)
        self.distances = np.arange(n, len(self.joint))
        super().__init__(self.distances[:0], rows, projection, pools, order, start)

    def updated(self, covariance: np.ndarray, rows: np.ndarray, sign: int = 1) -> np.ndarray:
        """Return which rows of K are sampled, after more or without some."""
        if sign > 0:
            return np.append(covariance, rows)
        return np.delete(covariance, np.flatnonzero(covariance == rows[0])[0] + np.arange(3))

    def seen(
        self, covariance: np.ndarray, rows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return as the base does, after the samples in some rows of K."""
        K = self.joint
        d = self.distances
        samples = covariance
        columns = rows.ravel()
        L = np.linalg.cholesky(submatrix(K, samples) + np.eye(len(samples)))
        half = np.linalg.inv(L) @ K[samples]
        by_distance = half[:, d]
        by_sample = half[:, columns].T
        cross = (K[columns][:, d] - by_sample @ by_distance).reshape(*rows.shape, len(d))
        by_sample = by_sample.reshape(*rows.shape, len(samples))
        S = (
            K[rows[:, :, None], rows[:, None]]
            - by_sample @ by_sample.transpose(0, 2, 1)
            + np.eye(3)
        )
        return cross, S, np.diag(K)[d] - np.sum(by_distance**2, axis=0)


def _joint_covariance(
    state: ParameterCovariance, some: Sequence[tuple[np.ndarray, int]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return K of samples in some sockets and of distances, their noise 1, and the distances."""
    model = state.model
    x = state.x
    n = len(state.covariance)
    unit = state.noise.information**0.5 / state.noise.space
    q = np.concatenate([p for p, _ in some])
    ends = workspace(model.robot, 2 * PAIRS)
    _, _, by_joints = model.linearise(x, q, np.tile(0 * q, 2))
    points, J, by_ends = model.linearise(x, ends, np.tile(0 * ends, 2))
    offsets = points[1::2] - points[::2]
    lengths = np.linalg.norm(offsets, axis=1)
    along = np.repeat(unit * offsets / lengths[:, None], 2, axis=0)
    along[::2] *= -1
    slopes = np.zeros((len(ends), n))
    slopes[:, : model.size] = np.einsum("ni,nij->nj", along, J)
    samples = np.concatenate([state.whitened(p, k) for p, k in some])
    A = np.concatenate([samples.reshape(-1, n), slopes])
    slopes_by_angle = (
        unit * by_joints.reshape(-1, q.shape[1]),
        np.einsum("ni,nij->nj", along, by_ends),
    )
    covariance = A @ state.covariance @ A.T
    angles = np.concatenate([np.repeat(q, 3, axis=0), ends])
    for angle, slope in zip(
        angles.T, CURVE.typical_shift * np.concatenate(slopes_by_angle).T, strict=True
    ):
        chord = 2 * np.sin((angle[:, None] - angle) / 2)
        covariance += np.outer(slope, slope) * kernel(chord, TYPICAL_LENGTH)[0]
    first = [*range(3 * len(q)), *range(3 * len(q), len(angles), 2)]  # a distance has two ends
    return np.add.reduceat(np.add.reduceat(covariance, first, axis=0), first, axis=1), lengths

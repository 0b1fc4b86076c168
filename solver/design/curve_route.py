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
from .information import ParameterCovariance, Prospect
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
        of_pools = [(pool, k) for k, pool in pools.items()]
        K, lengths = _joint_covariance(state, [*taken, *of_pools])
        t = 3 * sum(len(q) for q, _ in taken)
        after = K[t:, t:] - K[t:, :t] @ np.linalg.solve(
            K[:t, :t] + np.eye(t), K[:t, t:]
        )
        scale = lengths / np.linalg.norm(lengths)
        relative = np.eye(PAIRS) - np.outer(scale, scale)
        projection = np.vstack([scale, relative]) / PAIRS**0.5
        n = len(after) - PAIRS
        across = projection @ after[n:, :n]
        of_distances = projection @ after[n:, n:] @ projection.T
        self.joint = np.block([[after[:n, :n], across.T], [across, of_distances]])
        self.distances = np.arange(n, len(self.joint))
        rows: np.ndarray = np.arange(n).reshape(-1, 3)
        super().__init__(rows[:0].ravel(), rows, projection, pools, order, start)

    def updated(
        self, covariance: np.ndarray, rows: np.ndarray, sign: int = 1
    ) -> np.ndarray:
        """Return which rows of K are sampled, after more or without some."""
        if sign > 0:
            return np.append(covariance, rows)
        first = np.flatnonzero(covariance == rows[0])[0]
        return np.delete(covariance, first + np.arange(3))

    def seen(self, covariance: np.ndarray, rows: np.ndarray) -> Prospect:
        """Return as the base does, after the samples in some rows of K.

        With K_ss + 1 = L L^T and H = L^-1 K_s, the covariance of rows a and b is by then
        K_ab - H_a^T H_b.
        """
        K = self.joint
        d = self.distances
        L = np.linalg.cholesky(submatrix(K, covariance) + np.eye(len(covariance)))
        H = np.linalg.inv(L) @ K[covariance]
        Ha = H[:, rows].transpose(1, 2, 0)
        Hd = H[:, d]
        S = K[rows[:, :, None], rows[:, None]] - Ha @ Ha.transpose(0, 2, 1) + np.eye(3)
        variances = np.diag(K)[d] - np.sum(Hd**2, axis=0)
        return Prospect(K[rows][:, :, d] - Ha @ Hd, S, variances)


def _joint_covariance(
    state: ParameterCovariance, some: Sequence[tuple[np.ndarray, int]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return K of samples in some sockets and of distances, their noise 1, and the distances.

    With A the derivatives of all by the unknowns, and a_j those by the angle of joint j, it is
    A Sigma A^T + sum_j (a_j a_j^T) k(q_j, q_j'), k being the covariance of an error curve.
    """
    model = state.model
    unit = state.noise.information**0.5 / state.noise.space
    q = np.concatenate([p for p, _ in some])
    ends = workspace(model.robot, 2 * PAIRS)
    _, _, by_joints = model.linearise(state.x, q, np.tile(0 * q, 2))
    points, by_unknowns, ends_by_joints = model.linearise(
        state.x, ends, np.tile(0 * ends, 2)
    )
    offsets = points[1::2] - points[::2]
    lengths = np.linalg.norm(offsets, axis=1)
    along = np.repeat(unit * offsets / lengths[:, None], 2, axis=0)
    along[::2] *= -1
    ends_by_unknowns = np.zeros((len(ends), len(state.covariance)))
    ends_by_unknowns[:, : model.size] = np.einsum("ni,nij->nj", along, by_unknowns)
    of_samples = [np.concatenate(state.whitened(p, k)) for p, k in some]
    A = np.concatenate([*of_samples, ends_by_unknowns])
    covariance = A @ state.covariance @ A.T
    # by the curve of each joint, at its angles
    angles = np.concatenate([np.repeat(q, 3, axis=0), ends])
    along_joints = np.einsum("ni,nij->nj", along, ends_by_joints)
    slopes = np.concatenate([unit * np.concatenate(by_joints), along_joints])
    slopes *= CURVE.typical_shift
    for angle, slope in zip(angles.T, slopes.T, strict=True):
        chord = 2 * np.sin(np.subtract.outer(angle, angle) / 2)
        covariance += np.outer(slope, slope) * kernel(chord, TYPICAL_LENGTH)[0]
    n = 3 * len(q)
    first = [*range(n), *range(n, len(angles), 2)]  # a distance has two ends
    summed = np.add.reduceat(covariance, first, axis=0)
    return np.add.reduceat(summed, first, axis=1), lengths

"""Poses for an arm whose joints have error curves, chosen by what the curves leave unknown.

A curve is known near the angles that were sampled, so that a pose teaches most where its joints
stand as they stood in no other. Curves have too many unknowns to be carried along, and samples are
few. So with K the covariance of what all poses of the pools would show, and of the distances d of
the workspace, by the geometry's prior and the Gaussian processes of the curves, samples s leave

    K_dd - K_ds (K_ss + I)^-1 K_sd
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..identification.effects import CURVE, TYPICAL_LENGTH, kernel
from ..identification.model import submatrix
from ..identification.robot import workspace
from ..studies import pair_lengths, unit
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
        t = 3 * sum(len(q) for q, _ in taken)  # rows that were sampled
        across = K[:t, t:]
        gain = np.linalg.solve(K[:t, :t] + np.eye(t), across)
        after = K[t:, t:] - across.T @ gain
        scale = unit(lengths)
        relative = np.eye(PAIRS) - np.outer(scale, scale)
        projection = np.vstack([scale, relative]) / PAIRS**0.5
        n = len(after) - PAIRS
        across = projection @ after[n:, :n]
        of_distances = projection @ after[n:, n:] @ projection.T
        blocks = [[after[:n, :n], across.T], [across, of_distances]]
        self.joint = np.block(blocks)
        self.distances = np.arange(n, len(self.joint))
        rows = np.arange(n).reshape(-1, 3)
        super().__init__(
            rows[:0].ravel(),
            rows,
            projection,
            pools,
            order,
            start,
        )

    def updated(
        self,
        covariance: np.ndarray,
        rows: np.ndarray,
        sign: int = 1,
    ) -> np.ndarray:
        """Return which rows of K are sampled, after more or without some."""
        if sign > 0:
            return np.append(covariance, rows)
        first = np.flatnonzero(covariance == rows[0])[0]
        return np.delete(covariance, first + np.arange(3))

    def seen(
        self,
        covariance: np.ndarray,
        rows: np.ndarray,
    ) -> Prospect:
        """Return as the base does, after the samples in some rows of K.

        With K_ss + 1 = L L^T and H = L^-1 K_s, the covariance of rows a and b is by then
        K_ab - H_a^T H_b.
        """
        K = self.joint
        d = self.distances
        noise = np.eye(len(covariance))
        L = np.linalg.cholesky(submatrix(K, covariance) + noise)
        H = np.linalg.inv(L) @ K[covariance]
        H_a = H[:, rows].transpose(1, 2, 0)
        H_d = H[:, d]
        K_aa = K[rows[:, :, None], rows[:, None]]
        K_ad = K[rows][:, :, d]
        of_samples = K_aa - H_a @ H_a.swapaxes(1, 2)
        before = np.diag(K)[d]
        gains = np.sum(H_d**2, axis=0)
        return Prospect(
            cross=K_ad - H_a @ H_d,
            S=of_samples + np.eye(3),
            variances=before - gains,
        )


def _joint_covariance(
    state: ParameterCovariance,
    some: Sequence[tuple[np.ndarray, int]],
) -> tuple[np.ndarray, np.ndarray]:
    """Return K of samples in some sockets and of distances, their noise 1, and the distances.

    With A the derivatives of all by the unknowns, and a_j those by the angle of joint j, it is
    A Sigma A^T + sum_j (a_j a_j^T) k(q_j, q_j'), k being the covariance of an error curve.
    """
    weight = state.noise.information**0.5 / state.noise.space
    parts = [np.concatenate(state.whitened(q, k)) for q, k in some]
    # both ends of each random distance, by noise of 1, and how they change it
    ends = workspace(state.model.robot, 2 * PAIRS)
    points, J, by_joints_of_ends = state.linearise(ends)
    along = np.repeat(weight * unit(points[1::2] - points[::2]), 2, axis=0)
    along[::2] *= -1
    by_unknowns = np.zeros((len(ends), len(state.covariance)))
    by_unknowns[:, : state.model.size] = np.einsum("ni,nij->nj", along, J)
    A = np.concatenate([*parts, by_unknowns])
    covariance = A @ state.covariance @ A.T
    # by the curve of each joint, at its angles
    q = np.concatenate([p for p, _ in some])
    _, _, by_joints = state.linearise(q)
    of_ends = np.einsum("ni,nij->nj", along, by_joints_of_ends)
    slopes = np.concatenate([weight * np.concatenate(by_joints), of_ends])
    slopes *= CURVE.typical_shift
    of_numbers = np.repeat(q, 3, axis=0)
    angles = np.concatenate([of_numbers, ends])
    for angle, slope in zip(angles.T, slopes.T, strict=True):
        chord = 2 * np.sin(np.subtract.outer(angle, angle) / 2)
        by_curve, _ = kernel(chord, TYPICAL_LENGTH)
        covariance += np.outer(slope, slope) * by_curve
    n = len(of_numbers)
    first = [*range(n), *range(n, len(angles), 2)]  # a distance has two ends
    summed = np.add.reduceat(covariance, first, axis=0)
    summed = np.add.reduceat(summed, first, axis=1)
    return summed, pair_lengths(points)

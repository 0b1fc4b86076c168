"""Orders of joint positions whose columns no name tells: which one fits poses that were measured.

The flange's rotations R_i and the measured ones M_i are conjugate but for two constant turns, so
turns between views have one angle in both:

    angle(R_i^T R_j) = angle(M_i^T M_j)

whatever the camera's pose is. Orders that keep it are few: parallel axes may change places. Of
these, the right one fits the measured places, too.
"""

from itertools import permutations
from typing import NamedTuple

import numpy as np

from ...errors import MukcaError
from ..data import hand_eye
from ..robot import rotation_vectors
from .prior import ArmPrior
from .task import flanges

MOST_JOINTS = 6
"""Joints whose orders are all tried."""
FITS, CANDIDATES = 0.02, 24
"""Typical difference of angles up to which an order fits [rad], and how many orders may."""
NEAR = 5e-3
"""Typical distance up to which measured places fit [m]."""
FAR_BETTER = 0.25
"""Share of the next best order's distance that the right one leaves at most."""


class Order(NamedTuple):
    """An order of columns that fits, where that in which they stand does not."""

    names: tuple[str, ...]
    """Joint names, column by column."""
    distance: float
    """Typical distance that it leaves [m]."""

    @property
    def words(self) -> str:
        """What it is, and what to do."""
        return (
            f"the poses fit if the columns are {','.join(self.names)} ({1e3 * self.distance:.1f} "
            "mm are left): write these names above them"
        )


def fitting_order(prior: ArmPrior, q: np.ndarray, M: np.ndarray) -> Order | None:
    """Return the one order of columns that fits measured poses; None where none does.

    Args:
        prior: The arm.
        q: Joint positions, their columns as they stand, shape (N, m) [rad].
        M: Poses as :func:`.hand_eye` takes them, shape (N, 4, 4) [m].
    """
    joints = prior.robot.joint_names
    N, m = q.shape
    if m > MOST_JOINTS:
        return None
    orders = np.array(list(permutations(range(m))))
    rows = q[:, orders].swapaxes(0, 1).reshape(-1, m)
    poses = flanges(prior, prior.mean, rows, np.zeros((len(rows), 3 * m)))
    R, p = poses.R.reshape(-1, N, 3, 3), poses.p.reshape(-1, N, 3)
    differences = np.median(np.abs(_angles(R) - _angles(M[None, :, :3, :3])), axis=1)
    ranks = np.argsort(differences)[:CANDIDATES]
    distances: dict[int, float] = {}
    for k in ranks[differences[ranks] < FITS].tolist():
        try:
            start = hand_eye(R[k], p[k], M[:, :3, :3], M[:, :3, 3])
        except MukcaError:
            continue
        distances[k] = float(np.median(start.distances))
    best, *others = sorted(distances, key=distances.__getitem__) or [0]
    if not best or distances[best] > NEAR:
        return None
    if others and distances[best] > FAR_BETTER * distances[others[0]]:
        return None
    column_of: list[int] = np.argsort(orders[best]).tolist()
    return Order(tuple(joints[j] for j in column_of), distances[best])


def _angles(R: np.ndarray) -> np.ndarray:
    """Return angles of the turns from each row to the next, shape (K, N - 1), of (K, N, 3, 3)."""
    steps = R[:, :-1].swapaxes(2, 3) @ R[:, 1:]
    vectors = rotation_vectors(steps.reshape(-1, 3, 3))
    return np.linalg.norm(vectors, axis=1).reshape(len(R), -1)

"""Readings of a file of poses, where the poses do not fit as its columns say.

Programs write turns in many ways that look alike. Each reading is an explanation of the file, and
its evidence is that of the angles a_i and places t_i which the poses leave, their scales unknown:

    ln L = -3/2 N (ln median(a^2) + ln median(t^2))

Columns of joints that no name tells may stand in another order. The flange's rotations R_i and the
measured ones M_i are conjugate but for two constant turns, so turns between views have one angle in
both, whatever the camera's pose is:

    angle(R_i^T R_j) = angle(M_i^T M_j)

Orders that keep it are few: parallel axes may change places. Of these, the right one fits the
measured places, too.
"""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ...errors import MukcaError
from ...recorder import Sample
from ..identification.data import FrameError, Samples, hand_eye
from ..identification.robot import matrix_rpy, rotation_matrices, rotation_vectors, turn
from .prior import ArmPrior, Flanges

AS_IS = "as they stand"
SURE = math.log(1000)
"""Log Bayes factor from which another reading is named."""
LEAST_ANGLE, LEAST_PLACE = 1e-4, 1e-4
"""Angles [rad] and places [m] that no camera tells apart."""
NEARER = 0.25
"""Share of angles or places that the right reading leaves at most: of mirrored places none does."""
FITS = 0.1
"""Angle up to which a reading fits [rad]."""
MOST_JOINTS = 6
"""Joints whose orders are all tried."""
ANGLES_FIT, CANDIDATES = 0.02, 24
"""Typical difference of angles up to which an order fits [rad], and how many orders may."""
NEAR = 5e-3
"""Typical distance up to which measured places fit [m]."""
FAR_BETTER = 0.25
"""Share of the next best order's distance that the right one leaves at most."""


def turns_of(samples: Sequence[Sample]) -> dict[str, np.ndarray]:
    """Return the rotations of samples by each reading of their numbers, shape (N, 3, 3)."""
    quaternions = np.array([s.orientation for s in samples], dtype=float)
    turns = {AS_IS: rotation_matrices(quaternions)}
    numbers = [s.turn for s in samples]
    if any(len(row) != 3 for row in numbers):
        turns["quaternions with w first"] = rotation_matrices(
            quaternions[:, [1, 2, 3, 0]]
        )
        return turns
    for unit, factor in (("", 1.0), (" in degrees", math.pi / 180)):
        angles = factor * np.array(numbers)
        turns[f"rotation vectors{unit}"] = turn(angles)
        turns[f"roll, pitch, yaw{unit} (Rz Ry Rx)"] = matrix_rpy(angles)
        turns[f"Euler angles{unit} about z, y, x (Rz Ry Rx)"] = _product(angles, "zyx")
        turns[f"Euler angles{unit} about x, y, z (Rx Ry Rz)"] = _product(angles, "xyz")
        turns[f"Euler angles{unit} about z, y, z (Rz Ry Rz)"] = _product(angles, "zyz")
    return turns


def _product(angles: np.ndarray, axes: str) -> np.ndarray:
    """Return products of turns about axes, angle by angle, shape (N, 3, 3)."""
    units = dict(zip("xyz", np.eye(3), strict=True))
    product = np.eye(3)
    for column, axis in zip(angles.T, axes, strict=True):
        product = product @ turn(np.outer(column, units[axis]))
    return product


def poses_of(samples: Sequence[Sample]) -> dict[str, np.ndarray]:
    """Return the poses of samples by each reading, shape (N, 4, 4)."""
    points = np.array([s.point for s in samples], dtype=float)
    poses: dict[str, np.ndarray] = {}
    for name, R in turns_of(samples).items():
        prefix = "" if name == AS_IS else f"{name}, "
        as_named = as_poses(R, points)
        transposed = as_poses(R.swapaxes(1, 2), points)
        poses[name] = as_named
        poses[f"{prefix}turns transposed or inverse, places not"] = transposed
        poses[f"{prefix}inverse poses"] = np.linalg.inv(as_named)
    return poses


def as_poses(R: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return rotations, shape (N, 3, 3), and places, (N, 3) [m], as matrices (N, 4, 4)."""
    poses = np.tile(np.eye(4), (len(R), 1, 1))
    poses[:, :3, :3] = R
    poses[:, :3, 3] = points
    return poses


class Fit(NamedTuple):
    """Residual of poses by the best camera, and the logarithm of their evidence."""

    angle: float
    """Typical angle [rad]."""
    place: float
    """Typical distance [m]."""
    evidence: float

    def __str__(self) -> str:
        return f"{self.angle:.2g} rad and {1e3 * self.place:.1f} mm"


def fitting_reading(
    samples: Sequence[Sample],
    flange_poses: Flanges,
    side: Callable[[np.ndarray], np.ndarray],
) -> str:
    """Return in words how poses are to be read; empty where no reading fits far better.

    Whole poses that are inverse are another camera's, too: of them the caller speaks.
    """
    fits: dict[str, Fit] = {}
    for name, T in poses_of(samples).items():
        try:
            start = flange_poses.hand_eye(side(T))
        except FrameError:
            return ""
        angle = max(start.angle, LEAST_ANGLE)
        place = max(start.distance, LEAST_PLACE)
        evidence = -3 * len(T) * math.log(angle * place)
        fits[name] = Fit(angle, place, evidence)
    as_is = fits[AS_IS]
    name, best = max(fits.items(), key=lambda item: item[1].evidence)
    gain = best.evidence - as_is.evidence
    if name in (AS_IS, "inverse poses") or gain < SURE or best.angle > FITS:
        return ""
    if best.angle > NEARER * as_is.angle and best.place > NEARER * as_is.place:
        return ""
    return (
        f"as its columns say, the poses leave {as_is}; read as {name}, {best} "
        f"(log Bayes factor {gain:.0f}): write them as x,y,z and qx,qy,qz,qw of the board in the "
        "camera, or name the columns by what they hold"
    )


def fitting_order(prior: ArmPrior, q: np.ndarray, M: np.ndarray) -> str:
    """Return in words the one order of columns that fits measured poses; empty where none does.

    Args:
        prior: The arm.
        q: Joint positions, their columns as they stand, shape (N, m) [rad].
        M: Poses as :func:`.hand_eye` takes them, shape (N, 4, 4) [m].
    """
    joints = prior.robot.joint_names
    N, m = q.shape
    if m > MOST_JOINTS:
        return ""
    orders = np.array(list(permutations(range(m))))  # that in which they stand first
    rows = q[:, orders].swapaxes(0, 1).reshape(-1, m)
    poses = prior.flanges(prior.mean, Samples.unloaded(rows))
    R = poses.R.reshape(-1, N, 3, 3)
    p = poses.p.reshape(-1, N, 3)
    measured, points = M[:, :3, :3], M[:, :3, 3]
    misfits = np.abs(_angles(R) - _angles(measured[None]))
    differences = np.median(misfits, axis=1)
    ranks = np.argsort(differences)[:CANDIDATES]
    distances: list[tuple[float, int]] = []
    for k in ranks[differences[ranks] < ANGLES_FIT].tolist():
        with suppress(MukcaError):
            start = hand_eye(R[k], p[k], measured, points)
            distances.append((start.distance, k))
    nothing = (np.inf, 0)
    ranked = [*sorted(distances), nothing, nothing]
    (distance, best), (next_distance, _), *_ = ranked
    if best == 0 or distance > NEAR or distance > FAR_BETTER * next_distance:
        return ""
    column_of: list[int] = np.argsort(orders[best]).tolist()
    columns = ",".join(joints[j] for j in column_of)
    return (
        f"the poses fit if the columns are {columns} ({1e3 * distance:.1f} mm are left): write "
        "these names above them"
    )


def _angles(R: np.ndarray) -> np.ndarray:
    """Return angles of the turns from each row to the next, shape (K, N - 1), of (K, N, 3, 3)."""
    steps = R[:, :-1].swapaxes(2, 3) @ R[:, 1:]
    vectors = rotation_vectors(steps.reshape(-1, 3, 3))
    return np.linalg.norm(vectors, axis=1).reshape(len(R), -1)

"""Poses that an instrument measured: where its frame stands, and what the flange carries.

A link of the robot has the poses (R_i, p_i) in the base, and what is fixed to it was measured at
(M_i, t_i) in the instrument's frame. With F the pose of that frame in the base and X what is fixed,

    F (M_i, t_i) = (R_i, p_i) X

The rotations follow from the largest singular value of sum M_i (x) R_i (Shah 2013), the places
from linear least squares, both with weights that fall with the error that is left.
"""

from dataclasses import dataclass

import numpy as np

from .frames import REWEIGHTINGS, FrameError, Pose

ALONG_ONE_AXIS = 1e-3
"""Share of the turns about other axes below which the poses turn about one axis only."""
STRANGE = 0.1
"""Typical angle that no arm errs by [rad]: columns are wrong."""
BETTER = 0.25
"""Share of the angle that is left if other columns are meant."""
_MEANT = {
    "qw first (they stand in the order qw, qx, qy, qz)": ((3, 0, 1, 2), (1, 1, 1, 1)),
    "the inverse (poses of the instrument, as a camera's, or qw with the other sign)": (
        (0, 1, 2, 3),
        (-1, -1, -1, 1),
    ),
    "qx and qy swapped": ((1, 0, 2, 3), (1, 1, 1, 1)),
    "qx and qz swapped": ((2, 1, 0, 3), (1, 1, 1, 1)),
    "qy and qz swapped": ((0, 2, 1, 3), (1, 1, 1, 1)),
    "qx and qw swapped": ((3, 1, 2, 0), (1, 1, 1, 1)),
    "qy and qw swapped": ((0, 3, 2, 1), (1, 1, 1, 1)),
    "qz and qw swapped": ((0, 1, 3, 2), (1, 1, 1, 1)),
    "qx with the other sign": ((0, 1, 2, 3), (-1, 1, 1, 1)),
    "qy with the other sign": ((0, 1, 2, 3), (1, -1, 1, 1)),
    "qz with the other sign": ((0, 1, 2, 3), (1, 1, -1, 1)),
}
"""Mistakes in the columns of quaternions: the order and the signs that were meant."""


def rotation_matrices(quaternions: np.ndarray) -> np.ndarray:
    """Return the rotations of unit quaternions x, y, z, w, shape (..., 4), as (..., 3, 3)."""
    x, y, z, w = np.moveaxis(quaternions, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """Return the axes of rotations, shape (N, 3, 3), times their angles, shape (N, 3) [rad]."""
    axis = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1)
    sine = np.linalg.norm(axis, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(R, axis1=1, axis2=2) - 1) / 2)
    return axis / 2 * np.where(sine > 1e-9, angle / sine.clip(1e-9), 1.0)[:, None]


@dataclass(frozen=True)
class HandEye:
    """The two unknown poses, and how well they fit."""

    tool: Pose
    """X, what was measured in the link's frame."""
    frame: Pose
    """F, the instrument's frame in the base."""
    angles: np.ndarray
    """Angle that is left of each pose, shape (N,) [rad]."""
    distances: np.ndarray
    """Distance that is left, shape (N,) [m]."""


def hand_eye(
    R: np.ndarray, p: np.ndarray, M: np.ndarray, t: np.ndarray, where: str = "poses"
) -> HandEye:
    """Return where an instrument's frame stands and what the link carries, without any start.

    Args:
        R: The link's rotations in the base, shape (N, 3, 3).
        p: Its places, shape (N, 3) [m].
        M: The measured rotations, shape (N, 3, 3).
        t: The measured places, shape (N, 3) [m].
        where: The file, for messages.

    Raises:
        FrameError: The link turns about one axis only.
    """
    spread = np.linalg.svd(np.cov(R.reshape(len(R), 9).T), compute_uv=False)
    if spread[3] < ALONG_ONE_AXIS * spread[0]:
        raise FrameError(
            f"{where}: the link turns about one axis only, which leaves open what it carries; turn "
            "it about two axes at least"
        )
    K = np.einsum("nbc,nad->abdc", M, R).reshape(9, 9)
    tool = _nearest(np.linalg.svd(K)[2][0].reshape(3, 3))
    frame, weights, angles = tool, np.ones(len(R)), np.zeros(len(R))
    for _ in range(REWEIGHTINGS):
        frame = _nearest(np.einsum("n,nij->ij", weights, R @ tool @ M.swapaxes(1, 2)))
        tool = _nearest(np.einsum("n,nij->ij", weights, R.swapaxes(1, 2) @ frame @ M))
        left = rotation_vectors(R @ tool @ (frame @ M).swapaxes(1, 2))
        angles, weights = _weighed(left)
    rows = np.concatenate([R, np.broadcast_to(-np.eye(3), R.shape)], axis=2)
    known = t @ frame.T - p
    distances, weights = np.zeros(len(R)), np.ones(len(R))
    both = np.zeros(6)
    for _ in range(REWEIGHTINGS):
        root = np.sqrt(weights)[:, None]
        flat = (rows * root[..., None]).reshape(-1, 6)
        both = np.linalg.lstsq(flat, (known * root).ravel(), rcond=1e-6)[0]
        distances, weights = _weighed(rows @ both - known)
    return HandEye(Pose(tool, both[:3]), Pose(frame, both[3:]), angles, distances)


def _weighed(errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the sizes of errors, shape (N, 3), and weights that fall with them."""
    sizes = np.linalg.norm(errors, axis=1)
    return sizes, 1 / (1 + sizes**2 / (5 * max(float(np.median(sizes**2)), 1e-24)))


def check_orientations(R: np.ndarray, quaternions: np.ndarray, where: str) -> None:
    """See that measured orientations turn as the link does.

    Args:
        R: The link's rotations in the base, shape (N, 3, 3).
        quaternions: The measured orientations x, y, z, w, shape (N, 4).
        where: The file, for messages.

    Raises:
        FrameError: They do not; it names the columns that are wrong, where others fit.
    """
    none = np.zeros((len(R), 3))

    def left(order: tuple[int, ...], signs: tuple[int, ...]) -> float:
        M = rotation_matrices(quaternions[:, order] * signs)
        return float(np.median(hand_eye(R, none, M, none, where).angles))

    as_is = left((0, 1, 2, 3), (1, 1, 1, 1))
    if as_is < STRANGE:
        return
    others = {words: left(*meant) for words, meant in _MEANT.items()}
    best = 2 * min(others.values()) + 1e-3
    fit = " or ".join(words for words, angle in others.items() if angle < min(best, BETTER * as_is))
    words = f"they fit with {fit}"
    if not fit:
        words = "see the order of the joints, their unit (radians) and the robot's model"
    raise FrameError(
        f"{where}: the orientations are {as_is:.2g} rad off those of the robot's flange; {words}"
    )


def _nearest(matrix: np.ndarray) -> np.ndarray:
    """Return the rotation nearest to a matrix or to its opposite, shape (3, 3)."""
    U, _, Vt = np.linalg.svd(matrix * np.sign(np.linalg.det(matrix)))
    return U @ Vt

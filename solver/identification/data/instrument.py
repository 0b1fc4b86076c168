"""Where what a link carries, and an instrument's frame, stand, by poses that it measured."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..robot import rotation_matrices, rotation_vectors
from .frames import REWEIGHTINGS, FrameError, Pose, nearest_rotation, robust_weights

ALONG_ONE_AXIS = 1e-3
"""Share of the turns about other axes below which the poses turn about one axis only."""
DOUBTFUL, STRANGE = 5e-3, 0.1
"""Typical angles [rad]: beyond the first other columns are tried, and no arm errs by the second."""
BETTER = 0.25
"""Share of the angle that is left if they turn the other way, or with other columns of joints."""


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

    @property
    def angle(self) -> float:
        """The typical angle that is left [rad]."""
        return float(np.median(self.angles))

    @property
    def distance(self) -> float:
        """The typical distance that is left [m]."""
        return float(np.median(self.distances))


def hand_eye(
    R: np.ndarray, p: np.ndarray, M: np.ndarray, t: np.ndarray, where: str = "poses"
) -> HandEye:
    """Return where an instrument's frame stands and what the link carries, without any start.

    The link has the poses (R_i, p_i) in the base, and what is fixed to it was measured at (M_i,
    t_i) in the instrument's frame, of shapes (N, 3, 3) and (N, 3) [m]; messages begin with
    ``where``. With F the pose of that frame in the base and X what is fixed,

        F (M_i, t_i) = (R_i, p_i) X

    The rotations follow from the largest singular value of sum M_i (x) R_i (Shah 2013), the places
    from linear least squares, both with weights that fall with the error that is left.
    """
    covariance = np.cov(R.reshape(len(R), 9).T, bias=True)  # 0 of a single pose
    spread = np.linalg.svd(covariance, compute_uv=False)
    if spread[3] <= ALONG_ONE_AXIS * spread[0]:
        raise FrameError(
            f"{where}: the link turns about one axis only, which leaves open what it carries; turn "
            "it about two axes at least"
        )
    tool, frame, angles = _turns(R, M)
    minus_axes = np.broadcast_to(-np.eye(3), R.shape)
    rows = np.concatenate([R, minus_axes], axis=2)
    offset = t @ frame.T - p
    distances = np.zeros(len(R))
    places = np.zeros(6)
    for _ in range(REWEIGHTINGS):
        root = np.sqrt(robust_weights(distances**2))[:, None]
        flat = (rows * root[..., None]).reshape(-1, 6)
        targets = (offset * root).ravel()
        places = np.linalg.lstsq(flat, targets, rcond=1e-6)[0]
        distances = np.linalg.norm(rows @ places - offset, axis=1)
    return HandEye(Pose(tool, places[:3]), Pose(frame, places[3:]), angles, distances)


def _turns(R: np.ndarray, M: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rotations of the tool and of the frame, and the angles that they leave."""
    K = np.einsum("nbc,nad->abdc", M, R).reshape(9, 9)
    _, _, Vt = np.linalg.svd(K)
    tool = _nearest(Vt[0].reshape(3, 3))
    frame = tool
    angles = np.zeros(len(R))
    for _ in range(REWEIGHTINGS):
        weights = robust_weights(angles**2)
        frames = R @ tool @ M.swapaxes(1, 2)
        frame = _nearest(np.einsum("n,nij->ij", weights, frames))
        tools = R.swapaxes(1, 2) @ frame @ M
        tool = _nearest(np.einsum("n,nij->ij", weights, tools))
        errors = R @ tool @ (frame @ M).swapaxes(1, 2)
        angles = np.linalg.norm(rotation_vectors(errors), axis=1)
    return tool, frame, angles


def other_columns(
    names: Sequence[str], q: np.ndarray
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield mistakes in columns of joint positions, shape (N, m), in words, and those mended."""
    for j, name in enumerate(names):
        mended = q.copy()
        mended[:, j] *= -1
        yield f"joint {j + 1} ({name}) looks sign-flipped: turned, they fit", mended
    for pair in combinations(range(len(names)), 2):
        mended = q.copy()
        mended[:, pair] = q[:, pair[::-1]]
        joints = " and ".join(f"{j + 1} ({names[j]})" for j in pair)
        yield (
            f"the columns of joints {joints} look swapped: they fit the other way round",
            mended,
        )


def check_orientations(
    R: np.ndarray,
    quaternions: np.ndarray,
    where: str,
    mended: Iterable[tuple[str, np.ndarray]] = (),
) -> None:
    """See that measured orientations turn as the link does, by its rotations, shape (N, 3, 3).

    Columns swapped, in another order, with a wrong sign, or inverse: all of these quaternions x, y,
    z, w, shape (N, 4), turn the other way, so they are told from right ones, and not from each
    other. ``mended`` has mistakes in words, and the link's rotations without each.
    """
    M = rotation_matrices(quaternions)
    as_is = _angle(R, M)
    if as_is < DOUBTFUL:
        return
    if _angle(R, M.swapaxes(1, 2)) < BETTER * as_is:
        words = (
            "they turn the other way: two of the columns qx,qy,qz,qw are swapped, they stand in "
            "another order (qw first?), one has the wrong sign, or the poses are inverse, as a "
            "camera's are"
        )
    elif as_is > STRANGE:
        angles = {mistake: _angle(rotations, M) for mistake, rotations in mended}
        likely = [
            mistake for mistake, angle in angles.items() if angle < BETTER * as_is
        ]
        words = " or ".join(likely) or (
            "see the order of the joints, their zeros, their unit (radians) and the robot's model"
        )
    else:
        return
    raise FrameError(
        f"{where}: orientations are {as_is:.2g} rad off those of the robot's flange; {words}"
    )


def _angle(R: np.ndarray, M: np.ndarray) -> float:
    """Return the typical angle that the best frame and tool leave [rad]."""
    return float(np.median(_turns(R, M)[2]))


def _nearest(matrix: np.ndarray) -> np.ndarray:
    """Return the rotation nearest to a matrix or to its opposite, shape (3, 3)."""
    return nearest_rotation(matrix * np.sign(np.linalg.det(matrix)))

"""Plain chessboards that look alike after a turn: which turn each view has, by consistency.

A board of an even sum of columns and rows looks alike after half a turn, a square one after a
quarter, so a detector may find it turned otherwise in each view. With flanges F and boards B of two
views i and j, a camera on the arm or beside it sees

    angle(F_i^T F_j) = angle(B_i^T B_j Z_(j-i))

Z being the turn about the board's normal between what was found in both. The surest pairs of views
are joined first.
"""

from dataclasses import replace

import numpy as np

from ...recorder import Placement, Sample
from ...solver.calibration import Calibration, quaternion_of
from ...solver.identification.robot import rotation_matrices
from .boards import PLAIN, Board
from .postures import flange_poses, names_flange_poses
from .spanning_tree import spanning_tree

QUARTER = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
"""A quarter of a turn about the normal."""


def turned_alike(
    calibration: Calibration,
    views: Placement,
    board: Board,
) -> Placement:
    """Return views in which a plain chessboard is turned as in the first one.

    Args:
        calibration: The calibrated arm.
        views: Joint positions or flange poses, and the board's poses in the camera.
        board: The board that the views show.
    """
    turns = _alike(board)
    if board.dictionary != PLAIN or len(turns) == 1:
        return views
    B = rotation_matrices(np.array([sample.orientation for sample in views.samples]))
    Z = np.array([np.linalg.matrix_power(QUARTER, k) for k in turns])
    numbers = _turns_of_views(_flanges(calibration, views), B, Z)
    if not numbers.any():
        return views
    Z_of_view = Z[numbers]
    centre = board.square * np.array([board.columns, board.rows, 0.0]) / 2
    places = np.array([sample.point for sample in views.samples])
    places += np.einsum("nij,nj->ni", B, centre - Z_of_view @ centre)
    quaternions = quaternion_of(B @ Z_of_view)
    rows = zip(views.samples, places.tolist(), quaternions.tolist(), strict=True)
    samples: list[Sample] = []
    for sample, p, quaternion in rows:
        pose = {"point": tuple(p), "orientation": tuple(quaternion)}
        samples.append(replace(sample, **pose, turn=()))
    where = views.files[0].parent if views.files else views.name
    remark = (
        f"{where}: the board looks alike after a turn of {360 // len(turns)} deg; it was found "
        f"turned in {np.count_nonzero(numbers)} of {len(samples)} views, which were turned back"
    )
    return replace(views, samples=tuple(samples), remarks=(*views.remarks, remark))


def _alike(board: Board) -> list[int]:
    """Return the quarters of a turn after which a plain chessboard may look alike."""
    if board.columns == board.rows:
        return [0, 1, 2, 3]
    odd = (board.columns + board.rows) % 2
    return [0] if odd else [0, 2]


def _flanges(
    calibration: Calibration,
    views: Placement,
) -> np.ndarray:
    """Return the rotations of the flange, shape (N, 3, 3)."""
    if names_flange_poses(views):
        poses = flange_poses(views)
    else:
        poses = calibration.flange(
            views.for_joints(calibration.robot.joint_names).positions
        )
    return poses[:, :3, :3]


def _turns_of_views(
    F: np.ndarray,
    B: np.ndarray,
    Z: np.ndarray,
) -> np.ndarray:
    """Return the number of the turn that puts each board as in the first view, shape (N,)."""
    N = len(F)
    traces_of_flange = np.einsum("iba,jba->ij", F, F)
    traces_by_turn = np.einsum("ijac,kca->kij", np.einsum("iba,jbc->ijac", B, B), Z)
    errors = np.abs(_angles(traces_by_turn) - _angles(traces_of_flange))
    best = errors.argmin(axis=0)
    least, second = np.sort(errors, axis=0)[:2]
    numbers = np.zeros(N, dtype=int)
    for j, i in spanning_tree(least - second, 0, np.arange(N)):
        turn = numbers[i] + best[i, j]
        numbers[j] = turn % len(Z)
    return numbers


def _angles(traces: np.ndarray) -> np.ndarray:
    """Return the angles of rotations of such traces [rad]."""
    return np.arccos(np.clip((traces - 1) / 2, -1.0, 1.0))

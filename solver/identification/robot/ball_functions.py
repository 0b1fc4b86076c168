"""The ball's position, its link's rotation and the swept volume as functions of joints' frames."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca

from .chain import Joint
from .kinematics import NUMBERS, Motion, ball_position, frames_and_motions, joint_frames
from .row_function import RowFunction


@lru_cache(maxsize=256)
def ball_function(
    joints: tuple[Joint, ...],
    free: tuple[int, ...],
    kind: str,
    columns: int,
) -> RowFunction:
    """Return a function of the joints' frames and rows q, which arms of like joints share.

    To build one takes longer than most of its calls.
    """
    numbers = ca.SX.sym("frames", NUMBERS * len(joints))
    q = ca.SX.sym("q", columns)
    frames = joint_frames(numbers)
    if kind == "points":
        p = ball_position(joints, frames, q)
        return RowFunction(kind, [numbers, q], [ca.densify(p)])
    links, of_frames, of_q = frames_and_motions(joints, frames, q)
    R, p = links[-1]
    of_parameters = [of_frames[i] for i in free]
    motions = [*of_parameters, *of_q]
    if kind == "rotations":
        value = R
        turns = [motion.turn for motion in motions]
        slopes = ca.horzcat(*turns)
    elif kind == "volume":
        value, slopes = _log_volume(of_parameters, of_q, p)
    else:
        value = ca.densify(p)
        shifts = [motion.shift(p) for motion in motions]
        slopes = ca.horzcat(*shifts)
    by_parameters, by_q = ca.horzsplit(slopes, [0, len(free), len(motions)])
    return RowFunction(kind, [numbers, q], [value, by_parameters, by_q])


def _log_volume(
    of_frames: list[Motion],
    of_q: list[Motion],
    p: Any,
) -> tuple[Any, Any]:
    """Return ln sqrt(det(J J^T)) of the ball at p, with J by q, and its slopes by all motions.

    They are the sums of g_i . dJ_i, with g_i = (J J^T)^-1 J_i. A motion with the turn a that shifts
    the ball by s turns the joints beyond it, dJ_i = a x J_i; for the others, dJ_i = a_i x s.
    """
    chain = sorted(of_q, key=lambda motion: motion.joint)
    shifts = [motion.shift(p) for motion in chain]
    J = ca.horzcat(*shifts)
    turns = ca.horzcat(*(motion.turn for motion in chain))
    JJ = J @ J.T
    g = ca.inv(JJ) @ J
    by_turn = ca.cross(J, g)
    by_shift = ca.cross(g, turns)
    slopes: list[Any] = []
    for motion in (*of_frames, *of_q):
        n = _joints_before(motion, chain)
        beyond = ca.sum2(by_turn[:, n:])
        before = ca.sum2(by_shift[:, :n])
        slope = motion.turn.T @ beyond + motion.shift(p).T @ before
        slopes.append(slope)
    value = 0.5 * ca.log(ca.det(JJ))
    return value, ca.horzcat(*slopes)


def _joints_before(motion: Motion, chain: Sequence[Motion]) -> int:
    """Return how many motions of a chain a motion does not turn: those before it, and itself."""
    for i, link in enumerate(chain, start=1):
        if link is motion:
            return i
    return sum(link.joint < motion.joint for link in chain)

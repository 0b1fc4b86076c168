"""The volume that the ball sweeps, and its slopes."""

import numpy as np

from .segments import SegmentChain, Segments, cross


def log_volume(
    chain: SegmentChain,
    segments: Segments,
) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the mean of ln sqrt(det(J J^T)) of the ball, with J by q, and its slopes.

    They are by the free numbers of the joints' frames, and by a turn of each joint in all rows.

    Of each configuration they are the sums of g_i . dJ_i, with g_i = (J J^T)^-1 J_i. A motion with
    the turn a that shifts the ball by s turns the joints beyond it, dJ_i = a x J_i; for the others,
    and for itself, dJ_i = a_i x s.
    """
    ball = chain.ball_seen(segments)
    of_q = chain.layout.motions
    J = segments.by_rows(of_q, of_q.shifts(ball)).transpose(2, 1, 0)
    turns = np.einsum("mijn,mj->min", segments.R[of_q.segments], of_q.turns)
    JJ = np.einsum("min,mjn->ijn", J, J)
    cofactors = cross(JJ[[1, 2, 0]], JJ[[2, 0, 1]])
    det = np.sum(JJ[0] * cofactors[0], axis=0)
    g = np.einsum("ijn,mjn->min", cofactors / det, J)
    zero = np.zeros_like(J[:1])
    beyond = np.concatenate([cross(J, g), zero])[::-1].cumsum(axis=0)[::-1]
    before = np.concatenate([zero, cross(g, turns)]).cumsum(axis=0)
    # in a segment's frame its motions are the same in all configurations, so means are enough
    forces = segments.turned_back(before)
    moments = segments.turned_back(beyond) + cross(ball, forces)
    mean_force = forces.mean(axis=2, keepdims=True)
    mean_moment = moments.mean(axis=2, keepdims=True)
    by_frames = chain.by_frames.work(mean_force, mean_moment)
    by_q = chain.layout.by_q.work(mean_force, mean_moment)
    value = 0.5 * np.log(det).mean()
    return float(value), by_frames[:, 0], by_q[:, 0]

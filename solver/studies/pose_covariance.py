"""Covariance of the flange's pose, or of a tool on it, by a posterior."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..identification.data import IDENTITY, Samples
from ..identification.effects import curve_values, splines
from ..identification.inference import Posterior
from .projections import rows_of
from .uncertainty import covariance_of

BATCH = 1024
"""Poses whose derivatives are held at once."""


def pose_covariances(
    posterior: Posterior,
    poses: Samples,
    places: np.ndarray,
    *,
    of_ball: bool = False,
    misfit: float = 0.0,
) -> np.ndarray:
    """Return the covariances of poses in the base, shape (N, 6, 6) [m, rad].

    With J the derivatives of a pose by the unknowns, Sigma their covariance, J_q the derivatives by
    the joints, s_x and s_q the noise of the fit, k what a sample tells and f the misfit, it is

        J Sigma J^T + f^2 / k (s_x^2 I_x + s_q^2 J_q J_q^T)

    the place first, then the turn about the base's axes. I_x is the identity for the place, and
    zero for the turn. At a pose each curve is a sum of four coefficients.

    Args:
        posterior: What is known of the robot.
        poses: Joint positions as the encoders read them, and what holds the joints.
        places: Points of the flange's link in the base, shape (N, 3) [m].
        of_ball: The points are the ball's centres, so the ball's place on the flange counts.
        misfit: f, of held-out samples beside the noise of the fit; 0 for the posterior alone.
    """
    Sigma = covariance_of(posterior)
    noise = posterior.noise
    factor = misfit**2 / noise.information
    of_place = factor * noise.space**2 * np.diag([1.0, 1, 1, 0, 0, 0])
    of_joints = factor * noise.joint**2
    covariances = np.empty((len(places), 6, 6))
    for begin in range(0, len(places), BATCH):
        rows = slice(begin, begin + BATCH)
        some = poses.only(rows)
        J, by_joints, knots, G = _derivatives(posterior, some, places[rows], of_ball)
        scalars = J.shape[2]
        spread = rows_of(J) @ Sigma[:scalars, :scalars]
        mixed = G @ Sigma[:, :scalars][knots] @ J.swapaxes(1, 2)
        of_knots = Sigma[knots[:, :, None], knots[:, None]]
        squares = by_joints @ by_joints.swapaxes(1, 2)
        part = spread.reshape(J.shape) @ J.swapaxes(1, 2)
        part += G @ of_knots @ G.swapaxes(1, 2) + mixed + mixed.swapaxes(1, 2)
        covariances[rows] = part + of_place + of_joints * squares
    return covariances


def movement_covariances(
    posterior: Posterior,
    poses: Samples,
    places: np.ndarray,
    *,
    around: Samples,
    of_ball: bool = False,
    misfit: float = 0.0,
) -> np.ndarray:
    """Return the covariances of movements from the first pose to each other, shape (N - 1, 6, 6).

    With e_0 and e the errors of place and turn of both poses in the base, d from the first place to
    the other, and w the turn of the rigid motion that fits the errors of the ball at ``around``
    best, the error of the movement is

        e - L z        z = [e_0, w]        L = [I, [-[d]x, 0]^T]

    So nothing of a base that stands elsewhere, or turned, is left in it. With H the derivatives of
    z, the covariance of e and z is J Sigma H^T. Other arguments are those of
    :func:`pose_covariances`.
    """
    Sigma = covariance_of(posterior)
    C = pose_covariances(posterior, poses, places, of_ball=of_ball, misfit=misfit)
    first = slice(1)
    start = _derivatives(posterior, poses.only(first), places[first], of_ball)
    scalars = start.by_unknowns.shape[2]
    H = np.zeros((9, len(Sigma)))
    H[:6, :scalars] = start.by_unknowns[0]
    H[:6, start.knots[0]] = start.by_knots[0]
    H[6:] = base_turn(posterior, around)
    across = Sigma @ H.T
    of_first = H @ across
    of_first[:6, :6] = C[0]
    movements = np.empty((len(places) - 1, 6, 6))
    for begin in range(1, len(places), BATCH):
        rows = slice(begin, begin + BATCH)
        some = poses.only(rows)
        J, _, knots, G = _derivatives(posterior, some, places[rows], of_ball)
        L = _leaving(places[rows] - places[0])
        back = L.swapaxes(1, 2)
        mixed = (J @ across[:scalars] + G @ across[knots]) @ back
        part = slice(begin - 1, begin - 1 + BATCH)
        movements[part] = C[rows] + L @ of_first @ back - mixed - mixed.swapaxes(1, 2)
    return movements


def _leaving(offsets: np.ndarray) -> np.ndarray:
    """Return L, of movements along offsets (N, 3), shape (N, 6, 9)."""
    L = np.tile(np.eye(6, 9), (len(offsets), 1, 1))
    L[:, :3, 6:] = np.cross(np.eye(3), offsets[:, None]).swapaxes(1, 2)
    return L


def base_turn(
    posterior: Posterior,
    around: Samples,
) -> np.ndarray:
    """Return how the unknowns turn the whole arm: by a rigid motion that fits best, (3, size)."""
    points, J, _ = posterior.linearise(around)
    motions = rows_of(IDENTITY.slopes(points))
    return np.linalg.pinv(motions)[:3] @ rows_of(J)


class PoseSlopes(NamedTuple):
    """Derivatives of N poses: of their places, then of their turns."""

    by_unknowns: np.ndarray
    """J, by all unknowns but curves, shape (N, 6, scalars)."""
    by_joints: np.ndarray
    """J_q, shape (N, 6, m)."""
    knots: np.ndarray
    """Indices of the 4 m coefficients of curves that a pose has, shape (N, k); k is 0 without."""
    by_knots: np.ndarray
    """G, by these, shape (N, 6, k)."""


def _derivatives(
    posterior: Posterior,
    poses: Samples,
    places: np.ndarray,
    of_ball: bool,
) -> PoseSlopes:
    """Return derivatives of poses by all unknowns, and by the joints."""
    model, x, q = posterior.model, posterior.x, poses.q
    curves = posterior.deflection.curves
    if curves is not None:
        poses = replace(poses, q=q + curve_values(q, curves.ravel()))
        model = model.without_curves
        x = x[: model.size]
    points, J, by_joints = model.linearise(x, poses)
    _, turns, turns_by_joints = model.linearise(x, poses, of_turns=True)
    arms = (places - points)[:, :, None]

    def of_pose(
        shift: np.ndarray,
        turn: np.ndarray,
    ) -> np.ndarray:
        by_turn = np.cross(turn, arms, axis=1)
        return np.concatenate([shift + by_turn, turn], axis=1)

    by_unknowns, J_q = of_pose(J, turns), of_pose(by_joints, turns_by_joints)
    if not of_ball:
        moves_ball = [parameter.of_ball for parameter in model.parameters]
        by_unknowns[:, :, np.flatnonzero(moves_ball)] = 0.0
    if curves is None:
        return PoseSlopes(by_unknowns, J_q, np.empty((len(q), 0), int), J_q[:, :, :0])
    index, weights = splines(q)
    N, m = q.shape
    knots = model.size + index * m + np.arange(m, dtype=np.int64)[:, None]
    by_knots = J_q[..., None] * weights[:, None]
    return PoseSlopes(
        by_unknowns, J_q, knots.reshape(N, -1), by_knots.reshape(N, 6, -1)
    )

"""Covariance of the flange's pose, or of a tool on it, by a posterior."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..identification.data import IDENTITY, Samples
from ..identification.effects import curve_values, splines
from ..identification.inference import Posterior
from ..identification.model import ExtendedModel
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
    zero for the turn.

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
    of_place = np.zeros((6, 6))
    of_space = factor * noise.space**2
    of_place[:3, :3] = of_space * np.eye(3)
    of_joints = factor * noise.joint**2
    has_curves = posterior.deflection.curves is not None
    covariances = np.empty((len(places), 6, 6))
    for begin in range(0, len(places), BATCH):
        rows = slice(begin, begin + BATCH)
        part_of_poses = poses.only(rows)
        J, by_joints = _derivatives(posterior, part_of_poses, places[rows])
        if not of_ball:
            J[:, :, _of_ball(posterior.model)] = 0.0
        scalars = J.shape[2]
        of_scalars = Sigma[:scalars, :scalars]
        spread = rows_of(J) @ of_scalars
        spread = spread.reshape(J.shape)
        part = spread @ J.swapaxes(1, 2)
        if has_curves:
            part += _of_curves(Sigma, J, by_joints, part_of_poses.q)
        squares = by_joints @ by_joints.swapaxes(1, 2)
        part += of_place + of_joints * squares
        covariances[rows] = part
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
    unneeded = _of_ball(posterior.model)[: 0 if of_ball else None]
    J_0, by_joints = _derivatives(posterior, poses.only(first), places[first])
    J_0[:, :, unneeded] = 0.0
    scalars = J_0.shape[2]
    H = np.zeros((9, len(Sigma)))
    H[:6, :scalars] = J_0[0]
    H[6:] = base_turn(posterior, around)
    has_curves = posterior.deflection.curves is not None
    if has_curves:
        knots, weights = _knots(poses.q[first], scalars)
        by_knots = by_joints[0, :, :, None] * weights[0]
        H[:6, knots[0].ravel()] = by_knots.reshape(6, -1)
    across = Sigma @ H.T
    of_first = H @ across
    of_first[:6, :6] = C[0]
    movements = np.empty((len(places) - 1, 6, 6))
    for begin in range(1, len(places), BATCH):
        rows = slice(begin, begin + BATCH)
        J, by_joints = _derivatives(posterior, poses.only(rows), places[rows])
        J[:, :, unneeded] = 0.0
        mixed = J @ across[:scalars]
        if has_curves:
            knots, weights = _knots(poses.q[rows], scalars)
            mixed += by_joints @ np.einsum("njw,njwd->njd", weights, across[knots])
        L = _leaving(places[rows] - places[0])
        back = L.swapaxes(1, 2)
        mixed = mixed @ back
        part = slice(begin - 1, begin - 1 + BATCH)
        movements[part] = C[rows] + L @ of_first @ back - mixed - mixed.swapaxes(1, 2)
    return movements


def _leaving(offsets: np.ndarray) -> np.ndarray:
    """Return L, of movements along offsets (N, 3), shape (N, 6, 9)."""
    L = np.tile(np.eye(6, 9), (len(offsets), 1, 1))
    L[:, :3, 6:] = np.cross(np.eye(3), offsets[:, None]).swapaxes(1, 2)
    return L


def base_turn(posterior: Posterior, around: Samples) -> np.ndarray:
    """Return how the unknowns turn the whole arm: by a rigid motion that fits best, (3, size)."""
    points, J, _ = posterior.linearise(around)
    motions = rows_of(IDENTITY.slopes(points))
    return np.linalg.pinv(motions)[:3] @ rows_of(J)


class PoseSlopes(NamedTuple):
    """Derivatives of N poses: of their places, then of their turns."""

    by_unknowns: np.ndarray
    """By all unknowns but curves, shape (N, 6, scalars)."""
    by_joints: np.ndarray
    """Shape (N, 6, m)."""


def _derivatives(
    posterior: Posterior,
    poses: Samples,
    places: np.ndarray,
) -> PoseSlopes:
    """Return derivatives of poses by all unknowns but curves, and by the joints."""
    model = posterior.model
    x = posterior.x
    curves = posterior.deflection.curves
    if curves is not None:
        corrections = curve_values(poses.q, curves.ravel())
        poses = replace(poses, q=poses.q + corrections)
        model = model.without_curves
        x = x[: model.size]
    points, J, by_joints = model.linearise(x, poses)
    _, turns, turns_by_joints = model.linearise(x, poses, of_turns=True)
    arms = (places - points)[:, :, None]

    def of_pose(shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
        by_turn = np.cross(turn, arms, axis=1)
        return np.concatenate([shift + by_turn, turn], axis=1)

    return PoseSlopes(
        by_unknowns=of_pose(J, turns),
        by_joints=of_pose(by_joints, turns_by_joints),
    )


def _of_ball(model: ExtendedModel) -> np.ndarray:
    """Return which unknowns move the ball on the flange."""
    is_of_ball = [parameter.of_ball for parameter in model.parameters]
    return np.flatnonzero(is_of_ball)


def _of_curves(
    Sigma: np.ndarray,
    J: np.ndarray,
    by_joints: np.ndarray,
    q: np.ndarray,
) -> np.ndarray:
    """Return what the curves add: at a pose a curve is a sum of four coefficients, shape (N, 6, 6).

    With J_q the derivatives by the joints, B the covariance of the curves at q, shape (N, m, m),
    and S that with the other unknowns, shape (N, m, scalars), by which J is, it is

        J_q B J_q^T + J_q S J^T + J S^T J_q^T
    """
    m = q.shape[1]
    scalars = J.shape[2]
    places, weights = _knots(q, scalars)
    with_scalars = Sigma[:, :scalars][places]
    S = np.einsum("njw,njws->njs", weights, with_scalars)
    knots = places.reshape(len(q), -1)
    rows = knots[:, :, None]
    columns = knots[:, None]
    of_knots = Sigma[rows, columns]
    w = weights.reshape(len(q), -1)
    products = w[:, :, None] * w[:, None]
    of_curves = products * of_knots
    of_pairs = of_curves.reshape(-1, m, 4, m, 4)
    B = of_pairs.sum(axis=(2, 4))
    across = by_joints.swapaxes(1, 2)
    by_curves = by_joints @ B @ across
    mixed = by_joints @ S @ J.swapaxes(1, 2)
    return by_curves + mixed + mixed.swapaxes(1, 2)


def _knots(q: np.ndarray, scalars: int) -> tuple[np.ndarray, np.ndarray]:
    """Return which unknowns curves have at positions, and their weights, shape (N, m, 4) each."""
    m = q.shape[1]
    index, weights = splines(q)
    joints = np.arange(m, dtype=np.int64)
    return scalars + index * m + joints[:, None], weights

"""How well a calibration is known: deviations, what the data cannot identify, predicted errors."""

from collections.abc import Sequence

import numpy as np

from ..data.observations import Load
from ..robot.kinematics import gravity_torques, workspace
from .noise import INFORMATION
from .posterior import Posterior

__all__ = [
    "correlations",
    "deviations",
    "distance_deviations",
    "observability_index",
    "predicted_deviation",
    "prior_deviations",
    "scale",
    "workspace_deviation",
]

UNDECIDED = 0.5
"""A direction whose posterior deviation is more than this part of its prior's is the prior's."""
STRONG = 0.9


def deviations(posterior: Posterior) -> np.ndarray:
    """Return the posterior standard deviation of every unknown before the centres."""
    return np.sqrt(np.diag(posterior.covariance)[: posterior.model.size])


def prior_covariance(posterior: Posterior) -> np.ndarray:
    """Return the prior covariance of all unknowns before the centres."""
    covariance = np.zeros((posterior.model.size,) * 2)
    for group in posterior.groups:
        covariance[np.ix_(group.members, group.members)] = group.covariance(group.deviation)
    return covariance


def prior_deviations(posterior: Posterior) -> np.ndarray:
    """Return the prior standard deviation of every unknown before the centres."""
    return np.sqrt(np.diag(prior_covariance(posterior)))


def correlations(posterior: Posterior) -> list[tuple[str, str, float]]:
    """Return pairs of unknowns that the data decide only together: correlation beyond 0.9."""
    size = posterior.model.size
    deviation = deviations(posterior)
    known = np.flatnonzero((deviation > 0) & (deviation < UNDECIDED * prior_deviations(posterior)))
    covariance = posterior.covariance[:size, :size][np.ix_(known, known)]
    matrix = covariance / np.outer(deviation[known], deviation[known])
    names = [posterior.model.names[i] for i in known.tolist()]
    rows, columns = np.nonzero(np.triu(np.abs(matrix) > STRONG, k=1))
    pairs = [
        (names[i], names[j], float(matrix[i, j]))
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
    ]
    return sorted(pairs, key=lambda pair: -abs(pair[2]))


def observability_index(posterior: Posterior) -> float:
    """Return O1 of Borm and Menq (1991): (s_1 ... s_L)^(1/L) / sqrt(N).

    The s are the singular values of the ball positions' derivatives by the geometry, each number
    in units of its prior's width, as far as the configurations excite it (s > 1e-6 s_1).
    """
    model, data = posterior.model, posterior.data
    _, jacobian, _ = model.linearise(posterior.x, data.positions, data.torques)
    scaled = jacobian[:, :, : model.geometry] * prior_deviations(posterior)[: model.geometry]
    centred = np.concatenate(
        [rows - rows.mean(axis=0) for k in range(data.socket_count)
         for rows in [scaled[data.sockets == k]]]
    )  # fmt: skip
    values = np.linalg.svd(centred.reshape(-1, model.geometry), compute_uv=False)
    values = values[values > 1e-6 * values[0]]
    return float(np.exp(np.mean(np.log(values))) / np.sqrt(len(data.positions)))


def distance_deviations(posterior: Posterior, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """Return the predicted 1-sigma error of the distances between successive ball positions.

    Args:
        posterior: The calibration.
        q: Joint positions, shape (2 N, m); rows 0 and 1, 2 and 3, ... are pairs.
        torque: Their joint torques.

    Returns:
        Shape (N,) [m].
    """
    points, jacobian, _ = posterior.model.linearise(posterior.x, q, torque)
    offset = points[1::2] - points[::2]
    direction = offset / np.linalg.norm(offset, axis=1, keepdims=True).clip(1e-12)
    slopes = np.einsum("ni,nij->nj", direction, jacobian[1::2] - jacobian[::2])
    size = posterior.model.size
    return np.sqrt(np.einsum("ni,ij,nj->n", slopes, posterior.covariance[:size, :size], slopes))


def predicted_deviation(
    posterior: Posterior, by_socket: Sequence[tuple[np.ndarray, np.ndarray]]
) -> float:
    """Return the predicted rms distance of samples from their socket's mean, noise included [m].

    Args:
        posterior: The calibration.
        by_socket: Joint positions and torques of the samples in each socket.
    """
    size = posterior.model.size
    covariance = posterior.covariance[:size, :size]
    total, count = 0.0, 0
    for q, torque in by_socket:
        _, jacobian, by_joints = posterior.model.linearise(posterior.x, q, torque)
        centred = jacobian - jacobian.mean(axis=0)
        total += float(np.einsum("nij,jk,nik->", centred, covariance, centred))
        noise = np.trace(posterior.noise.scales(by_joints), axis1=1, axis2=2).sum() / INFORMATION
        total += float(noise) * (1 - 1 / len(q))
        count += len(q)
    return (total / count) ** 0.5


def scale(posterior: Posterior) -> tuple[float, float]:
    """Return by how much the arm came out larger than its model, and the deviation of that.

    0.02 stands for an arm that is 2 % longer than nominal. A real arm is within some 0.003 of its
    model; one that came out beyond had most likely a wrong distance between its sockets.
    """
    by_scale = posterior.model.by_scale()
    size = posterior.model.size
    variance = float(by_scale @ posterior.covariance[:size, :size] @ by_scale)
    return float(by_scale @ posterior.x), variance**0.5


def workspace_deviation(posterior: Posterior, load: Load, pairs: int = 200) -> tuple[float, float]:
    """Return median and worst predicted error of distances between random poses [m]."""
    robot = posterior.model.robot
    q = workspace(robot, 2 * pairs)
    torque = gravity_torques(robot, q, load.gravity, load.payload)
    deviation = distance_deviations(posterior, q, torque)
    return float(np.median(deviation)), float(deviation.max())

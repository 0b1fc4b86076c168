"""Samples whose noise is made one: L^-1 before their columns, with L L^T the noise of a sample."""

from typing import NamedTuple

import numpy as np

from ..identification.inference import Posterior


class WhitenedSamples(NamedTuple):
    """N samples in sockets, their noise made one."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    residuals: np.ndarray
    """Shape (N, 3)."""
    slopes: np.ndarray
    """A: derivatives of the residuals by the model's unknowns and the centres, shape (N, 3, n)."""


def samples_in_sockets(posterior: Posterior) -> WhitenedSamples:
    """Return the samples in sockets of a fit."""
    data = posterior.data
    samples = data.only(data.seated)
    points, J, by_joints = posterior.linearise(samples)
    sockets = samples.sockets
    residuals = points - posterior.centres[sockets]
    in_socket = np.eye(len(posterior.centres))[sockets]
    by_centres = -np.kron(in_socket, np.eye(3))
    by_centres = by_centres.reshape(len(points), 3, posterior.centres.size)
    columns = np.dstack([residuals, J, by_centres])
    white = whitened(posterior, by_joints, columns)
    return WhitenedSamples(
        samples.q,
        residuals=white[:, :, 0],
        slopes=white[:, :, 1:],
    )


def whitened(
    posterior: Posterior,
    by_joints: np.ndarray,
    columns: np.ndarray,
) -> np.ndarray:
    """Return L^-1 B of samples' columns B, shape (N, 3, k), by their derivatives by the joints."""
    noise = posterior.noise.as_gaussian(by_joints)
    L = np.linalg.cholesky(noise)
    return np.linalg.solve(L, columns)

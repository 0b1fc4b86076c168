"""Unknowns beside the arm: places of sockets and frames, calipers and play.

Each function returns derivatives of residuals in units of the widths of priors.
"""

from collections.abc import Sequence

import numpy as np

from ...data import SEAT_DEVIATION, Known
from ...robot import Parameter

TRANSLATION, ROTATION, BALL = 2e-3, 1e-2, 0.1
"""Widths of the priors [m], [rad]: as far as arms are from their models."""
ARMS = 0.002
"""Standard deviation of the scale of real arms about their models."""
CENTRE, TURN = 0.3, 1.0
"""Widths of the priors of a socket's centre, and of a frame's turn, about the fit's [m], [rad]."""
SIDES = 0.4
"""Share of the play by which the rest of a joint differs from socket to socket."""
DISTANCE_WEIGHT = 3.0
"""Weight of a distance relative to a sample: centres err by a third of a sample's noise, since the
errors of samples are correlated."""


def widths_of(parameters: Sequence[Parameter]) -> np.ndarray:
    """Return the widths of the priors of a geometry's parameters, shape (n,) [m, rad]."""
    return np.array(
        [BALL if p.of_ball else TRANSLATION if p.unit == "m" else ROTATION for p in parameters]
    )


def precision(widths: np.ndarray, by_scale: np.ndarray, scale: float) -> np.ndarray:
    """Return the inverse covariance of unknowns whose size is held to a scale, shape (n, n)."""
    return np.diag(widths**-2) + np.outer(by_scale, by_scale) / scale**2


def of_centres(
    centres: np.ndarray, sockets: np.ndarray, known: Sequence[Known[int]], expected: Sequence[float]
) -> np.ndarray:
    """Return those by the places of all seats, of samples and distances, shape (3 N + K, 3 S).

    Args:
        centres: Of the seats, shape (S, 3) [m].
        sockets: Seat of each sample, shape (N,).
        known: Known distances.
        expected: These as the fit has them [m].
    """
    S, K = len(centres), len(known)
    of_samples = np.kron(np.eye(S)[sockets], CENTRE * np.eye(3))
    of_known = np.zeros((K, S, 3))
    for row, k, length in zip(of_known, known, expected, strict=True):
        unit = (centres[k.second] - centres[k.first]) / length
        row[k.first] = DISTANCE_WEIGHT * CENTRE * unit
        row[k.second] = -row[k.first]
    return np.vstack([of_samples, of_known.reshape(K, 3 * S)])


def of_play(by_joints: np.ndarray, sockets: np.ndarray, noise: float) -> np.ndarray:
    """Return those of samples by offsets of m joints in each of S seats, shape (3 N, S m).

    Gears with play rest on one side there.
    """
    lever = np.sqrt(np.mean(np.sum(by_joints**2, axis=1), axis=0)).clip(min=0.05)
    turned = by_joints * (SIDES * noise / lever)
    in_seat = np.eye(int(sockets.max()) + 1)[sockets]
    columns = in_seat[:, None, :, None] * turned[:, :, None]
    return columns.reshape(3 * len(turned), -1)


def of_calipers(known: Sequence[Known[int]]) -> np.ndarray:
    """Return those of K distances by the errors of their measurement, shape (K, bases + K)."""
    bases = sorted({k.distance for k in known if k.on_base})
    columns = np.zeros((len(known), len(bases) + len(known)))
    for i, k in enumerate(known):
        deviation = SEAT_DEVIATION if k.on_base else k.deviation
        columns[i, len(bases) + i] = DISTANCE_WEIGHT * deviation
        if k.on_base:
            columns[i, bases.index(k.distance)] = DISTANCE_WEIGHT * k.deviation
    return columns

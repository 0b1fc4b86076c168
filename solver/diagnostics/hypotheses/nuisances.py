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
SHORTEST = 0.05
"""Least distance of the balls from a joint that is reckoned with [m]."""
DISTANCE_WEIGHT = 3.0
"""Weight of a distance relative to a sample: centres err by a third of a sample's noise, since the
errors of samples are correlated."""


def widths_of(parameters: Sequence[Parameter]) -> np.ndarray:
    """Return the widths of the priors of a geometry's parameters, shape (n,) [m, rad]."""
    return np.array(
        [
            BALL if p.of_ball else TRANSLATION if p.unit == "m" else ROTATION
            for p in parameters
        ]
    )


def precision(widths: np.ndarray, by_scale: np.ndarray, scale: float) -> np.ndarray:
    """Return the inverse covariance of unknowns whose size is held to a scale, shape (n, n)."""
    return np.diag(widths**-2) + np.outer(by_scale, by_scale) / scale**2


def of_centres(
    sockets: np.ndarray, known: Sequence[Known[int]], directions: np.ndarray
) -> np.ndarray:
    """Return those by the places of all seats, of samples and distances, shape (3 N + K, 3 S).

    Args:
        sockets: Seat of each sample, shape (N,).
        known: Known distances.
        directions: Of these from the first socket to the second, shape (K, 3).
    """
    seats = np.eye(int(sockets.max()) + 1)
    of_samples = np.kron(seats[sockets], np.eye(3))
    ends = seats[[k.first for k in known]] - seats[[k.second for k in known]]
    of_known = DISTANCE_WEIGHT * ends[:, :, None] * directions[:, None]
    return CENTRE * np.vstack([of_samples, of_known.reshape(-1, of_samples.shape[1])])


def of_play(by_joints: np.ndarray, sockets: np.ndarray, noise: float) -> np.ndarray:
    """Return those of samples by offsets of m joints in each of S seats, shape (3 N, S m).

    Gears with play rest on one side there.
    """
    squares = np.sum(by_joints**2, axis=1)
    levers = np.sqrt(np.mean(squares, axis=0)).clip(min=SHORTEST)
    shifts = by_joints * (SIDES * noise / levers)
    seats = np.eye(int(sockets.max()) + 1)
    columns = seats[sockets][:, None, :, None] * shifts[:, :, None]
    return columns.reshape(3 * len(shifts), -1)


def of_calipers(known: Sequence[Known[int]]) -> np.ndarray:
    """Return those of K distances by the errors of their measurement, shape (K, bases + K)."""
    bases = sorted({k.distance for k in known if k.on_base})
    of_bases = np.zeros((len(known), len(bases)))
    for row, k in zip(of_bases, known, strict=True):
        if k.on_base:
            row[bases.index(k.distance)] = k.deviation
    own = [SEAT_DEVIATION if k.on_base else k.deviation for k in known]
    return DISTANCE_WEIGHT * np.hstack([of_bases, np.diag(own)])

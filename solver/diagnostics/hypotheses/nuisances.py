"""Unknowns beside the arm: places of sockets and frames, calipers and play.

Each function returns derivatives of residuals in units of the widths of priors.
"""

from collections.abc import Sequence

import numpy as np

from ...identification.data import SEAT_DEVIATION, Known
from ...identification.robot import Parameter

TRANSLATION = 2e-3
"""Width of the prior of a length [m]: as far as arms are from their models."""
ROTATION = 1e-2
"""The same of an angle [rad]."""
BALL = 0.1
"""The same of the ball's place [m]."""
ARMS = 0.002
"""Standard deviation of the scale of real arms about their models."""
CENTRE = 0.3
"""Width of the prior of a socket's centre about the fit's [m]."""
TURN = 1.0
"""Width of the prior of a frame's turn about the fit's [rad]."""
SIDES = 0.4
"""Share of the play by which the rest of a joint differs from socket to socket."""
SHORTEST = 0.05
"""Least distance of the balls from a joint that is reckoned with [m]."""
DISTANCE_WEIGHT = 3.0
"""Weight of a distance relative to a sample: centres err by a third of a sample's noise, since the
errors of samples are correlated."""


def widths_of(parameters: Sequence[Parameter]) -> np.ndarray:
    """Return the widths of the priors of a geometry's parameters, shape (n,) [m, rad]."""
    return np.array([_width_of(parameter) for parameter in parameters])


def _width_of(parameter: Parameter) -> float:
    if parameter.of_ball:
        return BALL
    return TRANSLATION if parameter.unit == "m" else ROTATION


def precision(
    widths: np.ndarray,
    by_scale: np.ndarray,
    scale: float,
) -> np.ndarray:
    """Return the inverse covariance of unknowns whose size is held to a scale, shape (n, n)."""
    of_scale = np.outer(by_scale, by_scale)
    return np.diag(widths**-2) + of_scale / scale**2


def of_centres(
    sockets: np.ndarray,
    known: Sequence[Known[int]],
    directions: np.ndarray,
) -> np.ndarray:
    """Return those by the places of all seats, of samples and distances, shape (3 N + K, 3 S).

    Args:
        sockets: Seat of each sample, shape (N,).
        known: Known distances.
        directions: Of these from the first socket to the second, shape (K, 3).
    """
    count = int(sockets.max()) + 1
    seats = np.eye(count)
    of_samples = np.kron(seats[sockets], np.eye(3))
    first = [length.first for length in known]
    second = [length.second for length in known]
    between = seats[first] - seats[second]
    along = between[:, :, None] * directions[:, None]
    of_known = along.reshape(-1, of_samples.shape[1])
    return CENTRE * np.vstack([of_samples, DISTANCE_WEIGHT * of_known])


def of_play(
    by_joints: np.ndarray,
    sockets: np.ndarray,
    noise: float,
) -> np.ndarray:
    """Return those of samples by offsets of m joints in each of S seats, shape (3 N, S m).

    Gears with play rest on one side there.
    """
    squares = np.sum(by_joints**2, axis=1)
    levers = np.sqrt(np.mean(squares, axis=0))
    offsets = SIDES * noise / levers.clip(min=SHORTEST)
    shifts = by_joints * offsets
    seats = np.eye(int(sockets.max()) + 1)
    in_seats = seats[sockets][:, None, :, None]
    columns = in_seats * shifts[:, :, None]
    return columns.reshape(3 * len(shifts), -1)


def of_calipers(known: Sequence[Known[int]]) -> np.ndarray:
    """Return those of K distances by the errors of their measurement, shape (K, bases + K)."""
    bases = sorted({length.distance for length in known if length.on_base})
    of_bases = np.zeros((len(known), len(bases)))
    deviations: list[float] = []
    for row, length in zip(of_bases, known, strict=True):
        deviation = length.deviation
        if length.on_base:
            row[bases.index(length.distance)] = deviation
            deviation = SEAT_DEVIATION
        deviations.append(deviation)
    return DISTANCE_WEIGHT * np.hstack([of_bases, np.diag(deviations)])

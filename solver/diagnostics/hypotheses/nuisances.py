"""Unknowns beside the arm: places of sockets and frames, their turns, calipers and play.

Each function returns derivatives of residuals in units of the widths of priors.
"""

from collections.abc import Collection, Sequence

import numpy as np

from ...bayes.model import shifts_by, width_of
from ...data import SEAT_DEVIATION, Known, Measurement
from ...robot import Parameter, Robot, cross_matrices

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


def root_of_geometry(parameters: Sequence[Parameter], by_scale: np.ndarray) -> np.ndarray:
    """Return a root of the covariance of a geometry whose size is held to that of arms, (n, n)."""
    size = np.outer(by_scale, by_scale) / ARMS**2
    precision = np.diag(1 / widths_of(parameters) ** 2) + size
    return np.linalg.cholesky(np.linalg.inv(precision))


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


def of_turns(offsets: np.ndarray, sockets: np.ndarray, frames: Sequence[int]) -> np.ndarray:
    """Return those of samples by the turns of F frames of instruments, shape (3 N, 3 F).

    ``offsets`` are the samples' places from the origins of these, shape (N, 3) [m].
    """
    by_turn = TURN * cross_matrices(offsets)
    there = sockets[:, None] == np.array(frames, dtype=np.int64)
    columns = there[:, None, :, None] * by_turn[:, :, None, :]
    return columns.reshape(len(by_turn) * 3, 3 * there.shape[1])


def of_differences(
    robot: Robot, q: np.ndarray, places: Collection[tuple[Measurement, slice]]
) -> list[tuple[slice, np.ndarray]]:
    """Return rows and columns of what is otherwise throughout single placements.

    ``places`` has each placement and its samples among the joint positions q, shape (N, m).
    """
    parts: list[tuple[slice, np.ndarray]] = []
    for m, samples in places:
        rows = slice(3 * samples.start, 3 * samples.stop)
        for difference in m.apart:
            shifts = width_of(difference) * shifts_by(robot, q[samples], m.order, difference)
            parts.append((rows, shifts.reshape(-1, shifts.shape[2])))
    return parts


def of_play(by_joints: np.ndarray, sockets: np.ndarray, S: int, noise: float) -> np.ndarray:
    """Return those of samples by offsets of m joints in each of S seats, shape (3 N, S m).

    Gears with play rest on one side there.
    """
    lever = np.sqrt(np.mean(np.sum(by_joints**2, axis=1), axis=0)).clip(min=0.05)
    turned = by_joints * (SIDES * noise / lever)
    m = turned.shape[2]
    columns = np.zeros((len(turned), 3, S, m))
    columns[np.arange(len(turned)), :, sockets] = turned
    return columns.reshape(3 * len(turned), S * m)


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

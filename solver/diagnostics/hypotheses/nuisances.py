"""What is unknown beside the arm: places of sockets and frames, their turns, calipers and play.

Each function returns derivatives of residuals in units of the widths of priors.
"""

from typing import TYPE_CHECKING

import numpy as np

from ...bayes.model import shifts_by, width_of
from ...data import SEAT_DEVIATION
from ...robot import cross_matrices

if TYPE_CHECKING:
    from .scene import Scene

CENTRE, TURN = 0.3, 1.0
"""Widths of the priors of a socket's centre, and of a frame's turn, about the fit's [m], [rad]."""
SIDES = 0.4
"""Share of the play by which the rest of a joint differs from socket to socket."""
DISTANCE_WEIGHT = 3.0
"""Weight of a distance relative to a sample: centres err by a third of a sample's noise, since the
errors of samples are correlated."""


def of_centres(scene: "Scene") -> np.ndarray:
    """Return those by the places of all seats, of samples and distances, shape (3 N + K, 3 S)."""
    S, K = len(scene.centres), len(scene.known)
    of_samples = np.kron(np.eye(S)[scene.sockets], CENTRE * np.eye(3))
    of_known = np.zeros((K, S, 3))
    for row, k, length in zip(of_known, scene.known, scene.expected, strict=True):
        unit = (scene.centres[k.second] - scene.centres[k.first]) / length
        row[k.first] = DISTANCE_WEIGHT * CENTRE * unit
        row[k.second] = -row[k.first]
    return np.vstack([of_samples, of_known.reshape(K, 3 * S)])


def of_turns(scene: "Scene") -> np.ndarray:
    """Return those of samples by the turns of F frames of instruments, shape (3 N, 3 F)."""
    by_turn = TURN * cross_matrices(scene.offsets)
    there = scene.sockets[:, None] == np.array(scene.frames, dtype=np.int64)
    columns = there[:, None, :, None] * by_turn[:, :, None, :]
    return columns.reshape(len(by_turn) * 3, 3 * there.shape[1])


def of_differences(scene: "Scene") -> list[tuple[slice, np.ndarray]]:
    """Return rows and columns of what is otherwise throughout single placements."""
    parts: list[tuple[slice, np.ndarray]] = []
    for m, rows in zip(scene.measurements, scene.places, strict=True):
        for apart in m.apart:
            shifts = width_of(apart) * shifts_by(scene.robot, scene.q[rows], apart)
            parts.append((scene.rows(rows), shifts.reshape(-1, shifts.shape[2])))
    return parts


def of_play(scene: "Scene") -> np.ndarray:
    """Return those of samples by offsets of m joints in each seat, shape (3 N, S m).

    Gears with play rest on one side there.
    """
    lever = np.sqrt(np.mean(np.sum(scene.by_joints**2, axis=1), axis=0)).clip(min=0.05)
    turned = scene.by_joints * (SIDES * scene.noise / lever)
    S, m = len(scene.centres), turned.shape[2]
    columns = np.zeros((len(turned), 3, S, m))
    columns[np.arange(len(turned)), :, scene.sockets] = turned
    return columns.reshape(3 * len(turned), S * m)


def of_calipers(scene: "Scene") -> np.ndarray:
    """Return those of K distances by the errors of their measurement, shape (K, bases + K)."""
    bases = sorted({k.distance for k in scene.known if k.on_base})
    columns = np.zeros((len(scene.known), len(bases) + len(scene.known)))
    for i, k in enumerate(scene.known):
        deviation = SEAT_DEVIATION if k.on_base else k.deviation
        columns[i, len(bases) + i] = DISTANCE_WEIGHT * deviation
        if k.on_base:
            columns[i, bases.index(k.distance)] = DISTANCE_WEIGHT * k.deviation
    return columns

"""Seats of balls: sockets, and frames of instruments, whose rotation is unknown beside their place.

The residual of a sample is Phi(q_i) - R y_i - c, with c the place of its seat and y_i what an
instrument measured in its frame R, c; in a socket y_i is zero. Where all samples are poses, any
point of the target may stand for the ball: its place on the flange is unknown anyway.
"""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from ...data import Measurement

Seat = tuple[str, int]
"""Placement and socket; for a frame its name, and :data:`OF_INSTRUMENT`."""
OF_INSTRUMENT = -1
"""In the place of a socket's number."""
LEVER = np.full(3, 0.06)
"""Place of that point on the target [m]: off any axis of its frame, so that all joints move it."""


def seats_of(measurements: Sequence[Measurement]) -> tuple[tuple[Seat, ...], np.ndarray]:
    """Return all seats, frames last, and the index of each sample's seat, shape (N,)."""
    sockets = list(chain.from_iterable(m.labels for m in measurements))
    frames = dict.fromkeys((m.frame, OF_INSTRUMENT) for m in measurements if m.kind == "points")
    labels: list[Seat] = [*sockets, *frames]
    numbers = {label: i for i, label in enumerate(labels)}
    seats: list[int] = []
    for m in measurements:
        for socket, count in zip(m.sockets, m.counts, strict=True):
            seat = (m.frame, OF_INSTRUMENT) if m.kind == "points" else (m.name, socket)
            seats += [numbers[seat]] * count
    return tuple(labels), np.array(seats, dtype=np.int64)


def measured_points(measurements: Sequence[Measurement]) -> np.ndarray:
    """Return what instruments measured, zero in sockets, shape (N, 3) [m].

    Of poses it is a point beside the ball, which orientations move, too.
    """
    lever = LEVER if all(m.has_orientations for m in measurements) else None
    return np.concatenate([_measured(m, lever) for m in measurements])


def _measured(m: Measurement, lever: np.ndarray | None) -> np.ndarray:
    """Return a placement's points by socket, a lever beside the ball, shape (N, 3) [m]."""
    if m.kind == "sockets":
        return np.zeros((len(m.positions), 3))
    points = m.points if lever is None else m.points + m.rotations @ lever
    return points[m.order]


def rotations(points: np.ndarray, measured: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return rotations of a frame that bring measured points closest to predicted ones.

    Args:
        points: Predicted balls of V models, shape (N, V, 3) [m].
        measured: Shape (N, 3) [m].
        weights: Of the samples in each model, shape (N, V).

    Returns:
        R, shape (V, 3, 3) (Kabsch, 1976).
    """
    shares = weights / weights.sum(axis=0)
    outer = points - np.einsum("nv,nvi->vi", shares, points)
    inner = measured[:, None] - shares.T @ measured
    U, _, Vt = np.linalg.svd(np.einsum("nv,nvi,nvj->vij", shares, outer, inner))
    U[:, :, 2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))[:, None]
    return U @ Vt

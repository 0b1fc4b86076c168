"""Samples by the seats of their balls: sockets, and frames of instruments.

The rotation of a frame is unknown beside its place. The residual of a sample is
Phi(q_i) - R y_i - c, with c the place of its seat and y_i what an instrument measured in its frame
R, c; in a socket y_i is zero. Where all samples are poses, any point of the target may stand for
the ball: its place on the flange is unknown anyway.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...identification.data import Measurement, SampleRows, kabsch
from ...identification.model import NU, student_weights
from ...identification.robot import cross_matrices, turn

Seat = tuple[str, int]
"""Placement and socket; for a frame its name, and :data:`OF_INSTRUMENT`."""
OF_INSTRUMENT = -1
"""In the place of a socket's number."""
LEVER = np.full(3, 0.06)
"""Place of that point on the target [m]: off any axis of its frame, so that all joints move it."""
SMALLEST = 1e-7
"""Noise is never taken for less [m]."""
CHI_SQUARE = 2.366
"""Median of chi-square with 3 degrees of freedom."""
ROUNDS = 5
"""Times that weights follow from the errors that are left."""


@dataclass(frozen=True)
class SeatSamples(SampleRows):
    """Joint positions, the seats of their balls, and what instruments measured."""

    sockets: np.ndarray
    """Index of each sample's seat, a socket or an instrument's frame, shape (N,)."""
    points: np.ndarray
    """Balls in their frame as measured, shape (N, 3) [m]; zero in sockets."""

    @cached_property
    def count(self) -> int:
        """Number of seats."""
        return int(self.sockets.max()) + 1

    @cached_property
    def rows(self) -> list[np.ndarray]:
        """Indices of the samples in each seat."""
        return [np.flatnonzero(self.sockets == k) for k in range(self.count)]

    @cached_property
    def order(self) -> np.ndarray | slice:
        """Indices of the samples seat after seat, as they mostly come."""
        if (np.diff(self.sockets) >= 0).all():
            return slice(None)
        return np.argsort(self.sockets, kind="stable")

    @cached_property
    def starts(self) -> np.ndarray:
        """First index of each seat in that order."""
        return np.searchsorted(self.sockets[self.order], np.arange(self.count))

    def is_overdetermined(self, unknowns: int) -> bool:
        """Return True for twice as many numbers as unknowns, the sockets' centres left out."""
        beside_centres = len(self.sockets) - self.count
        return 3 * beside_centres >= 2 * unknowns

    def thinned(
        self,
        enough: int,
        minimum: int = 1,
    ) -> "SeatSamples":
        """Return about so many of the samples, evenly from each seat, and so many of it."""
        most = max(enough // self.count, minimum)
        indices = [evenly(len(rows), most) for rows in self.rows]
        pairs = zip(self.rows, indices, strict=True)
        few = np.concatenate([rows[some] for rows, some in pairs])
        return self.only(few)

    @cached_property
    def frames(self) -> list[int]:
        """The seats that are frames of instruments."""
        seats = np.unique(self.sockets[self.points.any(axis=1)])
        return seats.tolist()

    def aligned(
        self,
        balls: np.ndarray,
        weights: np.ndarray,
    ) -> np.ndarray:
        """Return the rotations R of all seats by predicted balls of V models, (S, V, 3, 3).

        Balls have shape (N, V, 3) [m], their weights (N, V); sockets have no rotation.
        """
        V = balls.shape[1]
        identity = np.eye(3)
        R = np.tile(identity, (self.count, V, 1, 1))
        for k in self.frames:
            rows = self.rows[k]
            points = self.points[rows]
            for v in range(V):
                pose = kabsch(points, balls[rows, v], weights[rows, v])
                R[k, v] = pose.rotation
        return R

    def robustly_aligned(self, balls: np.ndarray) -> np.ndarray:
        """Return the same of one model's balls, shape (N, 3), by robust weights, (S, 3, 3)."""
        balls = balls[:, None]
        weights = np.ones((len(balls), 1))
        turns = self.aligned(balls, weights)
        for _ in range(ROUNDS if self.frames else 0):
            places = balls - self.offsets(turns)
            errors = places - medians(places, self)[self.sockets]
            weights = robust_weights(errors, typical(errors))
            turns = self.aligned(balls, weights)
        return turns[:, 0]

    def offsets(self, R: np.ndarray) -> np.ndarray:
        """Return R y of the samples by the rotations of their seats, shape (N, ..., 3) [m]."""
        if not self.frames:
            shape = R.shape[1:-1]
            return np.zeros((len(self.sockets), *shape))
        return np.einsum("n...ij,nj->n...i", R[self.sockets], self.points)

    def by_turns(self, offsets: np.ndarray) -> np.ndarray:
        """Return the derivatives of -exp(w) R y by the turns w of all frames, (N, ..., 3, 3 F)."""
        unknowns = 3 * len(self.frames)
        slopes = np.zeros((*offsets.shape, unknowns))
        for i, k in enumerate(self.frames):
            rows = self.rows[k]
            of_frame = slice(3 * i, 3 * i + 3)
            slopes[rows, ..., of_frame] = cross_matrices(offsets[rows])
        return slopes

    def turned(
        self,
        R: np.ndarray,
        turns: np.ndarray,
    ) -> np.ndarray:
        """Return rotations of seats after small turns of the frames, shape (3 F,) [rad]."""
        after = R.copy()
        small_turns = turn(turns.reshape(-1, 3))
        after[self.frames] = small_turns @ R[self.frames]
        return after


def samples_of(measurements: Sequence[Measurement]) -> SeatSamples:
    """Return the samples of placements, seat after seat."""
    positions = np.concatenate([m.positions for m in measurements])
    _, sockets = seats_of(measurements)
    return SeatSamples(positions, sockets, _measured(measurements))


def seats_of(
    measurements: Sequence[Measurement],
) -> tuple[tuple[Seat, ...], np.ndarray]:
    """Return all seats, frames last, and the index of each sample's seat, shape (N,)."""
    seats: list[Seat] = []
    for m in measurements:
        for socket, count in zip(m.sockets, m.counts, strict=True):
            seat = (m.name, socket)
            if m.kind == "points":
                seat = (m.frame, OF_INSTRUMENT)
            seats += [seat] * count
    labels = sorted(dict.fromkeys(seats), key=lambda seat: seat[1] == OF_INSTRUMENT)
    return tuple(labels), np.array([labels.index(seat) for seat in seats])


def _measured(measurements: Sequence[Measurement]) -> np.ndarray:
    """Return what instruments measured, zero in sockets, shape (N, 3) [m].

    Of poses it is a point beside the ball, which orientations move, too.
    """
    of_poses = all(m.has_orientations for m in measurements)
    parts: list[np.ndarray] = []
    for m in measurements:
        if m.kind == "sockets":
            nothing = np.zeros((len(m.positions), 3))
            parts.append(nothing)
            continue
        points = m.points
        if of_poses:
            points = points + m.rotations @ LEVER
        parts.append(points[m.order])
    return np.concatenate(parts)


def evenly(
    count: int,
    enough: int,
) -> np.ndarray:
    """Return indices of so many of some samples at most, evenly chosen."""
    return np.linspace(0, count - 1, min(count, enough)).astype(int)


def medians(
    points: np.ndarray,
    samples: SeatSamples,
) -> np.ndarray:
    """Return the medians in each seat, shape (S, 3)."""
    by_seat = [median(points[rows]) for rows in samples.rows]
    return np.array(by_seat)


def means(
    values: np.ndarray,
    samples: SeatSamples,
    weights: np.ndarray,
) -> np.ndarray:
    """Return the weighted mean in each seat of values of shape (N, ...)."""
    order = samples.order
    starts = samples.starts
    axes = values.ndim - weights.ndim
    weights = weights.reshape(*weights.shape, *[1] * axes)
    weighted = weights * values
    totals = np.add.reduceat(weights[order], starts)
    return np.add.reduceat(weighted[order], starts) / totals


def median(values: np.ndarray) -> np.ndarray:
    """Return the median over the first axis; for few values NumPy's own takes ten times as long."""
    ascending = np.sort(values, axis=0)
    n = len(values)
    return (ascending[(n - 1) // 2] + ascending[n // 2]) / 2


def typical(errors: np.ndarray) -> np.ndarray:
    """Return the scale of errors per axis, shape (N, ..., 3), by their median, shape (...) [m]."""
    return np.maximum(median(_squares(errors)) / CHI_SQUARE, SMALLEST**2) ** 0.5


def robust_weights(
    errors: np.ndarray,
    noise: float | np.ndarray,
) -> np.ndarray:
    """Return the robust weight of each error, shape (N, ..., 3), for a noise s [m]."""
    return student_weights(_squares(errors) / noise**2, NU)


def _squares(errors: np.ndarray) -> np.ndarray:
    """Return the squared lengths of vectors, shape (..., 3)."""
    return np.einsum("...i,...i->...", errors, errors)

"""Change points: the samples of a socket are cut into segments wherever the predicted centre jumps.

The longest segment is the socket's own; each other one was recorded in another socket, or after the
base had moved.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..bayes.model import NU
from ..data import Measurement
from .robust_fit import RigidFit, RigidModel, Samples, median

SIGNIFICANT = 40.0
"""A jump counts if its square is this many times its variance; by chance it would be about 3
times."""
SMALLEST_MOVE = 7.5e-4
"""A base that is knocked moves by more than this [m]; less may be how the arm was guided."""
LEAST_NOISE_WITH_BACKLASH = 2.3e-3
"""Noise of arms made of servos is not taken for less [m]: their backlash moves successive
samples together, as a knock would. Of 96 sockets with 0.7 degrees of it, one would need 1.93 mm."""
SIDE = 4
"""Samples needed on each side of a change."""
LARGE_MOVE, LARGE_SIDE = 1e-2, 3
"""A jump as large as this [m] needs no more samples than this."""
SAME_PLACE = 3e-3
"""Segments nearer to each other than this [m] were recorded at one place."""
CANDIDATES = 100
"""Evenly spaced change points tried at first; then those near the best of them."""
ROUNDS = 3


@dataclass(frozen=True)
class Change:
    """A base that moved while a socket was recorded."""

    socket: int
    sample: int
    """The first sample after the move, counted from 0 in its socket."""
    jump: float
    """Distance that the predicted centre moved [m]."""


@dataclass(frozen=True)
class Segment:
    """Successive samples of a socket with one centre."""

    socket: int
    """Index of the socket among all."""
    begin: int
    """Its first sample, counted from 0 in the socket."""
    end: int
    """One after its last."""


def find_segments(model: RigidModel, samples: Samples) -> tuple[RigidFit, list[Segment]]:
    """Return a fit to samples that are cut where their centre jumps, and the segments.

    The segments are one socket each in the fit: the longest of each socket first, in the order of
    the sockets, then all others in the order of the list.
    """
    least = LEAST_NOISE_WITH_BACKLASH if model.zeros else 0.0
    fit = model.fit(samples)
    noise = max(fit.noise, least) ** 2
    sockets = [fit.points[samples.sockets == k] for k in range(samples.count)]
    segments = [
        segment for k, points in enumerate(sockets) for segment in _first_segments(k, points, noise)
    ]
    if len(segments) == samples.count:
        return fit, segments
    for _ in range(ROUNDS):
        fit = model.fit(with_segments(samples, segments))
        before, segments = segments, _refined(segments, fit, samples, max(fit.noise, least) ** 2)
        if segments == before:
            break
    segments = _ordered(segments, model.fit(with_segments(samples, segments)))
    return model.fit(with_segments(samples, segments)), segments


def with_segments(samples: Samples, segments: Sequence[Segment]) -> Samples:
    """Return samples with each segment as a socket."""
    sockets = np.zeros_like(samples.sockets)
    for index, segment in enumerate(segments):
        rows = np.flatnonzero(samples.sockets == segment.socket)
        sockets[rows[segment.begin : segment.end]] = index
    return Samples(samples.positions, sockets)


def _ordered(segments: Sequence[Segment], fit: RigidFit) -> list[Segment]:
    """Return each socket's own segment first: the longest at the place of most samples."""
    places = [fit.centres[i] for i in range(len(segments))]

    def belongs(i: int) -> tuple[int, int]:
        there = [
            segment.end - segment.begin
            for segment, place in zip(segments, places, strict=True)
            if segment.socket == segments[i].socket
            and np.linalg.norm(place - places[i]) < SAME_PLACE
        ]
        return sum(there), segments[i].end - segments[i].begin

    sockets = dict.fromkeys(segment.socket for segment in segments)
    main = [
        segments[max((i for i, p in enumerate(segments) if p.socket == k), key=belongs)]
        for k in sockets
    ]
    return main + [segment for segment in segments if segment not in main]


def _first_segments(socket: int, points: np.ndarray, noise: float) -> list[Segment]:
    """Return the segments of a socket as the first fit shows them."""
    ends = [*_change_points(points, noise, 0, len(points)), len(points)]
    return [Segment(socket, begin, end) for begin, end in zip([0, *ends], ends, strict=False)]


def _refined(
    segments: Sequence[Segment], fit: RigidFit, samples: Samples, noise: float
) -> list[Segment]:
    """Return the segments that a better fit confirms, each cut where it has it."""
    refined = [segments[0]]
    for segment in segments[1:]:
        last = refined[-1]
        if last.socket != segment.socket:
            refined.append(segment)
            continue
        points = fit.points[samples.sockets == segment.socket][last.begin : segment.end]
        k = _likeliest(points, last.end - last.begin, noise)
        kept = _significance(points, k, noise) > SIGNIFICANT
        ends = [last.begin + k, segment.end] if kept else [segment.end]
        refined[-1:] = [
            Segment(segment.socket, begin, end)
            for begin, end in zip([last.begin, *ends], ends, strict=False)
        ]
    return refined


def _change_points(
    points: np.ndarray, noise: float, begin: int, end: int, depth: int = 0
) -> list[int]:
    """Return the samples before which the centre jumps, in order."""
    k = _best_change_point(points[begin:end], noise)
    if k == 0 or depth == ROUNDS:
        return []
    at = begin + k
    return [
        *_change_points(points, noise, begin, at, depth + 1),
        at,
        *_change_points(points, noise, at, end, depth + 1),
    ]


def _best_change_point(points: np.ndarray, noise: float) -> int:
    """Return the first sample after the most significant jump; 0 where there is none."""
    low, high, step = LARGE_SIDE, len(points) - LARGE_SIDE, len(points)
    best = (0.0, 0)
    while step > 1:
        step = max((high - low) // CANDIDATES, 1)
        scores = [(_significance(points, k, noise), k) for k in range(low, high + 1, step)]
        best = max([best, *scores])
        low, high = max(best[1] - step, LARGE_SIDE), min(best[1] + step, len(points) - LARGE_SIDE)
    return _likeliest(points, best[1], noise) if best[0] > SIGNIFICANT else 0


def _likeliest(points: np.ndarray, k: int, noise: float) -> int:
    """Return the change point near k by which the samples are likeliest."""
    for _ in range(ROUNDS):
        centres, variance = _centres_beside(points, k, noise)
        costs = [np.log1p(np.sum((points - c) ** 2, axis=1) / (NU * variance)) for c in centres]
        k = int(np.argmin(np.cumsum(costs[0] - costs[1])[:-1])) + 1
    return k


def _significance(points: np.ndarray, k: int, noise: float) -> float:
    """Return the squared jump before sample k over its variance; 0 for one too small to count."""
    centres, variance = _centres_beside(points, k, noise)
    jump = float(np.linalg.norm(centres[1] - centres[0]))
    few = min(k, len(points) - k) < SIDE
    if jump < (LARGE_MOVE if few else SMALLEST_MOVE):
        return 0.0
    return jump**2 / (variance * (1 / k + 1 / (len(points) - k)))


def _centres_beside(points: np.ndarray, k: int, noise: float) -> tuple[list[np.ndarray], float]:
    """Return the centres before and from sample k on, and the variance about them per axis.

    The variance is not less than the noise of all samples. Each side has its own robust centre, so
    that neither a far sample nor a jump hides the other.
    """
    sides = points[:k], points[k:]
    medians = [median(side) for side in sides]
    squares = [np.sum((p - m) ** 2, axis=1) for p, m in zip(sides, medians, strict=True)]
    variance = max(float(median(np.concatenate(squares))) / 2.366, noise)  # chi2 with 3
    weights = [1 / (NU + d / variance) for d in squares]
    return [w @ p / w.sum() for p, w in zip(sides, weights, strict=True)], variance


def split_at(measured: Measurement, changes: Sequence[Change]) -> Measurement:
    """Return a placement with the samples after each change as a socket of its own."""
    placement = measured.placement
    samples = list(placement.samples)
    free = max(sample.socket for sample in samples) + 1
    rows = {
        change.socket: [i for i, s in enumerate(samples) if s.socket == change.socket]
        for change in changes
    }
    for change in changes:
        for i in rows[change.socket][change.sample :]:
            samples[i] = replace(samples[i], socket=free)
        free += 1
    return replace(measured, placement=replace(placement, samples=tuple(samples)))

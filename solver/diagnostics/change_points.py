"""Where the ball sat elsewhere for a while: a base that moved, or a wrong socket number.

The samples of a socket are cut into parts wherever the predicted centre jumps. The longest part
is the socket's own; each other part was recorded in another socket, or after the base had moved.
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
PLAYED = 2.3e-3
"""Noise of arms made of servos is not taken for less [m]: their play moves successive samples
together, as a knock would. Of 96 sockets with 0.7 degrees of it, one would need 1.93 mm."""
SIDE = 4
"""Samples needed on each side of a change."""
LARGE_MOVE, LARGE_SIDE = 1e-2, 3
"""A jump as large as this [m] needs no more samples than this."""
SAME_PLACE = 3e-3
"""Parts nearer to each other than this [m] were recorded at one place."""
CANDIDATES = 100
"""How many evenly spaced places for a cut are tried at first; then those near the best of them."""
ROUNDS = 3


@dataclass(frozen=True)
class Change:
    """A base that moved while a socket was recorded."""

    socket: int
    sample: int
    """The first sample after the move, counted from 0 in its socket."""
    jump: float
    """How far the predicted centre moved [m]."""


@dataclass(frozen=True)
class Part:
    """Successive samples of a socket with one centre."""

    socket: int
    """Index of the socket among all."""
    begin: int
    """Its first sample, counted from 0 in the socket."""
    end: int
    """One after its last."""


def find_parts(model: RigidModel, samples: Samples) -> tuple[RigidFit, list[Part]]:
    """Return a fit to samples that are cut where their centre jumps, and the parts.

    The parts are one socket each in the fit: the longest of each socket first, in the order of
    the sockets, then all others in the order of the list.
    """
    least = PLAYED if model.zeros else 0.0
    fit = model.fit(samples)
    noise = max(fit.noise, least) ** 2
    sockets = [fit.points[samples.sockets == k] for k in range(samples.count)]
    parts = [part for k, points in enumerate(sockets) for part in _first_parts(k, points, noise)]
    if len(parts) == samples.count:
        return fit, parts
    for _ in range(ROUNDS):
        fit = model.fit(cut(samples, parts))
        before, parts = parts, _settled(parts, fit, samples, max(fit.noise, least) ** 2)
        if parts == before:
            break
    parts = _ordered(parts, model.fit(cut(samples, parts)))
    return model.fit(cut(samples, parts)), parts


def cut(samples: Samples, parts: Sequence[Part]) -> Samples:
    """Return samples with each part as a socket."""
    sockets = np.zeros_like(samples.sockets)
    for index, part in enumerate(parts):
        rows = np.flatnonzero(samples.sockets == part.socket)
        sockets[rows[part.begin : part.end]] = index
    return Samples(samples.positions, sockets)


def _ordered(parts: Sequence[Part], fit: RigidFit) -> list[Part]:
    """Return each socket's own part first: where most of its samples are, the longest of them."""
    places = [fit.centres[i] for i in range(len(parts))]

    def belongs(i: int) -> tuple[int, int]:
        there = [
            part.end - part.begin
            for part, place in zip(parts, places, strict=True)
            if part.socket == parts[i].socket and np.linalg.norm(place - places[i]) < SAME_PLACE
        ]
        return sum(there), parts[i].end - parts[i].begin

    sockets = dict.fromkeys(part.socket for part in parts)
    main = [
        parts[max((i for i, p in enumerate(parts) if p.socket == k), key=belongs)] for k in sockets
    ]
    return main + [part for part in parts if part not in main]


def _first_parts(socket: int, points: np.ndarray, noise: float) -> list[Part]:
    """Return the parts of a socket as the first fit shows them."""
    ends = [*_cuts(points, noise, 0, len(points)), len(points)]
    return [Part(socket, begin, end) for begin, end in zip([0, *ends], ends, strict=False)]


def _settled(parts: Sequence[Part], fit: RigidFit, samples: Samples, noise: float) -> list[Part]:
    """Return the parts with each cut where a better fit has it, without those that it denies."""
    settled = [parts[0]]
    for part in parts[1:]:
        last = settled[-1]
        if last.socket != part.socket:
            settled.append(part)
            continue
        points = fit.points[samples.sockets == part.socket][last.begin : part.end]
        k = _exactly(points, last.end - last.begin, noise)
        kept = _significance(points, k, noise) > SIGNIFICANT
        ends = [last.begin + k, part.end] if kept else [part.end]
        settled[-1:] = [
            Part(part.socket, begin, end)
            for begin, end in zip([last.begin, *ends], ends, strict=False)
        ]
    return settled


def _cuts(points: np.ndarray, noise: float, begin: int, end: int, depth: int = 0) -> list[int]:
    """Return where the centre jumps between two samples, in order."""
    k = _best_cut(points[begin:end], noise)
    if k == 0 or depth == ROUNDS:
        return []
    at = begin + k
    return [
        *_cuts(points, noise, begin, at, depth + 1),
        at,
        *_cuts(points, noise, at, end, depth + 1),
    ]


def _best_cut(points: np.ndarray, noise: float) -> int:
    """Return the first sample after the most significant jump; 0 where there is none."""
    low, high, step = LARGE_SIDE, len(points) - LARGE_SIDE, len(points)
    best = (0.0, 0)
    while step > 1:
        step = max((high - low) // CANDIDATES, 1)
        scores = [(_significance(points, k, noise), k) for k in range(low, high + 1, step)]
        best = max([best, *scores])
        low, high = max(best[1] - step, LARGE_SIDE), min(best[1] + step, len(points) - LARGE_SIDE)
    return _exactly(points, best[1], noise) if best[0] > SIGNIFICANT else 0


def _exactly(points: np.ndarray, k: int, noise: float) -> int:
    """Return the cut near k by which the samples are most likely, given the centres beside it."""
    for _ in range(ROUNDS):
        centres, variance = _sides(points, k, noise)
        costs = [np.log1p(np.sum((points - c) ** 2, axis=1) / (NU * variance)) for c in centres]
        k = int(np.argmin(np.cumsum(costs[0] - costs[1])[:-1])) + 1
    return k


def _significance(points: np.ndarray, k: int, noise: float) -> float:
    """Return how significant a jump before sample k is; 0 for one that is too small to count."""
    centres, variance = _sides(points, k, noise)
    jump = float(np.linalg.norm(centres[1] - centres[0]))
    few = min(k, len(points) - k) < SIDE
    if jump < (LARGE_MOVE if few else SMALLEST_MOVE):
        return 0.0
    return jump**2 / (variance * (1 / k + 1 / (len(points) - k)))


def _sides(points: np.ndarray, k: int, noise: float) -> tuple[list[np.ndarray], float]:
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
    """Return a placement with the part after each change as a socket of its own."""
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

"""The base: moved from a sample on or at the change of socket, drifting; or its distance is wrong.

No recording tells a model that is scaled as a whole from a wrong distance: their evidence is one.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ...robot import cross_matrices
from .kinds import Block, Parameters, of_samples
from .nuisances import DISTANCE_WEIGHT
from .samples import means
from .scene import Scene

SIDE, MOST_CUTS = 2, 100
"""Samples needed on each side of a change, and changes tried in a placement."""
MOVES, DRIFTS = (1e-3, 1e-2, 0.2), (5e-4, 5e-3)
"""Typical sizes [m]."""
TURNS = (0.01, 0.1)
"""Typical turns of a base [rad]."""
FAR = 0.03
"""A larger move is not linear beside the distance of the sockets [m]."""
KNOWN = (1e-3, 0.1)
"""Typical errors of a known distance beside those of bases [m]."""
SHARES = (0.01, 0.1, 1.0, 10.0)
"""Typical shares by which a distance is wrong."""
SOURCES = {
    "default": "nothing but the default: measure it and pass the reading with --distance",
    "given": "as given: measure it again and pass the reading with --distance",
    "located": "by the sockets' coordinates: measure those again",
    "recording": "as placement.json has it: measure it again, and mend it there",
}


def changes(
    scene: Scene,
    slopes: np.ndarray,
    widths: tuple[float, ...],
    *,
    throughout: bool = True,
) -> Iterable[Block]:
    """Return blocks of what is off from some sample on by k unknowns: slopes of (N, 3, C, k)."""
    for place, rows in enumerate(scene.places):
        times, sockets = scene.times[place], scene.sockets[rows]
        cuts = np.linspace(SIDE, len(times) - SIDE, min(len(times), MOST_CUTS))
        ranks = np.unique(cuts.astype(int))
        after = times >= ranks[:, None]
        in_socket = sockets == np.unique(sockets)[:, None]
        counts: np.ndarray = after.astype(int) @ in_socket.T
        # where whole sockets moved alone, their centres hold that
        partly = (counts != 0) & (counts != in_socket.sum(axis=1))
        ranks = ranks[partly.any(axis=1)]
        shares_frame = np.isin(scene.sockets, sockets).sum() > len(times)
        if (throughout and len(scene.places) > 1) or shares_frame:
            ranks = np.append(0, ranks)
        if not len(ranks):
            continue
        C = slopes.shape[2]
        after = times >= ranks[:, None]
        of_candidates = slopes[rows].transpose(2, 0, 1, 3)
        columns = after[:, None, :, None, None] * of_candidates
        names: list[Parameters] = []
        for rank in ranks.tolist():
            first = scene.sample(place, int(np.argmax(times == rank)))
            names += [{**first, "throughout": float(rank == 0)}] * C
        yield of_samples(rows, columns, names, widths)


def moved(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases, or instruments, that moved before some sample."""
    slopes = np.tile(np.eye(3), (len(scene.q), 1, 1))
    if scene.frames:
        slopes = np.concatenate([slopes, _turns(scene)], axis=2)
    return changes(scene, slopes[:, :, None], MOVES, throughout=False)


def turned(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that turned about their first socket before some sample."""
    seats = scene.centres[scene.sockets]
    arms = [seats[rows] - seats[rows.start] for rows in scene.places]
    slopes = np.cross([0.0, 0.0, 1.0], np.concatenate(arms))
    return changes(scene, slopes[:, :, None, None], TURNS, throughout=False)


def _turns(scene: Scene) -> np.ndarray:
    """Return the shifts of points by turns of their frame about their middle, (N, 3, 3).

    A turn by 1 moves a point by 1 m on average; sockets have no turn.
    """
    samples = scene.samples
    even = np.ones(len(scene.q))
    middles = means(scene.offsets, samples, even)
    arms = scene.offsets - middles[samples.sockets]
    squares = means(arms**2, samples, even).mean(axis=1)
    sizes = np.maximum(squares**0.5, 1e-6)
    return cross_matrices(arms) / sizes[samples.sockets, None, None]


def drifting(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved slowly over a placement."""
    for place, rows in enumerate(scene.places):
        times = scene.times[place]
        course = times / max(times.max(), 1) - 0.5
        columns = course[:, None, None] * np.eye(3)
        yield of_samples(rows, columns, [scene.named(place)], DRIFTS)


def drift_by(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how far a base drifted, and where to, from the first sample to the last."""
    return {"size": float(np.linalg.norm(values)), "shift": values.tolist()}


def moved_by(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how far the base moved; a large move by a socket's samples."""
    size = float(np.linalg.norm(values))
    if size > FAR and "point" not in parameters:
        seat = scene.labels.index((parameters["placement"], parameters["socket"]))
        in_seat = scene.sockets == seat
        balls, after = (
            scene.seats[in_seat],
            scene.numbers[in_seat] >= parameters["sample"],
        )
        # In a socket that was entered after the move, none tells how far.
        if not after.all():
            size = float(
                np.linalg.norm(balls[after].mean(axis=0) - balls[~after].mean(axis=0))
            )
    return {"size": size}


def _length_by_length(
    scene: Scene, *, on_base: bool
) -> Iterator[tuple[int, Parameters]]:
    """Yield the known distances of one kind: their row, and their names and lengths."""
    lengths = zip(scene.known, scene.expected.tolist(), strict=True)
    for row, (length, expected) in enumerate(lengths, scene.all_lengths.start):
        if length.on_base == on_base:
            a, b = scene.labels[length.first], scene.labels[length.second]
            ends = f"{a[0]}:{a[1]}-{b[0]}:{b[1]}={length.distance}"
            name = {"placement": a[0]} if on_base else {"known": ends}
            yield row, {**name, "expected": expected, "given": length.distance}


def _of_length(row: int, change: float, names: Parameters, **more: Any) -> Block:
    """Return the block of one known distance that is off by an unknown, or a known change."""
    return Block(
        slice(row, row + 1),
        np.full((1, 1, 1), DISTANCE_WEIGHT * change),
        [names],
        **more,
    )


def between(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved while the ball changed its socket."""
    for row, names in _length_by_length(scene, on_base=True):
        source = SOURCES[scene.measured(names["placement"]).distance_source]
        yield _of_length(row, 1.0, {**names, "source": source}, widths=MOVES)


def of_one_socket(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements whose ball was in one socket throughout."""
    for row, names in _length_by_length(scene, on_base=True):
        yield _of_length(row, -names["given"], names, fixed=True)


def of_known(scene: Scene) -> Iterable[Block]:
    """Return blocks of known distances beside those of bases, each of which may be wrong."""
    for row, names in _length_by_length(scene, on_base=False):
        yield _of_length(row, 1.0, names, widths=KNOWN)


def of_distance(scene: Scene) -> Iterable[Block]:
    """Return blocks of a share by which all distances of bases are too long, or all points."""
    columns = _of_bases(scene)
    if columns.any():
        yield Block(scene.all_lengths, -columns[None, :, None], [{}], SHARES)
    for k in scene.frames:
        in_frame = scene.sockets == k
        columns = -(scene.offsets * in_frame[:, None])
        frame = {"frame": scene.labels[k][0]}
        yield Block(scene.all_samples, columns.reshape(1, -1, 1), [frame], SHARES)


def of_model(scene: Scene) -> Iterable[Block]:
    """Return the block of one share by which all lengths of the model are too short."""
    columns = np.append(scene.offsets, _of_bases(scene))
    if not columns.any():
        return
    first = 0 if scene.frames else scene.all_lengths.start
    rows = slice(first, len(columns))
    yield Block(rows, -columns[None, rows, None], [{}], SHARES)


def _of_bases(scene: Scene) -> np.ndarray:
    """Return the changes of all distances for each share that those of bases are too long, (K,)."""
    on_base = np.array([length.on_base for length in scene.known])
    return DISTANCE_WEIGHT * scene.expected * on_base


def share(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the share, and how far apart the sockets would be."""
    value = float(values[0])
    length = next((k.distance for k in scene.known if k.on_base), 0.0)
    if "frame" in parameters or not length:
        return {"share": value / max(1 - value, 0.1)}
    likely = length / max(1 + value, 0.1)
    source = SOURCES[
        next(m for m in scene.measurements if m.has_distance).distance_source
    ]
    return {"share": value, "given": length, "likely": likely, "source": source}

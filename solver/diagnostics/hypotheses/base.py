"""The base: moved from a sample on or at the change of socket, drifting; or its distance is wrong.

No recording tells a model that is scaled as a whole from a wrong distance: their evidence is one.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ...identification.robot import cross_matrices
from .kinds import Block, Parameters, of_samples
from .samples import means
from .scene import DISTANCE_WEIGHT, Scene

SIDE = 2
"""Samples needed on each side of a change."""
LONGEST = 12
"""Samples for which a base was elsewhere at most, before it fell back."""
MOST_CUTS = 100
"""Changes tried in a placement."""
MOVES = (1e-3, 1e-2, 0.2)
"""Typical moves of a base [m]."""
TIPS = (1e-3, 3e-3)
"""Typical moves of a base that falls back [m]; one that is put elsewhere stays there."""
DRIFTS = (5e-4, 5e-3)
"""Typical drifts of a base [m]."""
TURNS = (0.01, 0.1)
"""Typical turns of a base [rad]."""
FAR = 0.03
"""A larger move is not linear beside the distance of the sockets [m]."""
KNOWN = (1e-3, 0.1)
"""Typical errors of a known distance beside those of bases [m]."""
SHARES = (0.01, 0.1, 1.0, 10.0)
"""Typical shares by which a distance is wrong."""
OF_INSTRUMENTS = (3e-3, 0.03)
"""The same of an instrument, which is never far off but for a unit, which the table shows."""
SOURCES = {
    "default": "nothing but the default: measure it, and add --distance 50.1mm if you read 50.1 mm",
    "given": "as you gave it: measure again, and type both readings, "
    "as --distance FIRST --distance SECOND",
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
    candidates = slopes.shape[2]
    for place, rows in enumerate(scene.places):
        cuts = _cuts(scene, place, throughout=throughout)
        if not len(cuts):
            continue
        after = scene.ranks[place] >= cuts[:, None]
        of_candidates = slopes[rows].transpose(
            2,
            0,
            1,
            3,
        )
        columns = after[:, None, :, None, None] * of_candidates
        names: list[Parameters] = []
        for cut in cuts.tolist():
            name = {**scene.sample(place, cut), "throughout": float(cut == 0)}
            names += [name] * candidates
        yield of_samples(
            rows,
            columns,
            names,
            widths,
        )


def _cuts(
    scene: Scene,
    place: int,
    *,
    throughout: bool,
) -> np.ndarray:
    """Return the ranks of samples from which on a placement may be otherwise.

    Rank 0 is among them where others tell it: placements, if ``throughout``, or the same frame.
    """
    sockets = scene.sockets[scene.places[place]]
    count = len(sockets)
    even = np.linspace(SIDE, count - SIDE, min(count, MOST_CUTS))
    cuts = np.unique(even.astype(int))
    after = scene.ranks[place] >= cuts[:, None]
    cuts = cuts[_partly(after, sockets)]
    beside_others = throughout and len(scene.places) > 1
    in_seats = np.isin(scene.sockets, sockets)
    if beside_others or in_seats.sum() > count:
        return np.append(0, cuts)
    return cuts


def _partly(
    masks: np.ndarray,
    sockets: np.ndarray,
) -> np.ndarray:
    """Return whether each mask has a part of some socket's samples, shape (C,).

    Where whole sockets moved alone, their centres hold that.
    """
    in_socket = sockets == np.unique(sockets)[:, None]
    counts = masks.astype(int) @ in_socket.T
    partly = (counts != 0) & (counts != in_socket.sum(axis=1))
    return partly.any(axis=1)


def moved(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases, or instruments, that moved before some sample."""
    slopes = np.tile(np.eye(3), (len(scene.q), 1, 1))
    if scene.frames:
        # the shifts of points by turns of their frame about their middle, (N, 3, 3)
        samples = scene.samples
        even = np.ones(len(scene.q))
        arms = scene.offsets - means(scene.offsets, samples, even)[scene.sockets]
        variances = means(arms**2, samples, even).mean(axis=1)
        sizes = np.maximum(variances**0.5, 1e-6)
        slopes = np.concatenate(
            [slopes, cross_matrices(arms) / sizes[scene.sockets, None, None]], axis=2
        )
    return changes(
        scene,
        slopes[:, :, None],
        MOVES,
        throughout=False,
    )


def turned(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that turned about their first socket before some sample."""
    seats = scene.centres[scene.sockets]
    arms = np.empty_like(seats)
    for rows in scene.places:
        arms[rows] = seats[rows] - seats[rows.start]
    slopes = np.cross([0.0, 0.0, 1.0], arms)
    return changes(
        scene,
        slopes[:, :, None, None],
        TURNS,
        throughout=False,
    )


def tipped(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that were elsewhere for some samples in a row, and fell back."""
    for place, rows in enumerate(() if scene.frames else scene.places):
        ranks = scene.ranks[place]
        for length in range(SIDE, LONGEST + 1):
            begins = np.arange(SIDE, len(ranks) - length - SIDE + 1)[:, None]
            begins = begins[:: 1 + len(begins) // MOST_CUTS]
            runs = (ranks >= begins) & (ranks < begins + length)
            is_told = _partly(runs, scene.sockets[rows])
            firsts = begins[is_told, 0].tolist()
            if firsts:
                columns = runs[is_told][:, :, None, None] * np.eye(3)
                samples = [scene.sample(place, first) for first in firsts]
                yield of_samples(
                    rows,
                    columns,
                    [{**sample, "samples": length} for sample in samples],
                    TIPS,
                )


def drifting(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved slowly over a placement."""
    for place, rows in enumerate(scene.places):
        ranks = scene.ranks[place]
        course = ranks / max(ranks.max(), 1) - 0.5
        columns = course[:, None, None] * np.eye(3)
        yield of_samples(
            rows,
            columns,
            [scene.named(place)],
            DRIFTS,
        )


def drift_by(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
) -> Parameters:
    """Return how far a base drifted, and where to, from the first sample to the last."""
    return {"size": float(np.linalg.norm(values)), "shift": values.tolist()}


def moved_by(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
) -> Parameters:
    """Return how far the base moved; a large move by a socket's samples."""
    size = float(np.linalg.norm(values))
    if size <= FAR or "point" in parameters:
        return {"size": size}
    label = parameters["placement"], parameters["socket"]
    in_seat = scene.sockets == scene.labels.index(label)
    balls = scene.seats[in_seat]
    after = scene.numbers[in_seat] >= parameters["sample"]
    # in a socket that was entered after the move, none tells how far
    if not after.all():
        shift = balls[after].mean(axis=0) - balls[~after].mean(axis=0)
        size = float(np.linalg.norm(shift))
    return {"size": size}


def _length_by_length(
    scene: Scene,
    *,
    on_base: bool,
) -> Iterator[tuple[int, Parameters]]:
    """Yield the known distances of one kind: their row, and their names and lengths."""
    lengths = zip(scene.known, scene.expected.tolist(), strict=True)
    for row, (length, expected) in enumerate(lengths, scene.all_lengths.start):
        if length.on_base != on_base:
            continue
        placement, socket = scene.labels[length.first]
        names = {"expected": expected, "given": length.distance}
        if on_base:
            yield row, {"placement": placement, **names}
        else:
            other, socket_beside = scene.labels[length.second]
            ends = f"{placement}:{socket}-{other}:{socket_beside}"
            yield row, {"known": f"{ends}={length.distance}", **names}


def _of_length(
    row: int,
    change: float,
    names: Parameters,
    **more: Any,
) -> Block:
    """Return the block of one known distance that is off by an unknown, or a known change."""
    column = np.full((1, 1, 1), DISTANCE_WEIGHT * change)
    return Block(
        slice(row, row + 1),
        column,
        [names],
        **more,
    )


def between(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved while the ball changed its socket."""
    for row, names in _length_by_length(scene, on_base=True):
        measured = scene.measured(names["placement"])
        sourced = {**names, "source": SOURCES[measured.distance_source]}
        yield _of_length(row, 1.0, sourced, widths=MOVES)


NEAR = 0.1
"""Part of their distance by which sockets may be one [1]."""


def of_one_socket(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements whose ball was in one socket throughout: each, or all."""
    lengths = list(_length_by_length(scene, on_base=True))
    for row, names in lengths:
        yield _of_length(row, -names["given"], names, fixed=True)
    if len(lengths) > 1 and all(n["expected"] < NEAR * n["given"] for _, n in lengths):
        changes = np.array(
            [-length.distance * length.on_base for length in scene.known]
        )
        columns = DISTANCE_WEIGHT * changes[None, :, None]
        size = {key: lengths[0][1][key] for key in ("expected", "given")}
        yield Block(scene.all_lengths, columns, [size], fixed=True)


def of_known(scene: Scene) -> Iterable[Block]:
    """Return blocks of known distances beside those of bases, each of which may be wrong."""
    for row, names in _length_by_length(scene, on_base=False):
        yield _of_length(row, 1.0, names, widths=KNOWN)


def of_distance(scene: Scene) -> Iterable[Block]:
    """Return blocks of a share by which all distances of bases are too long, or all points."""
    columns = _of_bases(scene)
    if columns.any():
        yield Block(
            scene.all_lengths,
            -columns[None, :, None],
            [{}],
            SHARES,
        )
    for k in scene.frames:
        name, _ = scene.labels[k]
        in_frame = scene.sockets == k
        shifts = -scene.offsets * in_frame[:, None]
        names = {"frame": name}
        yield Block(
            scene.all_samples,
            shifts.reshape(1, -1, 1),
            [names],
            OF_INSTRUMENTS,
        )


def of_model(scene: Scene) -> Iterable[Block]:
    """Return the block of one share by which all lengths of the model are too short."""
    columns = np.append(scene.offsets, _of_bases(scene))
    if not columns.any():
        return
    rows = scene.all_lengths
    if scene.frames:
        rows = slice(0, rows.stop)
    yield Block(
        rows,
        -columns[None, rows, None],
        [{}],
        SHARES,
    )


def _of_bases(scene: Scene) -> np.ndarray:
    """Return the changes of all distances for each share that those of bases are too long, (K,)."""
    return (
        DISTANCE_WEIGHT
        * scene.expected
        * np.array([length.on_base for length in scene.known])
    )


def share(
    scene: Scene,
    parameters: Parameters,
    values: np.ndarray,
) -> Parameters:
    """Return the share, and how far apart the sockets would be."""
    value = float(values[0])
    lengths = [length.distance for length in scene.known if length.on_base]
    if "frame" in parameters or not lengths or not lengths[0]:
        return {"share": value / max(1 - value, 0.1)}
    first = next(m for m in scene.measurements if m.has_distance)
    return {
        **sockets_by_share(value, lengths[0]),
        "source": SOURCES[first.distance_source],
    }


def sockets_by_share(
    excess: float,
    length: float,
) -> Parameters:
    """Return how far apart sockets are that would make the arm no longer by a share [m]."""
    return {
        "share": excess,
        "given": length,
        "likely": length / max(1 + excess, 0.1),
    }

"""The base: moved from a sample on or at the change of socket, drifting; or its distance is wrong.

No recording tells a model that is scaled as a whole from a wrong distance: their evidence is one.
"""

from collections.abc import Iterable
from itertools import product

import numpy as np

from ...robot import cross_matrices
from .kinds import Block, Parameters
from .nuisances import DISTANCE_WEIGHT
from .scene import Scene

SIDE, MOST_CUTS = 2, 100
"""Samples needed on each side of a change, and changes tried in a placement."""
MOVES, DRIFTS = (1e-3, 1e-2, 0.2), (5e-4, 5e-3)
"""Typical sizes [m]."""
TURNS = (0.01, 0.1)
"""Typical turns of a base [rad]."""
FAR = 0.03
"""A larger move is not linear beside the distance of the sockets [m]."""
SHARES = (0.01, 0.1, 1.0, 10.0)
"""Typical shares by which a distance is wrong."""
SOURCES = {
    "default": "nothing but the default: measure it and pass the reading with --distance",
    "given": "as given: measure it again and pass the reading with --distance",
    "located": "by the sockets' coordinates: measure those again",
    "recording": "as placement.json has it: measure it again, and mend it there",
}


def changes(
    scene: Scene, slopes: np.ndarray, widths: tuple[float, ...], *, throughout: bool = True
) -> Iterable[Block]:
    """Return blocks of what is off from some sample on by k unknowns: slopes of (N, 3, C, k)."""
    for place, rows in enumerate(scene.places):
        times = scene.times[place]
        ranks = np.linspace(SIDE, len(times) - SIDE, min(len(times), MOST_CUTS)).astype(int)
        ranks = np.unique(ranks)
        after = times >= ranks[:, None]
        in_socket = scene.sockets[rows] == np.unique(scene.sockets[rows])[:, None]
        counts: np.ndarray = after.astype(int) @ in_socket.T
        # where whole sockets moved alone, their centres hold that
        partly = np.logical_and(counts != 0, counts != in_socket.sum(axis=1)).any(axis=1)
        ranks, after = ranks[partly], after[partly]
        of_frame = np.isin(scene.sockets, np.unique(scene.sockets[rows]))
        whole_frame = int(of_frame.sum()) == len(times)
        if (throughout and len(scene.places) > 1) or not whole_frame:
            ranks, after = np.append(0, ranks), np.vstack([times >= 0, after])
        if len(ranks):
            C, k = slopes.shape[2:]
            columns = after[:, None, :, None, None] * slopes[rows].transpose(2, 0, 1, 3)
            first = [
                {**scene.first_from(place, rank), "throughout": float(rank == 0)}
                for rank in ranks.tolist()
            ]
            names = [parameter for parameter, _ in product(first, range(C))]
            flat = columns.reshape(len(names), -1, k)
            yield Block(scene.rows(rows), flat, names, widths)


def moved(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases, or instruments, that moved before some sample."""
    slopes = np.tile(np.eye(3), (len(scene.q), 1, 1))
    if scene.frames:
        slopes = np.concatenate([slopes, _turns(scene)], axis=2)
    return changes(scene, slopes[:, :, None, :], MOVES, throughout=False)


def turned(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that turned about their first socket before some sample."""
    slopes = np.zeros((len(scene.q), 3, 1, 1))
    for rows in scene.places:
        seats = scene.centres[scene.sockets[rows]]
        arms = seats - seats[0]
        slopes[rows, :, 0, 0] = np.cross([0.0, 0.0, 1.0], arms)
    return changes(scene, slopes, TURNS, throughout=False)


def _turns(scene: Scene) -> np.ndarray:
    """Return the shifts of points by turns of their frame about their middle, (N, 3, 3).

    A turn by 1 moves a point by 1 m on average; sockets have no turn.
    """
    slopes = np.zeros((len(scene.q), 3, 3))
    for k in scene.frames:
        rows = scene.sockets == k
        offsets: np.ndarray = scene.offsets[rows]
        offsets = offsets - offsets.mean(axis=0)
        size = float(np.mean(offsets**2)) ** 0.5
        slopes[rows] = cross_matrices(offsets) / max(size, 1e-6)
    return slopes


def drifting(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved slowly over a placement."""
    for place, rows in enumerate(scene.places):
        times = scene.times[place]
        columns = (times / max(times.max(), 1) - 0.5)[:, None, None] * np.eye(3)
        yield Block(scene.rows(rows), columns.reshape(1, -1, 3), [scene.named(place)], DRIFTS)


def drift_by(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how far a base drifted, and where to, from the first sample to the last."""
    return {"size": float(np.linalg.norm(values)), "shift": values.tolist()}


def moved_by(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return how far the base moved; a large move by a socket's samples."""
    size = float(np.linalg.norm(values))
    if size > FAR and "point" not in parameters:
        in_seat = scene.sockets == scene.labels.index(
            (parameters["placement"], parameters["socket"])
        )
        balls, after = scene.seats[in_seat], scene.numbers[in_seat] >= parameters["sample"]
        if not after.all():  # in a socket that was entered after the move, none tells how far
            size = float(np.linalg.norm(balls[after].mean(axis=0) - balls[~after].mean(axis=0)))
    return {"size": size}


def _of_lengths(scene: Scene, *, on_base: bool) -> Iterable[tuple[slice, float, Parameters]]:
    """Return known distances of one kind: the row, the distance, and its names and lengths."""
    first = 3 * len(scene.q)
    for i, ruler in enumerate(scene.known):
        if ruler.on_base == on_base:
            a = scene.labels[ruler.first]
            b = scene.labels[ruler.second]
            ends = f"{a[0]}:{a[1]}-{b[0]}:{b[1]}={ruler.distance}"
            name = {"placement": a[0]} if on_base else {"known": ends}
            lengths = {"expected": scene.expected[i], "given": ruler.distance}
            yield slice(first + i, first + i + 1), ruler.distance, {**name, **lengths}


def between(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved while the ball changed its socket."""
    for rows, _, names in _of_lengths(scene, on_base=True):
        source = SOURCES[scene.measured(names["placement"]).distance_source]
        column = np.full((1, 1, 1), DISTANCE_WEIGHT)
        yield Block(rows, column, [{**names, "source": source}], MOVES)


def of_one_socket(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements whose ball was in one socket throughout."""
    for rows, distance, names in _of_lengths(scene, on_base=True):
        yield Block(rows, np.full((1, 1, 1), -DISTANCE_WEIGHT * distance), [names], fixed=True)


def of_known(scene: Scene) -> Iterable[Block]:
    """Return blocks of known distances beside those of bases, each of which may be wrong."""
    for rows, _, names in _of_lengths(scene, on_base=False):
        yield Block(rows, np.full((1, 1, 1), DISTANCE_WEIGHT), [names], (1e-3, 0.1))


def of_distance(scene: Scene) -> Iterable[Block]:
    """Return blocks of a share by which all distances of bases are too long, or all points."""
    first = 3 * len(scene.q)
    columns = _of_bases(scene)
    if columns.any():
        yield Block(slice(first, first + len(columns)), -columns[None, :, None], [{}], SHARES)
    for k in scene.frames:
        in_frame = scene.sockets == k
        column = -(scene.offsets * in_frame[:, None]).reshape(1, -1, 1)
        frame = {"frame": scene.labels[k][0]}
        yield Block(scene.all_samples, column, [frame], SHARES)


def of_model(scene: Scene) -> Iterable[Block]:
    """Return the block of one share by which all lengths of the model are too short."""
    columns = np.append(scene.offsets.ravel(), _of_bases(scene))
    if columns.any():
        first = 0 if scene.frames else 3 * len(scene.q)
        rows = slice(first, len(columns))
        yield Block(rows, -columns[None, first:, None], [{}], SHARES)


def _of_bases(scene: Scene) -> np.ndarray:
    """Return the changes of all distances for each share that those of bases are too long, (K,)."""
    pairs = zip(scene.expected, scene.known, strict=True)
    return np.array([DISTANCE_WEIGHT * length * ruler.on_base for length, ruler in pairs])


def share(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the share, and how far apart the sockets would be."""
    value = float(values[0])
    length = next((k.distance for k in scene.known if k.on_base), 0.0)
    if "frame" in parameters or not length:
        return {"share": value / max(1 - value, 0.1)}
    likely = length / max(1 + value, 0.1)
    source = SOURCES[next(m for m in scene.measurements if m.has_distance).distance_source]
    return {"share": value, "given": length, "likely": likely, "source": source}

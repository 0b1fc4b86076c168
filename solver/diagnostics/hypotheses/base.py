"""The base: moved from a sample on, at the change of socket, or drifting while recorded."""

from collections.abc import Iterable, Iterator

import numpy as np

from .distance import source_of
from .kinds import Block, Kind, Parameters
from .scene import DISTANCE_WEIGHT, Scene

SIDE, MOST_CUTS = 2, 100
"""Samples needed on each side of a change, and changes tried in a placement."""
MOVES, DRIFTS = (1e-3, 1e-2, 0.2), (5e-4, 5e-3)
"""Typical sizes [m]."""
FAR = 0.03
"""A larger move is not linear beside the distance of the sockets [m]."""


def cuts(scene: Scene, place: int) -> Iterator[tuple[int, np.ndarray]]:
    """Return ranks in time at which something may change, each with the mask of rows from it on."""
    times = scene.times[place]
    ranks = np.unique(np.linspace(SIDE, len(times) - SIDE, min(len(times), MOST_CUTS)).astype(int))
    for rank in ranks.tolist():
        mask = times >= rank
        parts = scene.sockets[scene.places[place]] - scene.sockets[scene.places[place].start]
        after = np.bincount(parts, mask)
        if np.all((after == 0) | (after == np.bincount(parts))):
            continue  # all of a socket moved: its centre holds that
        yield rank, mask


def moved(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved before some sample."""
    for place, rows in enumerate(scene.places):
        found = list(cuts(scene, place))
        if found:
            masks = np.array([mask for _, mask in found], dtype=float)
            columns = masks[:, :, None, None] * np.eye(3)
            names = [scene.first_from(place, rank) for rank, _ in found]
            yield Block(scene.rows(rows), columns.reshape(len(found), -1, 3), names, MOVES)


def between(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved while the ball changed its socket."""
    first = 3 * len(scene.q)
    for i, ruler in enumerate(scene.rulers):
        if ruler.on_base:
            rows = slice(first + i, first + i + 1)
            name = scene.labels[ruler.first][0]
            parameters = {
                "placement": name,
                "expected": scene.expected[i],
                "given": ruler.distance,
                "source": source_of(scene, name),
            }
            yield Block(rows, np.full((1, 1, 1), DISTANCE_WEIGHT), [parameters], MOVES)


def drifting(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved slowly over a placement."""
    for place, rows in enumerate(scene.places):
        times = scene.times[place]
        columns = (times / max(times.max(), 1) - 0.5)[:, None, None] * np.eye(3)
        names = [{"placement": scene.measurements[place].name}]
        yield Block(scene.rows(rows), columns.reshape(1, -1, 3), names, DRIFTS)


def moved_by(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the parameters with how far the base moved; a large move by the samples alone."""
    size = float(np.linalg.norm(values))
    if size > FAR:
        own = scene.sockets == scene.labels.index((parameters["placement"], parameters["socket"]))
        balls, after = scene.linear[0][own], scene.numbers[own] >= parameters["sample"]
        size = float(np.linalg.norm(balls[after].mean(axis=0) - balls[~after].mean(axis=0)))
    return {**parameters, "size": size}


def _moved(p: Parameters) -> str:
    return (
        f"the base moved by {1e3 * p['size']:.1f} mm before sample {p['sample'] + 1} of "
        f"socket {p['socket']}"
    )


def _between(p: Parameters) -> str:
    return (
        f"its sockets are {1e3 * p['expected']:.1f} mm apart by the model and the other "
        f"recordings, not {1e3 * p['given']:.1f}: the base moved, or a file is another's"
    )


BASE_MOVED = Kind(
    "base_moved",
    0.06,
    _moved,
    "record it again, or keep both parts by --split-moved",
    "look whether the base sits tight, and record its sockets in turn, 0 1 0 1",
    code="moved",
    blocks=moved,
    values=moved_by,
)
BASE_BETWEEN = Kind(
    "base_between",
    0.03,
    _between,
    "record it again; or its distance is wrong, which is {source}",
    "measure the distance of its sockets again",
    code="distance",
    blocks=between,
)
DRIFT = Kind(
    "drift",
    0.03,
    lambda p: f"the base drifted by {1e3 * p['size']:.2f} mm while it was recorded",
    "fix the base, let the arm warm up, and record it again, its sockets in turn, 0 1 0 1",
    "record its sockets in turn, 0 1 0 1",
    blocks=drifting,
)

"""The base: moved from a sample on, at the change of socket, or drifting while recorded."""

from collections.abc import Iterable

import numpy as np

from .distance import source_of
from .kinds import Block, Kind, Parameters, sample_named
from .scene import DISTANCE_WEIGHT, Scene

SIDE, MOST_CUTS = 2, 100
"""Samples needed on each side of a change, and changes tried in a placement."""
MOVES, DRIFTS = (1e-3, 1e-2, 0.2), (5e-4, 5e-3)
"""Typical sizes [m]."""
FAR = 0.03
"""A larger move is not linear beside the distance of the sockets [m]."""


def changes(
    scene: Scene, slopes: np.ndarray, widths: tuple[float, ...], *, throughout: bool = True
) -> Iterable[Block]:
    """Return blocks of what is off from some sample on by k unknowns: slopes of (N, 3, C, k)."""
    for place, rows in enumerate(scene.places):
        times = scene.times[place]
        ranks = np.linspace(SIDE, len(times) - SIDE, min(len(times), MOST_CUTS)).astype(int)
        ranks = np.unique(ranks)
        after = times >= ranks[:, None]
        own = scene.sockets[rows] == np.unique(scene.sockets[rows])[:, None]
        counts: np.ndarray = after.astype(int) @ own.T
        # where whole sockets moved alone, their centres hold that
        partly = np.logical_and(counts != 0, counts != own.sum(axis=1)).any(axis=1)
        ranks, after = ranks[partly], after[partly]
        if throughout and len(scene.places) > 1:
            ranks, after = np.append(0, ranks), np.vstack([times >= 0, after])
        if len(ranks):
            C, k = slopes.shape[2:]
            columns = slopes[rows].transpose(2, 0, 1, 3).reshape(C, -1, k)
            first = [scene.first_from(place, rank) for rank in ranks.tolist()]
            names = [one for one in first for _ in range(C)]
            yield Block(scene.rows(rows), columns, names, widths, masks=after.astype(float))


def moved(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved before some sample."""
    slopes = np.tile(np.eye(3)[:, None, :], (len(scene.q), 1, 1, 1))
    return changes(scene, slopes, MOVES, throughout=False)


def between(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved while the ball changed its socket."""
    for i, ruler, rows in scene.of_rulers(on_base=True):
        name = scene.labels[ruler.first][0]
        source = source_of(scene, name)
        parameters = {**scene.length(i), "placement": name, "source": source}
        yield Block(rows, np.full((1, 1, 1), DISTANCE_WEIGHT), [parameters], MOVES)


def drifting(scene: Scene) -> Iterable[Block]:
    """Return blocks of bases that moved slowly over a placement."""
    for place, rows in enumerate(scene.places):
        times = scene.times[place]
        columns = (times / max(times.max(), 1) - 0.5)[:, None, None] * np.eye(3)
        names = [{"placement": scene.measurements[place].name}]
        yield Block(scene.rows(rows), columns.reshape(1, -1, 3), names, DRIFTS)


def moved_by(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the parameters with how far the base moved; a large move by a socket's samples."""
    size = float(np.linalg.norm(values))
    if size > FAR:
        own = scene.sockets == scene.labels.index((parameters["placement"], parameters["socket"]))
        balls, after = scene.linear[0][own], scene.numbers[own] >= parameters["sample"]
        if not after.all():  # in a socket that was entered after the move, none tells how far
            size = float(np.linalg.norm(balls[after].mean(axis=0) - balls[~after].mean(axis=0)))
    return {**parameters, "size": size}


def _moved(p: Parameters) -> str:
    return f"the base moved by {1e3 * p['size']:.1f} mm before {sample_named(p)}"


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

"""The ball: not seated, in another socket, bent from a sample on, or loose; all or one placement's.

Samples may lie in another socket than they say, each alone or all that lie there.
"""

from collections.abc import Iterable, Iterator
from math import hypot

import numpy as np

from .base import changes
from .kinds import Block, Parameters, of_samples, sample_named
from .scene import Scene

SEATING = (3e-3, 0.1, 1.0)
"""Typical errors of a ball that is not seated, or was elsewhere [m]."""
BENDS = (1e-3, 1e-2)
"""Typical errors of a ball that is bent [m]."""
LOOSE = 1.2e-3
"""Typical noise of a ball that is loose [m]."""
LOOSE_HERE = (3e-4, 1e-3, 4e-3, 0.05)
"""Noise of a placement beyond that of the others [m]."""
STANDS_OUT = 1.5
"""It is looked at if it leaves so many times as much as the others."""
MOST = 200
"""Samples that it may have for that."""
NEARER = 0.3
"""A sample may lie in another socket if it is nearer to it by this factor."""


def one_sample(scene: Scene) -> Iterable[Block]:
    """Return blocks of samples in which the ball was not in its socket."""
    for place, rows in enumerate(scene.places):
        ranks = scene.ranks[place].tolist()
        every = np.eye(3 * len(ranks)).reshape(-1, len(ranks), 3)
        names = [scene.sample(place, rank) for rank in ranks]
        yield of_samples(
            rows,
            every.swapaxes(0, 1),
            names,
            SEATING,
        )


def bent(scene: Scene) -> Iterable[Block]:
    """Return blocks of balls that sit elsewhere on the flange from a sample on."""
    of_ball = [p.of_ball and p.unit == "m" for p in scene.parameters]
    if not any(of_ball):
        return ()
    columns = scene.by_geometry[:, of_ball]
    return changes(scene, columns.reshape(-1, 3, 1, columns.shape[1]), BENDS)


def scattered_placements(scene: Scene) -> Iterator[tuple[slice, Parameters]]:
    """Yield placements that scatter more than the others: samples, and name."""
    if len(scene.places) < 2:
        return
    squares = scene.remaining**2
    sizes = np.sqrt([squares[rows].mean() for rows in scene.places])
    errors = np.stack([sizes, scene.floors or sizes])
    for place, rows in enumerate(scene.places):
        here = errors[:, place]
        usual = np.median(np.delete(errors, place, axis=1), axis=1)
        few = rows.stop - rows.start <= MOST
        if few and (here > STANDS_OUT * usual).any():
            yield rows, {**scene.named(place), "noise_here": float(here.max())}


def loose_here(
    scene: Scene,
    roots: np.ndarray | None = None,
    widths: tuple[float, ...] = LOOSE_HERE,
) -> Iterable[Block]:
    """Return blocks of placements that scatter more than the others, by each sample's root."""
    if roots is None:
        roots = np.tile(np.eye(3), (len(scene.q), 1, 1))
    for rows, parameters in scattered_placements(scene):
        count = rows.stop - rows.start
        columns = np.einsum("nm,nij->nimj", np.eye(count), roots[rows])
        flat = columns.reshape(1, 3 * count, 3 * count)
        yield of_samples(
            rows,
            flat,
            [parameters],
            widths,
        )


def mixed_up(scene: Scene) -> Iterable[Block]:
    """Return blocks of samples that may lie in other sockets, each alone and all together."""
    nearest, doubtful = nearest_sockets(scene)
    shifts = scene.centres[nearest] - scene.centres[scene.sockets]
    for place, rows in enumerate(scene.places):
        doubts = np.flatnonzero(doubtful[rows])
        if not len(doubts):
            continue
        masks = doubtful[rows][None]
        if len(doubts) > 1:
            each = np.eye(masks.shape[1], dtype=bool)
            masks = np.vstack([masks, each[doubts]])
        names = [_mixed_up(scene, place, mask, nearest) for mask in masks]
        columns = masks[:, :, None] * shifts[rows]
        yield of_samples(
            rows,
            columns[..., None],
            names,
            fixed=True,
        )


def nearest_sockets(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the other socket nearest to each sample, shape (N,), and where it is much nearer."""
    as_recorded = np.arange(len(scene.q)), scene.sockets
    arms = scene.seats[:, None] - scene.centres
    distances = np.linalg.norm(arms, axis=2)
    distances[:, scene.frames] = np.inf
    recorded = np.nan_to_num(distances[as_recorded], posinf=0.0)
    distances[as_recorded] = np.inf
    doubtful = distances.min(axis=1) < NEARER * recorded
    return np.argmin(distances, axis=1), doubtful


def _mixed_up(
    scene: Scene,
    place: int,
    mask: np.ndarray,
    nearest: np.ndarray,
) -> Parameters:
    """Return which rows of a placement, those of a mask, lie in which socket."""
    ranks = scene.ranks[place][mask].tolist()
    first = scene.sample(place, ranks[0])
    last = scene.sample(place, ranks[-1])
    index = scene.places[place].start + np.argmax(mask)
    true = int(nearest[index])
    name, socket = scene.labels[true]
    shift = scene.centres[true] - scene.centres[scene.sockets[index]]
    return {
        **first,
        "last": last["sample"],
        "last_number": last["number"],
        "last_place": last["place"],
        "samples": len(ranks),
        "other": socket,
        "of": "" if name == first["placement"] else name,
        "size": hypot(*shift),
    }


def lie_elsewhere(p: Parameters) -> str:
    """Return in words which samples lie in which socket."""
    socket = f"socket {p['other']}"
    if p["of"]:
        socket = f"{socket} of {p['of']}"
    if p["samples"] == 1:
        return f"{sample_named(p)} lies in {socket}"
    run = p["samples"] == p["last"] - p["sample"] + 1
    words = f"{p['samples']} samples, the first {sample_named(p)},"
    if run and p.get("number"):
        words = f"samples {p['number']} to {p['last_number']}"
    elif run:
        words = f"samples {p['place']} to {p['last_place']} of socket {p['socket']}"
    distance = f"{1e3 * p['size']:.1f} mm from the others"
    return f"{words} lie in {socket}, {distance}"

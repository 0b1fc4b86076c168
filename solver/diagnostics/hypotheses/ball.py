"""The ball: not seated, in another socket, bent from a sample on, or loose; all or one placement's.

Samples may lie in another socket than they say, each alone or all that lie there.
"""

from collections.abc import Iterable, Iterator
from typing import Any

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
"""How many times as much as the others it must leave to be looked at."""
MOST = 200
"""Samples that it may have for that."""
NEARER = 0.3
"""A sample may lie in another socket if it is nearer to it by this factor."""


def one_sample(scene: Scene) -> Iterable[Block]:
    """Return blocks of samples in which the ball was not in its socket."""
    for place, rows in enumerate(scene.places):
        count = rows.stop - rows.start
        identity = np.eye(3 * count)
        every = identity.reshape(3 * count, count, 3)
        columns = every.swapaxes(0, 1)
        names = [scene.sample(place, row) for row in range(count)]
        yield of_samples(rows, columns, names, SEATING)


def bent(scene: Scene) -> Iterable[Block]:
    """Return blocks of balls that sit elsewhere on the flange from a sample on."""
    of_ball: list[int] = []
    for index, parameter in enumerate(scene.parameters):
        if parameter.of_ball and parameter.unit == "m":
            of_ball.append(index)
    if not of_ball:
        return ()
    columns = scene.by_geometry[:, of_ball]
    slopes = columns.reshape(-1, 3, 1, len(of_ball))
    return changes(scene, slopes, BENDS)


def scattered_placements(scene: Scene) -> Iterator[tuple[slice, Parameters]]:
    """Yield placements that scatter more than the others: samples, and name."""
    if len(scene.places) < 2:
        return
    squares = scene.remaining**2
    variances = [squares[rows].mean() for rows in scene.places]
    sizes = np.sqrt(variances)
    floors = np.array(scene.floors or sizes)
    errors = np.stack([sizes, floors])
    for place, rows in enumerate(scene.places):
        here = errors[:, place]
        others = np.delete(errors, place, axis=1)
        usual = np.median(others, axis=1)
        few = rows.stop - rows.start <= MOST
        large = here > STANDS_OUT * usual
        if few and large.any():
            names: dict[str, Any] = scene.named(place)
            names["noise_here"] = float(here.max())
            yield rows, names


def loose_here(
    scene: Scene,
    roots: np.ndarray | None = None,
    widths: tuple[float, ...] = LOOSE_HERE,
) -> Iterable[Block]:
    """Return blocks of placements that scatter more than the others, by each sample's root."""
    if roots is None:
        samples = len(scene.q)
        roots = np.tile(np.eye(3), (samples, 1, 1))
    for rows, parameters in scattered_placements(scene):
        count = rows.stop - rows.start
        each = np.eye(count)
        columns = np.einsum("nm,nij->nimj", each, roots[rows])
        flat = columns.reshape(1, 3 * count, 3 * count)
        yield of_samples(rows, flat, [parameters], widths)


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
            count = rows.stop - rows.start
            each = np.eye(count, dtype=bool)
            masks = np.vstack([masks, each[doubts]])
        names: list[Parameters] = []
        for mask in masks:
            moved = np.flatnonzero(mask)
            names.append(_mixed_up(scene, place, moved, nearest))
        columns = masks[:, :, None] * shifts[rows]
        yield of_samples(rows, columns[..., None], names, fixed=True)


def nearest_sockets(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the other socket nearest to each sample, shape (N,), and where it is much nearer."""
    every = np.arange(len(scene.q))
    arms = scene.seats[:, None] - scene.centres
    distances = np.linalg.norm(arms, axis=2)
    distances[:, scene.frames] = np.inf
    recorded = distances[every, scene.sockets]
    recorded = np.nan_to_num(recorded, posinf=0.0)
    distances[every, scene.sockets] = np.inf
    nearest = np.argmin(distances, axis=1)
    doubtful = distances.min(axis=1) < NEARER * recorded
    return nearest, doubtful


def _mixed_up(
    scene: Scene,
    place: int,
    rows: np.ndarray,
    nearest: np.ndarray,
) -> Parameters:
    """Return which rows of a placement lie in which socket."""
    first = scene.sample(place, int(rows[0]))
    last = scene.sample(place, int(rows[-1]))
    index = scene.places[place].start + rows[0]
    true = int(nearest[index])
    recorded = scene.sockets[index]
    name, socket = scene.labels[true]
    shift = scene.centres[true] - scene.centres[recorded]
    return {
        **first,
        "last": last["sample"],
        "last_number": last["number"],
        "last_place": last["place"],
        "samples": len(rows),
        "other": socket,
        "of": "" if name == first["placement"] else name,
        "size": float(np.linalg.norm(shift)),
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

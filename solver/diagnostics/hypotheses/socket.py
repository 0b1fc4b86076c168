"""Samples in another socket than they say: one, or all that lie in another."""

from collections.abc import Iterable

import numpy as np

from .kinds import Block, Kind, Parameters, sample_named
from .scene import Scene

NEARER = 0.3
"""A sample may lie in another socket if it is nearer to it by this factor."""


def mixed_up(scene: Scene) -> Iterable[Block]:
    """Return blocks of samples that may lie in other sockets, each alone and all together."""
    balls = scene.linear[0]
    away = np.linalg.norm(balls[:, None] - scene.centres[None], axis=2)
    own = away[np.arange(len(balls)), scene.sockets].copy()
    away[np.arange(len(balls)), scene.sockets] = np.inf
    nearest = np.argmin(away, axis=1)
    doubtful = away.min(axis=1) < NEARER * own
    by = (scene.centres[nearest] - scene.centres[scene.sockets]) * doubtful[:, None]
    for place, rows in enumerate(scene.places):
        there = np.flatnonzero(doubtful[rows])
        if not len(there):
            continue
        shift, count = by[rows], rows.stop - rows.start
        single = np.eye(count, dtype=bool)[there if len(there) > 1 else []]
        masks: np.ndarray = np.vstack([doubtful[rows][None], single])
        names = [_named(scene, place, np.flatnonzero(mask), nearest) for mask in masks]
        shifts = (masks[:, :, None] * shift).reshape(len(masks), -1)
        nothing = np.zeros((len(masks), 3 * count, 0))
        yield Block(scene.rows(rows), nothing, names, shift=shifts)


def _named(scene: Scene, place: int, rows: np.ndarray, nearest: np.ndarray) -> dict[str, object]:
    first, last = scene.sample(place, int(rows[0])), scene.sample(place, int(rows[-1]))
    at = int(nearest[scene.places[place].start + rows[0]])
    name, other = scene.labels[at]
    of = scene.measurements[place].name
    return {
        "placement": of,
        **first,
        "last": last["sample"],
        "last_number": last["number"],
        "samples": len(rows),
        "other": other,
        "of": "" if name == of else name,
        "size": float(
            np.linalg.norm(
                scene.centres[at] - scene.centres[scene.labels.index((of, first["socket"]))]
            )
        ),
    }


def _text(p: Parameters) -> str:
    of = f" of {p['of']}" if p["of"] else ""
    away = f"{1e3 * p['size']:.1f} mm from the others"
    if p["samples"] == 1:
        return f"{sample_named(p)} lies in socket {p['other']}{of}"
    run = p["samples"] == p["last"] - p["sample"] + 1
    if run and p.get("number"):
        words = f"samples {p['number']} to {p['last_number']} lie"
    elif run:
        words = f"samples {p['sample'] + 1} to {p['last'] + 1} of socket {p['socket']} lie"
    else:
        words = f"{p['samples']} samples, the first {sample_named(p)}, lie"
    return f"{words} in socket {p['other']}{of}, {away}"


SOCKET = Kind(
    "socket",
    0.06,
    _text,
    "a wrong socket number: mend it, or delete them; if the base stood there, move them",
    "look at the socket numbers of these samples",
    code="mislabelled",
    blocks=mixed_up,
)

"""The ball: not seated in one sample, bent from a sample on, or loose in all."""

from collections.abc import Iterable, Iterator

import numpy as np

from .base import changes
from .kinds import Block, Kind, NoisePrior, Parameters, sample_named
from .scene import Scene

LOOSE = 1.2e-3
"""Typical noise of a ball that is loose [m]."""
LOOSE_HERE, STANDS_OUT, MOST = (3e-4, 1e-3, 4e-3, 0.05), 1.5, 200
"""Noise of a placement beyond that of the others [m]; how much it must leave, beside theirs, to be
looked at; and the samples that it may have for that."""


def one_sample(scene: Scene) -> Iterable[Block]:
    """Return blocks of samples in which the ball was not in its socket."""
    for place, rows in enumerate(scene.places):
        count = rows.stop - rows.start
        columns = np.eye(3 * count).reshape(count, 3, 3 * count).transpose(0, 2, 1)
        names = [
            {"placement": scene.measurements[place].name, **scene.sample(place, row)}
            for row in range(count)
        ]
        yield Block(scene.rows(rows), columns, names, (3e-3, 0.1))


def bent(scene: Scene) -> Iterable[Block]:
    """Return blocks of balls that sit elsewhere on the flange from a sample on."""
    of_ball = [i for i, p in enumerate(scene.parameters) if p.of_ball and p.unit == "m"]
    slopes = scene.by_geometry[:, of_ball].reshape(len(scene.q), 3, 1, -1)
    return changes(scene, slopes, (1e-3, 1e-2)) if of_ball else ()


def standing_out(scene: Scene) -> Iterator[tuple[slice, Parameters]]:
    """Return placements that scatter more than the others: samples, and name."""
    left = [float(np.mean(scene.remaining[rows] ** 2)) ** 0.5 for rows in scene.places]
    for place, rows in enumerate(scene.places):
        apart = [
            sizes[place] > STANDS_OUT * float(np.median([*sizes[:place], *sizes[place + 1 :]]))
            for sizes in (left, list(scene.floors))
            if len(sizes) > 1
        ]
        if any(apart) and rows.stop - rows.start <= MOST:
            here = max(left[place], scene.floors[place])
            yield rows, {"placement": scene.measurements[place].name, "noise_here": here}


def loose_here(
    scene: Scene, roots: np.ndarray | None = None, widths: tuple[float, ...] = LOOSE_HERE
) -> Iterable[Block]:
    """Return blocks of placements that scatter more than the others, by each sample's root."""
    for rows, parameters in standing_out(scene):
        count = rows.stop - rows.start
        own = np.eye(3)[None] if roots is None else roots[rows]
        columns = np.zeros((count, 3, count, 3))
        columns[np.arange(count), :, np.arange(count)] = own
        flat = columns.reshape(1, 3 * count, 3 * count)
        yield Block(scene.rows(rows), flat, [parameters], widths)


def _noise(p: Parameters) -> str:
    return f"all samples scatter by {1e3 * p['noise']:.2f} mm: the ball or its base is loose"


def _one(p: Parameters) -> str:
    return (
        f"{1e3 * p['size']:.1f} mm from socket {p['socket']} in sample "
        f"{p.get('number') or p['sample'] + 1}: the ball was not seated"
    )


BALL_SAMPLE = Kind(
    "ball_sample",
    0.1,
    _one,
    "was the ball seated? It hardly counts; delete it if it was not",
    "record that sample again",
    code="far",
    blocks=one_sample,
    several=True,
)
BALL_BENT = Kind(
    "ball_bent",
    0.03,
    lambda p: (
        f"the ball sits {1e3 * p['size']:.1f} mm elsewhere on its flange from {sample_named(p)} on"
    ),
    "tighten or straighten its stem, and record it again",
    "look whether the ball's stem is tight and straight",
    blocks=bent,
)
BALL_LOOSE_HERE = Kind(
    "ball_loose",
    0.03,
    lambda p: (
        f"fitted with the others its samples scatter by {1e3 * p['noise_here']:.2f} mm, theirs "
        f"by {1e3 * p['noise']:.2f} mm: no model explains it as well"
    ),
    "tighten ball, sockets and base, and record it again, or leave it out",
    "push the ball about in its socket by hand",
    code="floor",
    blocks=loose_here,
)
BALL_LOOSE = Kind(
    "ball_loose",
    0.04,
    _noise,
    "tighten ball, sockets and base, and record it again",
    "push the ball about in its socket by hand",
    noise=lambda scene: NoisePrior(LOOSE, 0.7, below=False),
    level="warning",
)

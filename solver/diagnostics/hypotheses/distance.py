"""The distance of the sockets is not what it was said to be; or the whole model is scaled."""

from collections.abc import Iterable

import numpy as np

from .kinds import Block, Kind, Parameters
from .scene import DISTANCE_WEIGHT, Scene

SHARES = (0.01, 0.1, 1.0, 10.0)
"""Typical shares by which a distance is wrong."""
SOURCES = {
    "default": "nothing but the default: measure it, and give what you read by --distance MEASURED",
    "given": "as given: measure it again, and give what you read by --distance MEASURED",
    "located": "by the sockets' coordinates: measure those again",
    "recording": "as placement.json has it: measure it again, and mend it there",
}


def of_distance(scene: Scene) -> Iterable[Block]:
    """Return the block of one share by which all distances of bases are too long."""
    first = 3 * len(scene.q)
    columns = np.array(
        [DISTANCE_WEIGHT * e * k.on_base for e, k in zip(scene.expected, scene.rulers, strict=True)]
    )
    if columns.any():
        rows = slice(first, first + len(columns))
        yield Block(rows, -columns[None, :, None], [{}], SHARES)


def source_of(scene: Scene, placement: str) -> str:
    """Return in words where the distance of a placement's sockets is from."""
    (measured,) = [m for m in scene.measurements if m.name == placement]
    return SOURCES[measured.distance_source]


def of_one_socket(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements whose ball was in one socket throughout."""
    for i, ruler, rows in scene.of_rulers(on_base=True):
        shift = np.full((1, 1), -DISTANCE_WEIGHT * ruler.distance)
        names = {"placement": scene.labels[ruler.first][0], **scene.length(i)}
        yield Block(rows, np.zeros((1, 1, 0)), [names], shift=shift)


def of_known(scene: Scene) -> Iterable[Block]:
    """Return blocks of known distances beside those of bases, each of which may be wrong."""
    for i, ruler, rows in scene.of_rulers(on_base=False):
        ends = "-".join(
            f"{n}:{k}" for n, k in (scene.labels[ruler.first], scene.labels[ruler.second])
        )
        names = {"known": f"{ends}={ruler.distance}", **scene.length(i)}
        yield Block(rows, np.full((1, 1, 1), DISTANCE_WEIGHT), [names], (1e-3, 0.1))


def share(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the parameters with the share, and how far apart the sockets would be."""
    given = next(k.distance for k in scene.rulers if k.on_base)
    value = float(values[0])
    likely = given / max(1 + value, 0.1)
    source = source_of(scene, next(m.name for m in scene.measurements if m.has_distance))
    return {**parameters, "share": value, "given": given, "likely": likely, "source": source}


def _distance(p: Parameters) -> str:
    longer = "longer" if p["share"] > 0 else "shorter"
    return (
        f"the arm comes out {100 * abs(p['share']):.1f} % {longer} than its model; more likely "
        f"the sockets are {1e3 * p['likely']:.1f} mm apart than {1e3 * p['given']:.1f}"
    )


DISTANCE = Kind(
    "distance",
    0.1,
    _distance,
    "that distance is {source}",
    "measure the distance of the sockets again",
    code="scale",
    blocks=of_distance,
    values=share,
)
# No recording tells a model that is scaled as a whole from a wrong distance: the evidence is one.
SCALED = Kind(
    "scaled",
    0.01,
    lambda p: (
        f"all lengths of the model are {100 * abs(p['share']):.1f} % too "
        f"{'short' if p['share'] > 0 else 'long'}"
    ),
    "compare the URDF's lengths with the maker's drawing",
    "compare one length of the URDF with the maker's drawing",
    blocks=of_distance,
    values=share,
)
ONE_SOCKET = Kind(
    "one_socket",
    0.02,
    lambda p: (
        f"its sockets lie at the same place, {1e3 * p['expected']:.1f} mm apart, not "
        f"{1e3 * p['given']:.1f}"
    ),
    "all was recorded with the ball in one socket: record the other",
    "look in which sockets the ball was",
    code="one-socket",
    blocks=of_one_socket,
)
KNOWN = Kind(
    "known",
    0.02,
    lambda p: f"these sockets are {1e3 * p['expected']:.1f} mm apart by the model",
    "measure it again, or give the sockets that were meant",
    "measure that distance again",
    blocks=of_known,
)

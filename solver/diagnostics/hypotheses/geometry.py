"""The model: one length or angle of the URDF wrong, another version's, or another arm's samples."""

from collections.abc import Iterable

import numpy as np

from .kinds import Block, Kind, Parameters
from .scene import Scene

LENGTHS, ANGLES = (5e-3, 0.03), (0.03, 0.15)
"""Typical errors of one number of a URDF [m], [rad]."""
VERSION = 10.0
"""Another version's model is off by so many times as much as an arm from its own."""


def _one(scene: Scene, unit: str, widths: tuple[float, ...]) -> Iterable[Block]:
    if scene.zeros:
        return  # play and zeros of degrees look like any number that is wrong
    chosen = [i for i, p in enumerate(scene.parameters) if p.unit == unit and not p.of_ball]
    names = [
        {"joint": scene.parameters[i].joint, "component": scene.parameters[i].component}
        for i in chosen
    ]
    columns = scene.by_geometry[:, chosen].T[:, :, None]
    yield Block(scene.all_samples, columns, names, widths)


def of_version(scene: Scene) -> Iterable[Block]:
    """Return the block of a model all of whose numbers are wrong."""
    if scene.zeros:
        return
    of_links = VERSION * ~np.array([p.of_ball for p in scene.parameters])
    yield Block(scene.all_samples, (scene.by_geometry * of_links @ scene.usual)[None], [{}])


def of_other_arm(scene: Scene) -> Iterable[Block]:
    """Return blocks of placements that another arm of the type recorded."""
    for place, rows in enumerate(scene.places if len(scene.places) > 1 else ()):
        own = scene.rows(rows)
        names = [{"placement": scene.measurements[place].name}]
        yield Block(own, (scene.by_geometry[own] @ scene.usual)[None], names, (1.4,))


def error(scene: Scene, parameters: Parameters, values: np.ndarray) -> Parameters:
    """Return the parameters with the error of the model's number [m, rad]."""
    return {**parameters, "error": -float(values[0])}


LENGTH = Kind(
    "length",
    0.06,
    lambda p: (
        f"{p['component']} of {p['joint']} in the URDF is {1e3 * abs(p['error']):.1f} mm too "
        f"{'large' if p['error'] > 0 else 'small'}"
    ),
    "compare it with the maker's drawing, or choose the model of this robot's version",
    "measure that length on the arm, or look it up",
    blocks=lambda scene: _one(scene, "m", LENGTHS),
    values=error,
)
ANGLE = Kind(
    "angle",
    0.03,
    lambda p: (
        f"{p['component']} of {p['joint']} in the URDF is "
        f"{np.rad2deg(abs(p['error'])):.1f} deg too {'large' if p['error'] > 0 else 'small'}"
    ),
    "compare it with the maker's drawing, or choose the model of this robot's version",
    "compare that angle with the maker's drawing",
    blocks=lambda scene: _one(scene, "rad", ANGLES),
    values=error,
)
VERSION_WRONG = Kind(
    "version",
    0.02,
    lambda p: "several lengths of the URDF are wrong: it is another version's, or another robot's",
    "is it this robot's model, with the right --base and --tip?",
    "compare the URDF with the maker's drawing of this arm",
    code="model",
    blocks=of_version,
)
OTHER_ARM = Kind(
    "other_arm",
    0.02,
    lambda p: "no arm that recorded the others recorded it as well",
    "leave it out, or calibrate the arm that it belongs to by itself",
    "look which arm recorded it",
    code="floor",
    blocks=of_other_arm,
)

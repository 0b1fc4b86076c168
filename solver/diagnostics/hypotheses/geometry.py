"""The model: one length or angle of the URDF wrong, another version's, or another arm's samples."""

from collections.abc import Iterable
from functools import partial

import numpy as np

from .kinds import Block, Kind, Parameters
from .scene import Scene

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


def _number(name: str, prior: float, unit: str, widths: tuple[float, ...], tell: str) -> Kind:
    """Return the kind of one number of a URDF that is wrong."""

    def text(p: Parameters) -> str:
        size = abs(p["error"])
        amount = f"{1e3 * size:.1f} mm" if unit == "m" else f"{np.rad2deg(size):.1f} deg"
        way = "large" if p["error"] > 0 else "small"
        return f"{p['component']} of {p['joint']} in the URDF is {amount} too {way}"

    advice = "compare it with the maker's drawing, or choose the model of this robot's version"
    blocks = partial(_one, unit=unit, widths=widths)
    return Kind(name, prior, text, advice, tell, blocks=blocks, values=error)


LENGTH = _number("length", 0.06, "m", (5e-3, 0.03), "measure that length on the arm, or look it up")
ANGLE = _number("angle", 0.03, "rad", (0.03, 0.15), "compare that angle with the maker's drawing")
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

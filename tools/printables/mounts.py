"""Mounts that hold the ball's neck at the arm: plates on flanges, blocks between two fingers.

Every mount stands on z = 0 as printed, its axis is z, and the neck grows from its top. Lengths are
millimetres. docs/print.md has the sources of the patterns.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

from .solid import (
    TABLES,
    Point,
    PrintableError,
    Solid,
    check_range,
    cylinder,
    frustum,
    prism,
    rectangle,
    union,
)

PLATE = 8.0
RIM = 1.5  # of the plate around the screws' heads


@dataclass(frozen=True)
class Screw:
    """A hexagon socket head cap screw [mm]."""

    hole: float
    head: float
    """Diameter of the head."""
    height: float
    """Of the head."""
    key: float
    """Width across the flats of its key."""


SCREWS: Mapping[str, Screw] = {
    name: Screw(**it) for name, it in TABLES["screws"].items()
}


@dataclass(frozen=True, kw_only=True)
class Mount:
    """A mount, as neck and checks need it, and the frame in which the ball's place counts."""

    body: Solid
    top: float
    """Height at which the neck begins."""
    widest_root: float
    """Largest diameter of the neck there."""
    widest_ball: float = math.inf
    """Largest diameter of a ball that leaves the way to the screws free."""
    corners: tuple[Point, ...]
    """Radius and height of what must stay above the sockets when the neck leans."""
    hardware: Solid | None = None
    """The screws' heads."""
    lettering: float | None = None
    """Radius of the ring on which the ball's height may be engraved, its outer edge."""
    origin: float = 0.0
    """Height of the frame's origin."""
    reach: float | None = None
    """Height of the ball's centre above that origin; None: as short as the tilt allows."""
    axis: int = 2
    """The axis of the frame that points along the part: 0, 1, 2 for x, y, z."""
    aside: Point = (0.0, 0.0)
    """Position of the part's axis in the frame, along its other two axes."""
    holes: tuple[float, str] | None = None
    """Diameter of their circle, and a drawing's words for them."""
    links: Mapping[str, str] = field(default_factory=dict[str, str])
    """The frame's link in the models of robots."""
    note: str = ""
    """Advice to its user."""


def bolt_circle(
    diameter: float, count: int = 4, screw: str = "M6", slot: float = 0.0, **frame: Any
) -> Mount:
    """Return a plate that is screwed to a flange, its holes evenly around a circle [mm].

    Slots are longer than the holes by ``slot``, outwards, for circles up to twice that larger. The
    frame's origin is in the plate's lower face. Holes that do not fit are a PrintableError.
    """
    if screw not in SCREWS:
        raise PrintableError(f"no screw {screw!r}; there are: {', '.join(SCREWS)}")
    check_range("a bolt circle", diameter, 20, 150)
    if not 2 <= count <= 12:
        raise PrintableError(f"{count} bolts: a bolt circle has 2 to 12")
    size = SCREWS[screw]
    step = math.sin(math.pi / count)
    if diameter * step < size.head + 1:
        raise PrintableError(
            f"{count} {screw} on a circle of {diameter:g} mm: their heads touch; take fewer, "
            f"smaller ones, or a circle of {math.ceil((size.head + 1) / step)} mm or more"
        )
    inner = diameter / 2
    outer = diameter / 2 + slot
    edge = outer + size.head / 2 + RIM
    reach = f" to {2 * outer:g}" if slot else ""

    def holes(radius: float, height: float, z: float) -> Solid:
        """Return the space of all holes or heads; the first is half a step off the x axis."""
        angles = [(i + 0.5) * 2 * math.pi / count for i in range(count)]
        slots = [_slot(angle, inner, outer, radius, height).at(z=z) for angle in angles]
        return union(*slots)

    return Mount(
        body=cylinder(edge, PLATE) - holes(size.hole / 2, PLATE + 2, -1),
        top=PLATE,
        widest_root=diameter - size.head - 1,
        widest_ball=diameter - size.key,
        corners=((edge, PLATE), (outer + size.head / 2, PLATE + size.height)),
        hardware=holes(size.head / 2, size.height, PLATE),
        lettering=inner - size.head / 2 - 0.5,
        holes=(diameter, f"{count} x {size.hole:g} for {screw} on {diameter:g}{reach}"),
        **frame,
    )


def _slot(
    angle: float, inner: float, outer: float, radius: float, height: float
) -> Solid:
    """Return a slot of rounded ends along a direction, between two distances from the z axis."""
    c = math.cos(angle)
    s = math.sin(angle)
    places = [(r * c, r * s) for r in (inner, outer)]
    ends = cylinder(radius, height).at_each(places)
    if inner == outer:
        return ends[0]
    corners = ((inner, -radius), (outer, -radius), (outer, radius), (inner, radius))
    between = tuple((r * c - w * s, r * s + w * c) for r, w in corners)
    return union(*ends, prism(height, between))


def grip(
    width: float,
    depth: float,
    length: float,
    groove: Point = (0.0, 0.0),
    **frame: Any,
) -> Mount:
    """Return a block that two parallel fingers hold, its shoulder resting on their ends [mm].

    The width is between the fingers, along y; the depth along their width, x; the length along
    them. A groove, by its width and depth, holds a finger so that the block cannot turn. Heights
    count from the block's lower end; the frame's origin lies between the fingertips if its fields
    do not say otherwise.
    """
    check_range("a grip's width", width, 8, 60)
    check_range("a grip's depth", depth, 8, 60)
    if depth < width:
        raise PrintableError(
            f"a grip {width:g} mm wide and {depth:g} mm deep: its shoulder needs a DEPTH, the "
            f"second number, of {width:g} mm or more"
        )
    check_range("a grip's length", length, 8, 80)
    block = prism(length, rectangle(_middle(depth), _middle(width), 1.0))
    across, deep = groove
    low = width / 2 - deep
    if deep:
        for side in ((low, width), (-width, -low)):
            outline = rectangle(_middle(across), side)
            block = block - prism(length + 2, outline).at(z=-1)
    # A cone of less than 45 degrees' overhang.
    rim = cylinder(low + 3, 1.5).at(z=3.3)
    shoulder = union(frustum(3.3, low, low + 3), rim)
    start = length - 0.3  # it begins inside the block
    edge = math.hypot(width / 2, depth / 2) - 0.5
    frame.setdefault("origin", length)
    return Mount(
        body=union(block, shoulder.at(z=start)),
        top=start + 4.8,
        widest_root=2 * low + 4,
        corners=((edge, length), (low + 3, start + 4.8)),
        **frame,
    )


def _strap_plate(**frame: Any) -> Mount:
    """Return a plate for two crossed straps, or for glue, where no holes are known."""
    # a slot's length is a strap's width
    radius = 31.0
    long = 22.0
    thick = 4.0
    height = radius - 8
    upright = prism(PLATE + 2, rectangle(_middle(thick), _middle(long)))
    level = prism(PLATE + 2, rectangle(_middle(long), _middle(thick)))
    slots = upright.at_each([(-height, 0), (height, 0)], z=-1)
    slots += level.at_each([(0, -height), (0, height)], z=-1)
    return Mount(
        body=cylinder(radius, PLATE) - union(*slots),
        top=PLATE,
        widest_root=2 * height - thick - 4,
        corners=((radius, PLATE + thick / 2),),
        lettering=height - thick / 2 - 0.5,
        **frame,
    )


def _middle(width: float) -> Point:
    return -width / 2, width / 2


def _shipped(fields: dict[str, Any]) -> Mount:
    """Return a mount of the table: a function of this module with its lengths, then its fields."""
    (kind, lengths), *numbers = fields.items()
    make = {"bolt_circle": bolt_circle, "grip": grip, "strap_plate": _strap_plate}[kind]
    return make(*lengths, **dict(numbers))


MOUNTS: Mapping[str, Mount] = {
    name: _shipped(it) for name, it in TABLES["mounts"].items()
}
"""Mounts by name; a link without a name is for the user to choose."""
_ISO = re.compile(r"iso-(\d+(?:\.\d+)?)-(\d+)-(m\d+)")


def find_mount(name: str) -> Mount:
    """Return a mount by its name, by a shipped robot it is for, or by its code of ISO 9409-1.

    A code is ``iso-63-4-m6`` or ``ISO-9409-1-63-4-M6``: diameter of the bolt circle, screws, their
    thread; what is none of these, or holes that do not fit, is a PrintableError.
    """
    short = name.lower().replace("iso-9409-1-", "iso-")
    if short in MOUNTS:
        return MOUNTS[short]
    for mount in MOUNTS.values():
        if short in mount.links:
            return mount
    if code := _ISO.fullmatch(short):
        return bolt_circle(float(code[1]), int(code[2]), code[3].upper())
    links = [mount.links for mount in MOUNTS.values()]
    robots = sorted(set(chain.from_iterable(links)))
    raise PrintableError(
        f"no mount {name!r}; there are: {', '.join(MOUNTS)}, codes of ISO 9409-1 as iso-63-4-m6, "
        f"none, and by robot: {', '.join(robots)}"
    )

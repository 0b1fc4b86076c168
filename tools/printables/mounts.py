"""Mounts that hold the ball's neck at the arm: plates on flanges, blocks between two fingers.

Every mount stands on z = 0 as printed, its axis is z, and the neck grows from its top. Lengths are
millimetres. docs/print.md has the sources of the patterns.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .solid import Frustum, PrintableError, Prism, Solid, check_range, cylinder, rectangle, union

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
    "M3": Screw(3.4, 5.5, 3.0, 2.5),
    "M4": Screw(4.5, 7.0, 4.0, 3.0),
    "M5": Screw(5.5, 8.5, 5.0, 4.0),
    "M6": Screw(6.6, 10.0, 6.0, 5.0),
    "M8": Screw(9.0, 13.0, 8.0, 6.0),
    "M10": Screw(11.0, 16.0, 10.0, 8.0),
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
    corners: tuple[tuple[float, float], ...]
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
    aside: tuple[float, float] = (0.0, 0.0)
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
    size, step = SCREWS[screw], math.sin(math.pi / count)
    if diameter * step < size.head + 1:
        raise PrintableError(
            f"{count} {screw} on a circle of {diameter:g} mm: their heads touch; take fewer, "
            f"smaller ones, or a circle of {math.ceil((size.head + 1) / step)} mm or more"
        )
    inner, outer = diameter / 2, diameter / 2 + slot
    edge = outer + size.head / 2 + RIM
    reach = f" to {2 * outer:g}" if slot else ""

    def holes(radius: float, height: float, z: float) -> Solid:
        """Return the space of all holes or heads; the first is half a step off the x axis."""
        angles = ((i + 0.5) * 2 * math.pi / count for i in range(count))
        return union(*(_slot(angle, inner, outer, radius, height).at(z=z) for angle in angles))

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


def _slot(angle: float, inner: float, outer: float, radius: float, height: float) -> Solid:
    """Return a slot of rounded ends along a direction, between two distances from the z axis."""
    c, s = math.cos(angle), math.sin(angle)
    ends = [cylinder(radius, height).at(r * c, r * s) for r in (inner, outer)]
    if inner == outer:
        return ends[0]
    corners = ((inner, -radius), (outer, -radius), (outer, radius), (inner, radius))
    between = tuple((r * c - w * s, r * s + w * c) for r, w in corners)
    return union(*ends, Prism((between,), height))


def grip(
    width: float,
    depth: float,
    length: float,
    groove: tuple[float, float] = (0.0, 0.0),
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
    block: Solid = Prism((rectangle(_middle(depth), _middle(width), 1.0),), length)
    across, deep = groove
    low = width / 2 - deep
    if deep:
        for side in ((low, width), (-width, -low)):
            block = block - Prism((rectangle(_middle(across), side),), length + 2).at(z=-1)
    # A cone of less than 45 degrees' overhang.
    shoulder = union(Frustum(3.3, low, low + 3), cylinder(low + 3, 1.5).at(z=3.3))
    start = length - 0.3  # it begins inside the block
    frame.setdefault("origin", length)
    return Mount(
        body=union(block, shoulder.at(z=start)),
        top=start + 4.8,
        widest_root=2 * low + 4,
        corners=((math.hypot(width / 2, depth / 2) - 0.5, length), (low + 3, start + 4.8)),
        **frame,
    )


def _strap_plate(**frame: Any) -> Mount:
    """Return a plate for two crossed straps, or for glue, where no holes are known."""
    radius, long, thick = 31.0, 22.0, 4.0  # a slot's length is a strap's width
    far = radius - 8
    upright = Prism((rectangle(_middle(thick), _middle(long)),), PLATE + 2)
    level = Prism((rectangle(_middle(long), _middle(thick)),), PLATE + 2)
    slots = [upright.at(x, 0, -1) for x in (-far, far)]
    slots += [level.at(0, y, -1) for y in (-far, far)]
    return Mount(
        body=cylinder(radius, PLATE) - union(*slots),
        top=PLATE,
        widest_root=2 * far - thick - 4,
        corners=((radius, PLATE + thick / 2),),
        lettering=far - thick / 2 - 0.5,
        **frame,
    )


def _middle(width: float) -> tuple[float, float]:
    return -width / 2, width / 2


MOUNTS: Mapping[str, Mount] = {
    "franka-hand": grip(
        *(14, 18, 19),
        origin=9.5,
        reach=30,
        links={"panda": "panda_hand_tcp", "fr3": "fr3_hand_tcp"},
        note="the fingertips' rubber gives way as well: franka-flange holds the ball firmer",
    ),
    "franka-flange": bolt_circle(50, links={"panda": "panda_link8", "fr3": "fr3_link8"}),
    "iso-50-4-m6": bolt_circle(
        50,
        links={
            **dict.fromkeys(("ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e"), "tool0"),
            "piper": "link6",
        },
    ),
    "iso-80-6-m8": bolt_circle(80, count=6, screw="M8", links={"ur20": "tool0"}),
    "iiwa14": bolt_circle(
        50,
        count=8,
        links={"iiwa14": "tool0"},
        note="tool0 is the face of the basic flange: on a media flange add its height to z",
    ),
    "xarm": bolt_circle(
        50,
        count=6,
        screw="M5",
        links={"xarm6": "link_eef", "xarm7": "link_eef"},
        note="for xArm 5, 6 and 7; measure the flange of a Lite 6 or an 850",
    ),
    "robotiq-2f-85": grip(22, 22, 35),
    "ufactory-gripper": grip(30, 30, 35),
    "so101": grip(
        *(45, 45, 30),
        origin=23.7,
        groove=(16.6, 2.5),
        aside=(-20, 0),  # the frame lies in the face of the fixed jaw
        links={"so101": "gripper_frame_link"},
        note="hold it by a rubber band round the jaws: without torque the gripper does not",
    ),
    "interbotix": grip(
        *(50, 50, 40),
        axis=0,
        links=dict.fromkeys(("vx300s", "wx250s"), "ee_gripper_link"),
        note="hold it by a rubber band round the fingers: without torque the gripper does not",
    ),
    "gen3-lite": bolt_circle(
        32,
        screw="M5",
        slot=10,
        links={"gen3_lite": "end_effector_link"},
        note="slots for M3 to M5, with washers, on circles of 32 to 52 mm: measure your flange",
    ),
    "strap": _strap_plate(
        links={
            **dict.fromkeys(("lite6", "uf850"), "link_eef"),
            "gen3": "end_effector_link",
            **dict.fromkeys(("so100", "koch", "openarm", "wxai"), ""),
        },
        note="the makers publish no holes that are known here: lash it to flange or gripper by two "
        "straps of 20 mm, or glue it on; z counts from its lower face",
    ),
}
"""Mounts by name; a link without a name is for the user to choose."""
_ISO = re.compile(r"iso-(\d+(?:\.\d+)?)-(\d+)-(m\d+)")


def find_mount(name: str) -> Mount:
    """Return a mount by its name, by a shipped robot it is for, or by its code of ISO 9409-1.

    A code is ``iso-63-4-m6`` or ``ISO-9409-1-63-4-M6``: diameter of the bolt circle, screws, their
    thread; what is none of these, or holes that do not fit, is a PrintableError.
    """
    plain = name.lower().replace("iso-9409-1-", "iso-")
    if plain in MOUNTS:
        return MOUNTS[plain]
    for mount in MOUNTS.values():
        if plain in mount.links:
            return mount
    if code := _ISO.fullmatch(plain):
        return bolt_circle(float(code[1]), int(code[2]), code[3].upper())
    robots = sorted({robot for mount in MOUNTS.values() for robot in mount.links})
    raise PrintableError(
        f"no mount {name!r}; there are: {', '.join(MOUNTS)}, codes of ISO 9409-1 as iso-63-4-m6, "
        f"none, and by robot: {', '.join(robots)}"
    )

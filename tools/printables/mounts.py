"""Mounts that hold the ball's neck at the arm: plates on flanges, blocks between two fingers.

Every mount stands on z = 0 as printed, its axis is z, and the neck grows from its top. Lengths are
millimetres. docs/print.md has the sources of the patterns.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
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
class FlangeFrame:
    """The frame in which the ball's place counts, as a mount has it."""

    origin: float = 0.0
    """Height of its origin."""
    reach: float | None = None
    """Height of the ball's centre above that origin; None: as short as the tilt allows."""
    axis: int = 2
    """The axis of the frame that points along the part: 0, 1, 2 for x, y, z."""
    aside: tuple[float, float] = (0.0, 0.0)
    """Position of the part's axis in the frame, along its other two axes."""
    links: Mapping[str, str] = field(default_factory=dict[str, str])
    """The frame's link in the models of robots."""
    note: str = ""
    """Advice to its user."""

    @property
    def frame(self) -> dict[str, Any]:
        """Fields of the frame, by name."""
        return {one.name: getattr(self, one.name) for one in fields(FlangeFrame)}


@dataclass(frozen=True, kw_only=True)
class Mount(FlangeFrame):
    """A mount, as the neck and the checks need it."""

    body: Solid
    top: float
    """Height at which the neck begins."""
    widest_root: float
    """Largest diameter of the neck there."""
    widest_ball: float
    """Largest diameter of a ball that leaves the way to the screws free."""
    corners: tuple[tuple[float, float], ...]
    """Radius and height of what must stay above the sockets when the neck leans."""
    hardware: Solid | None = None
    """The screws' heads."""
    lettering: float | None = None
    """Radius of the ring on which the ball's height may be engraved, its outer edge."""


@dataclass(frozen=True)
class BoltCircle(FlangeFrame):
    """A plate that is screwed to a flange, holes evenly around a circle.

    Raises:
        PrintableError: The holes do not fit, or no such screw.
    """

    diameter: float
    count: int = 4
    screw: str = "M6"
    slot: float = 0.0
    """Length of the holes beyond their diameter, outwards: for circles up to twice that larger."""

    def __post_init__(self) -> None:
        if self.screw not in SCREWS:
            raise PrintableError(f"no screw {self.screw!r}; there are: {', '.join(SCREWS)}")
        check_range("a bolt circle", self.diameter, 20, 150)
        if not 2 <= self.count <= 12:
            raise PrintableError(f"{self.count} bolts: a bolt circle has 2 to 12")
        apart = self.diameter * math.sin(math.pi / self.count)
        if apart < SCREWS[self.screw].head + 1:
            wide = (SCREWS[self.screw].head + 1) / math.sin(math.pi / self.count)
            raise PrintableError(
                f"{self.count} {self.screw} on a circle of {self.diameter:g} mm: their heads "
                f"touch; take fewer, smaller ones, or a circle of {math.ceil(wide)} mm or more"
            )

    def mount(self) -> Mount:
        """Return the plate; the flange frame's origin is in its lower face."""
        screw = SCREWS[self.screw]
        inner, outer = self.diameter / 2, self.diameter / 2 + self.slot
        edge = outer + screw.head / 2 + RIM
        holes = union(*(self._hole(i, screw.hole / 2, PLATE + 2, -1) for i in range(self.count)))
        return Mount(
            body=cylinder(edge, PLATE) - holes,
            top=PLATE,
            widest_root=self.diameter - screw.head - 1,
            widest_ball=self.diameter - screw.key,
            corners=((edge, PLATE), (outer + screw.head / 2, PLATE + screw.height)),
            hardware=union(
                *(self._hole(i, screw.head / 2, screw.height, PLATE) for i in range(self.count))
            ),
            lettering=inner - screw.head / 2 - 0.5,
            **self.frame,
        )

    def _hole(self, index: int, radius: float, height: float, z: float) -> Solid:
        """Return the space of one hole, slot or head; the first lies half a step off the x axis."""
        angle = (index + 0.5) * 2 * math.pi / self.count
        c, s = math.cos(angle), math.sin(angle)
        inner, outer = self.diameter / 2, self.diameter / 2 + self.slot
        ends = [cylinder(radius, height).at(r * c, r * s, z) for r in (inner, outer)]
        if self.slot == 0:
            return ends[0]
        corners = ((inner, -radius), (outer, -radius), (outer, radius), (inner, radius))
        between = tuple((r * c - w * s, r * s + w * c) for r, w in corners)
        return union(*ends, Prism((between,), height).at(z=z))


@dataclass(frozen=True)
class Grip(FlangeFrame):
    """A block that two parallel fingers hold, its shoulder resting on their ends.

    Heights count from its lower end.

    Raises:
        PrintableError: It is too small to hold, or too large.
    """

    width: float
    """Between the fingers, along y."""
    depth: float
    """Along the fingers' width, x."""
    length: float
    """Along the fingers."""
    groove: tuple[float, float] | None = None
    """Width and depth of a groove for each finger, in which the block cannot turn."""

    def __post_init__(self) -> None:
        check_range("a grip's width", self.width, 8, 60)
        check_range("a grip's depth", self.depth, 8, 60)
        if self.depth < self.width:
            raise PrintableError(
                f"a grip {self.width:g} mm wide and {self.depth:g} mm deep: its shoulder needs a "
                f"DEPTH, the second number, of {self.width:g} mm or more"
            )
        check_range("a grip's length", self.length, 8, 80)

    @classmethod
    def of(cls, width: float, depth: float, length: float) -> "Grip":
        """Return the grip for any gripper; the flange frame lies between the fingertips."""
        return cls(width, depth, length, origin=length)

    def mount(self) -> Mount:
        """Return the block with its shoulder, a cone of less than 45 degrees' overhang."""
        block: Solid = Prism(
            (rectangle(_middle(self.depth), _middle(self.width), 1.0),), self.length
        )
        low = self.width / 2
        if self.groove is not None:
            across, deep = self.groove
            floor = low = low - deep
            for side in ((floor, self.width), (-self.width, -floor)):
                cut = Prism((rectangle(_middle(across), side),), self.length + 2)
                block = block - cut.at(z=-1)
        shoulder = union(Frustum(3.3, low, low + 3), cylinder(low + 3, 1.5).at(z=3.3))
        diagonal = math.hypot(self.width / 2, self.depth / 2) - 0.5
        start = self.length - 0.3  # the cone begins inside the block
        return Mount(
            body=union(block, shoulder.at(z=start)),
            top=start + 4.8,
            widest_root=2 * low + 4,
            widest_ball=math.inf,
            corners=((diagonal, self.length), (low + 3, start + 4.8)),
            **self.frame,
        )


@dataclass(frozen=True)
class StrapPlate(FlangeFrame):
    """A plate for two crossed straps, or for glue, where no holes are known."""

    radius: float = 31.0
    slot: tuple[float, float] = (22.0, 4.0)
    """For a strap: its width, and twice its thickness."""

    def mount(self) -> Mount:
        """Return the plate; the flange frame's origin is in its lower face."""
        long, thick = self.slot
        far = self.radius - 8
        upright = Prism((rectangle(_middle(thick), _middle(long)),), PLATE + 2)
        level = Prism((rectangle(_middle(long), _middle(thick)),), PLATE + 2)
        slots = [upright.at(x, 0, -1) for x in (-far, far)]
        slots += [level.at(0, y, -1) for y in (-far, far)]
        return Mount(
            body=cylinder(self.radius, PLATE) - union(*slots),
            top=PLATE,
            widest_root=2 * far - thick - 4,
            widest_ball=math.inf,
            corners=((self.radius, PLATE + thick / 2),),
            lettering=far - thick / 2 - 0.5,
            **self.frame,
        )


def _middle(width: float) -> tuple[float, float]:
    return -width / 2, width / 2


AnyMount = BoltCircle | Grip | StrapPlate
MOUNTS: Mapping[str, AnyMount] = {
    "franka-hand": Grip(
        width=14,
        depth=18,
        length=19,
        origin=9.5,
        reach=30,
        links={"panda": "panda_hand_tcp", "fr3": "fr3_hand_tcp"},
        note="the fingertips' rubber gives way as well: franka-flange holds the ball firmer",
    ),
    "franka-flange": BoltCircle(50, links={"panda": "panda_link8", "fr3": "fr3_link8"}),
    "iso-50-4-m6": BoltCircle(
        50,
        links={
            **dict.fromkeys(("ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e"), "tool0"),
            "piper": "link6",
        },
    ),
    "iso-80-6-m8": BoltCircle(80, count=6, screw="M8", links={"ur20": "tool0"}),
    "iiwa14": BoltCircle(
        50,
        count=8,
        links={"iiwa14": "tool0"},
        note="tool0 is the face of the basic flange: on a media flange add its height to z",
    ),
    "xarm": BoltCircle(
        50,
        count=6,
        screw="M5",
        links={"xarm6": "link_eef", "xarm7": "link_eef"},
        note="for xArm 5, 6 and 7; measure the flange of a Lite 6 or an 850",
    ),
    "so101": Grip(
        width=45,
        depth=45,
        length=30,
        origin=23.7,
        groove=(16.6, 2.5),
        aside=(-20, 0),  # the frame lies in the face of the fixed jaw
        links={"so101": "gripper_frame_link"},
        note="hold it by a rubber band round the jaws: without torque the gripper does not",
    ),
    "interbotix": Grip(
        width=50,
        depth=50,
        length=40,
        origin=40,
        axis=0,
        links=dict.fromkeys(("vx300s", "wx250s"), "ee_gripper_link"),
        note="hold it by a rubber band round the fingers: without torque the gripper does not",
    ),
    "gen3-lite": BoltCircle(
        32,
        screw="M5",
        slot=10,
        links={"gen3_lite": "end_effector_link"},
        note="slots for M3 to M5, with washers, on circles of 32 to 52 mm: measure your flange",
    ),
    "strap": StrapPlate(
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


def find_mount(name: str) -> AnyMount:
    """Return a mount by its name, by a robot whose flange or gripper it is for, or by its code.

    Args:
        name: One of :data:`MOUNTS`, the name of a shipped robot, or a code of ISO 9409-1, as in
            ``iso-63-4-m6``: diameter of the bolt circle, number of screws, their thread.

    Raises:
        PrintableError: There is none, or its holes do not fit.
    """
    if name in MOUNTS:
        return MOUNTS[name]
    for mount in MOUNTS.values():
        if name in mount.links:
            return mount
    if code := _ISO.fullmatch(name.lower()):
        return BoltCircle(float(code[1]), int(code[2]), code[3].upper())
    robots = sorted({robot for mount in MOUNTS.values() for robot in mount.links})
    raise PrintableError(
        f"no mount {name!r}; there are: {', '.join(MOUNTS)}, codes of ISO 9409-1 as iso-63-4-m6, "
        f"none, and by robot: {', '.join(robots)}"
    )

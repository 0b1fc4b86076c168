"""A socket base that clips to an arm's own base plate, so that its place on the arm is known.

Two springy fingers hold the plate in their middle even if its width was measured a little wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .socket_base import PLATE, SocketBase
from .solid import (
    BED,
    TABLES,
    Outline,
    PrintableError,
    Solid,
    check_range,
    prism,
    rectangle,
    union,
)

BRIDGE = 80.0  # longest: near its base an arm shows less of its joints
FINGER, THICK = 30.0, 4.0  # length and thickness of a finger
# Between plate and finger, and by how much its bump bends the finger outwards.
GAP, GRIP = (
    0.3,
    0.4,
)
SLICE, BAR = 3.0, 10.0  # thickness and depth of the fit test
DEVIATION = 0.5
"""Standard deviation of the sockets' coordinates: of measuring the plate, and of printing."""


@dataclass(frozen=True)
class AnchoredArm:
    """Dimensions of an arm's base, by its model."""

    axis: float
    """x of the first joint's axis, which is vertical, in the base frame; its y is 0."""
    shoulder: float
    """Height of the second joint's axis in the base frame: to see whether z = 0 is the table."""


ARMS: Mapping[str, AnchoredArm] = {
    name: AnchoredArm(**it) for name, it in TABLES["arms"].items()
}
"""Arms by the name of their model."""


@dataclass(frozen=True, kw_only=True)
class AnchoredBase(SocketBase):
    """A socket base with a clip. The arm stands on its side of negative y and looks to positive y.

    Raises:
        PrintableError: As for a socket base, or the clip leaves no room for the base.
    """

    arm: str
    width: float
    """Of the arm's plate, at its front."""
    front: float
    """From the first joint's axis to the plate's front edge."""

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("a plate's width", self.width, 30, BED - 2 * (GAP + THICK))
        check_range(
            "from the first joint's axis to the plate's front", self.front, 0, 150
        )
        if self._bridge < 0:
            raise PrintableError(
                f"sockets {self.distance / 1000:g} m apart leave no room for the clip within "
                f"{BED:g} mm: take a smaller distance, or 2 sockets"
            )

    @property
    def name(self) -> str:
        """Name of its files."""
        return f"{super().name}-{self.arm}"

    @property
    def _bridge(self) -> float:
        (_, y0), (_, y1) = self.plate
        return min(BRIDGE, BED - FINGER - (y1 - y0))

    @property
    def face(self) -> float:
        """The y at which the plate's front edge stands."""
        return self.plate[0][1] - self._bridge

    @property
    def sockets_in_base(self) -> Sequence[tuple[float, float, float]]:
        """The sockets' centres in the arm's base frame."""
        edge = ARMS[self.arm].axis + self.front
        return [(edge + y - self.face, -x, self.height) for x, y in self.centres]

    def solid(self) -> Solid:
        """Return the part, standing on z = 0."""
        return union(super().solid(), *self._clip(PLATE, self.plate[0][1] + 1))

    def fit_test(self) -> Solid:
        """Return a thin slice of the clip, to try on the arm."""
        return union(*self._clip(SLICE, self.face + BAR))

    def sockets_at(self) -> str:
        """Return the file for ``mukca solve --sockets-at``, of a placement named ``anchored``."""
        rows = [
            f"base,anchored:{k},{x:.4f},{y:.4f},{z:.4f},{DEVIATION:g}"
            for k, (x, y, z) in enumerate(self.sockets_in_base)
        ]
        header = "frame,socket,x [mm],y [mm],z [mm],deviation [mm]"
        return "\n".join((header, *rows)) + "\n"

    def _clip(self, height: float, end: float) -> list[Solid]:
        """Return a bar from the plate's front edge to some y, and two fingers."""
        y = self.face
        inner = self.width / 2 + GAP
        outer = inner + THICK
        bump = self.width / 2 - GRIP
        finger: Outline = (
            (inner, y + 1),
            (inner, y - 20),
            (bump, y - 23),
            (bump, y - 26),
            (inner + 0.8, y - FINGER),
            (outer, y - FINGER),
            (outer, y + 1),
        )
        mirror = tuple((-x, y) for x, y in reversed(finger))
        bar = rectangle((-outer, outer), (y, end))
        return [prism(height, outline) for outline in (bar, finger, mirror)]

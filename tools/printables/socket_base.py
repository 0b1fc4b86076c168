"""The socket base: hexagonal posts on a plate, each with a seat for the ball.

Three flat pads touch the ball in a point each. They fix its centre, even if a print is not round.
Frame: origin in the middle of the sockets, z up from the table [mm].
"""

import math
from dataclasses import dataclass
from functools import cached_property

from .screw_holes import Box, place_holes
from .solid import (
    BED,
    HEIGHT,
    Point,
    PrintableError,
    Solid,
    check_range,
    cylinder,
    engraving,
    frustum,
    hexagon,
    prism,
    rectangle,
    sphere,
    text_width,
    union,
)

PLATE = 8.0  # thickness of the plate
WALL = 1.5  # least thickness between a seat and the waist of its post
CONTACT = math.radians(60)  # the pads touch the ball this far from its lowest point
AZIMUTHS = [math.radians(90 + 120 * pad) for pad in range(3)]
WAIST = (PLATE + 1.5, 8.0)  # lower end and height of the waist, where the caliper reads
JAWS = 10.0  # least room between two waists and posts, for the caliper's inner jaws
SCREW_HOLE = 6.6  # M6, ISO 273 medium
WASHER = 12.5  # M6, ISO 7089
LEDGE = 1.0  # of the plate beyond a post at its edge
EDGE = 8.0  # from a screw's axis to the plate's edge
DIGIT_SCALE = 1.3


@dataclass(frozen=True)
class SocketBase:
    """The parameters of a socket base, and what follows from them.

    Three sockets form an equilateral triangle, so that every two are ``distance`` apart.

    Raises:
        PrintableError: The parameters contradict each other, or the part is too large to print.
    """

    distance: float = 100.0
    """Between the centres of two sockets."""
    sockets: int = 2
    ball: float = 20.0
    """Diameter of the ball."""
    clearance: float = 0.5
    """Gap between ball and seat where they must not touch."""
    height: float = 30.0
    """Of the ball's centre above the table."""

    def __post_init__(self) -> None:
        if self.sockets not in (2, 3):
            raise PrintableError(f"{self.sockets} sockets: a base has 2 or 3")
        check_range("a ball", self.ball, 10, 40)
        check_range("a clearance", self.clearance, 0.3, 1.0)
        lowest = max(WAIST[0] + WAIST[1] + 5, self.ball / 2 + self.clearance + 4)
        check_range("a height of the sockets", self.height, math.ceil(lowest), 60)
        self._check_distance()
        if len(self.holes) < 3:
            raise PrintableError("no room for three M6 screws: take a larger distance")

    def _check_distance(self) -> None:
        asked = f"{self.sockets} sockets {self.distance / 1000:g} m apart"
        nearest = 2 * self.post + JAWS
        # Screws stand beside the posts, the readings between two of them.
        if self.sockets == 3:
            nearest = max(nearest + 3.0, 46.0)
        if not math.isfinite(self.distance) or self.distance < nearest:
            raise PrintableError(
                f"{asked} overlap: for a ball of {self.ball:g} mm take at least "
                f"{math.ceil(nearest) / 1000:g} m"
            )
        (x0, y0), (x1, y1) = self.plate
        excess = max(x1 - x0 - BED, (y1 - y0 - BED) / math.sin(math.pi / 3))
        if excess > 0:
            raise PrintableError(
                f"{asked} make a base of {x1 - x0:.0f} x {y1 - y0:.0f} mm, larger than {BED:g} mm: "
                f"take at most {math.floor(self.distance - excess) / 1000:g} m"
            )

    @property
    def name(self) -> str:
        """Name of its files."""
        return f"socket-base-{self.sockets}x{self.distance:g}mm"

    @cached_property
    def waist(self) -> float:
        """From a post's axis to each of its six caliper faces."""
        return math.ceil(self.ball / 2 + self.clearance + WALL)

    @property
    def post(self) -> float:
        """From a post's axis to its outer flats."""
        return self.waist + 1.0

    @property
    def outside(self) -> float:
        """Reading of a caliper with its outer jaws around two waists."""
        return self.distance + 2 * self.waist

    @property
    def inside(self) -> float:
        """Reading of a caliper with its inner jaws between two waists."""
        return self.distance - 2 * self.waist

    @property
    def spans(self) -> tuple[Point, ...]:
        """Lowest and highest x that a drawing has: of sockets 0 and 1, over and between waists."""
        (left, _), (right, _) = self.centres[:2]
        ends = (0.0, self.waist, -self.waist)
        return tuple((left - end, right + end) for end in ends)

    @property
    def rim(self) -> float:
        """Height of a post's top: below the ball's equator, so that the neck can lean over it."""
        return self.height - 0.05 * self.ball

    @cached_property
    def centres(self) -> tuple[Point, ...]:
        """The sockets' centres, seen from above."""
        half = self.distance / 2
        low = -self.distance / math.sqrt(12)
        if self.sockets == 2:
            return ((-half, 0.0), (half, 0.0))
        return ((-half, low), (half, low), (0.0, -2 * low))

    @property
    def corner(self) -> float:
        """From a post's axis to its corners."""
        return self.post / math.cos(math.pi / 6)

    @cached_property
    def plate(self) -> tuple[Point, Point]:
        """The plate's lowest and highest x and y."""
        half = max(self.distance / 2 + self.post + LEDGE, 35.0)
        if self.sockets == 2:
            depth = self.corner + 22
            return (-half, -depth), (half, depth)
        front = self.centres[0][1] - self.corner - 12
        return (-half, front), (half, self.centres[2][1] + self.corner + LEDGE)

    @cached_property
    def text_boxes(self) -> tuple[Box, ...]:
        """The room of the engraved numbers: one of each socket, then that of the readings."""
        half_height = DIGIT_SCALE * HEIGHT / 2
        drop = self.corner + 1.2 + half_height
        low = -drop - half_height
        high = -drop + half_height
        digits = [Box(x - 3.0, y + low, x + 3.0, y + high) for x, y in self.centres]
        half_width = max(map(text_width, self.readings)) / 2
        middle = (self.corner + self.plate[1][1]) / 2
        if self.sockets == 3:
            middle = self.plate[0][1] + 2 + HEIGHT + 0.6
        lines = Box(
            -half_width,
            middle - 0.6 - HEIGHT,
            half_width,
            middle + 0.6 + HEIGHT,
        )
        return (*digits, lines)

    @property
    def readings(self) -> tuple[str, str]:
        """The engraved readings of the caliper [mm]."""
        return f"OUT {self.outside:.2f}", f"In {self.inside:.2f}"

    @cached_property
    def holes(self) -> tuple[Point, ...]:
        """The axes of the M6 screws, on a 25 mm grid of their own."""
        (x0, y0), (x1, y1) = self.plate
        whole = Box(x0, y0, x1, y1)
        reach = self.corner + WASHER / 2 + 0.5
        posts = [(*centre, reach) for centre in self.centres]
        return place_holes(whole.grown(-EDGE), posts, self.text_boxes, WASHER / 2)

    def solid(self) -> Solid:
        """Return the part, standing on z = 0."""
        (x0, y0), (x1, y1) = self.plate
        plate = prism(PLATE, rectangle((x0, x1), (y0, y1), 5.0))
        posts = self._post().at_each(self.centres)
        seats = self._seat().at_each(self.centres)
        holes = cylinder(SCREW_HOLE / 2, PLATE + 2).at_each(self.holes, z=-1)
        removed = union(*seats, *holes, *self._engravings())
        return union(plate, *posts) - removed

    def _post(self) -> Solid:
        """Return a hexagonal post with a waist, whose ceiling leans less than 45 degrees."""
        low, height = WAIST
        height_above = self.rim - low - height
        head = prism(height_above, hexagon(self.post))
        start = self.waist - 0.2
        flare = frustum(height_above, start, start + height_above / 1.1)
        return union(
            prism(low, hexagon(self.post)),
            prism(low + height, hexagon(self.waist)),
            (head & flare).at(z=low + height),
        )

    def _seat(self) -> Solid:
        """Return what is cut out for a ball: a wider ball less three pads, and a drain below."""
        radius = self.ball / 2
        bowl = sphere(radius + self.clearance)
        # Beyond the planes that touch the ball at CONTACT.
        beyond = cylinder(radius, radius).at(z=radius)
        pads = union(*(beyond.leaned(math.pi - CONTACT, a) for a in AZIMUTHS))
        drain = cylinder(0.3 * radius, self.height + 1 - radius / 2).at(
            z=-self.height - 1
        )
        return union(bowl - pads, drain).at(z=self.height)

    def _engravings(self) -> list[Solid]:
        *digits, lines = self.text_boxes
        numbers = [
            engraving(str(i), *box.middle, PLATE, DIGIT_SCALE)
            for i, box in enumerate(digits)
        ]
        x, y = lines.middle
        steps = (HEIGHT / 2 + 0.6, -HEIGHT / 2 - 0.6)
        rows = zip(self.readings, steps, strict=True)
        return [*numbers, *(engraving(text, x, y + step, PLATE) for text, step in rows)]

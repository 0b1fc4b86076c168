"""The ball on its neck, a cone that is thin at the socket's rim and thick at the mount [mm, N]."""

import math
from dataclasses import dataclass
from functools import cached_property

from .mounts import Mount
from .solid import (
    BED,
    HEIGHT,
    TILT,
    PrintableError,
    Solid,
    check_range,
    engraving,
    frustum,
    sphere,
    text_width,
    union,
)

FORCE = 5.0
"""The sideways force at the ball for which the neck is made [N]."""

YOUNG = 2500.0
"""Young's modulus of printed plastic, 2.5 GPa [N/mm²]."""

BEND_LIMIT = 0.05
"""Largest deflection of the neck under that force [mm]."""

BEND_AIM = 0.04  # what the neck is made for; the rest is for mount and layers
ABOVE = 1.5  # what a leaning mount keeps above the ball's centre
GLUE = 0.1  # gap between a bought ball and its cup
LEAN_MARGIN = math.radians(2)
SHALLOWEST = math.radians(12)  # between a leaning neck's lower side and the horizontal


@dataclass(frozen=True)
class BallPart:
    """The parameters of a ball part, and what follows from them.

    Raises:
        PrintableError: The parameters contradict each other.
    """

    mount: Mount
    ball: float = 20.0
    """Diameter of the ball."""
    neck: float | None = None
    """Diameter of the neck where it meets the ball; None: 0.45 of the ball's."""
    reach: float | None = None
    """From the flange frame's origin to the ball's centre; None: the mount's own."""
    bought: bool = False
    """The neck ends in a cup, into which a bought ball is glued."""

    def __post_init__(self) -> None:
        check_range("a ball", self.ball, 10, 40)
        origin = self.mount.origin
        reach = self.height - self.mount.origin
        if self.ball > self.mount.widest_ball:
            raise PrintableError(
                f"a ball of {self.ball:g} mm hides the screws from their key: take at most "
                f"{self.mount.widest_ball:g} mm, or a wider bolt circle"
            )
        thickest = self.ball * math.sin(math.pi / 2 - TILT - LEAN_MARGIN)
        if not 3.0 <= self.throat <= thickest:
            raise PrintableError(
                f"a neck of {self.throat:g} mm on a ball of {self.ball:g} mm: it must be 3 to "
                f"{math.floor(thickest * 10) / 10:g} mm thick to lean {math.degrees(TILT):.0f} "
                "degrees"
            )
        lowest = math.ceil(self.mount.top + self.ball / 2 - origin)
        check_range("a reach", reach, lowest, math.floor(BED - self.ball / 2 - origin))
        if self.bend > BEND_LIMIT:
            raise PrintableError(
                f"the neck would bend {self.bend:.2f} mm under {FORCE:g} N, more than "
                f"{BEND_LIMIT:g} mm: shorten the reach of {reach:g} mm or thicken the neck of "
                f"{self.throat:g} mm"
            )
        if math.pi / 2 - TILT - math.atan(self.slope) < SHALLOWEST:
            raise PrintableError(
                f"the neck must widen from {self.throat:g} to {self.root:g} mm, too much to lean "
                "over a socket: thicken it or lengthen the reach"
            )

    @property
    def shortest_reach(self) -> float:
        """The reach at which, at full tilt, all of the mount stays above the ball's centre."""
        heights = [
            z + (r * math.sin(TILT) + ABOVE) / math.cos(TILT)
            for r, z in self.mount.corners
        ]
        least = max(heights) - self.mount.origin
        return 5.0 * math.ceil(least / 5)

    @cached_property
    def height(self) -> float:
        """Height of the ball's centre, as printed."""
        reach = self.mount.reach if self.reach is None else self.reach
        return self.mount.origin + (self.shortest_reach if reach is None else reach)

    @property
    def position(self) -> tuple[float, float, float]:
        """The ball's centre in the flange's frame."""
        return self.in_frame(self.height)

    def in_frame(self, height: float) -> tuple[float, float, float]:
        """Return a point of the part's axis in the flange's frame."""
        place = list(self.mount.aside)
        place.insert(self.mount.axis, height - self.mount.origin)
        x, y, z = map(float, place)
        return x, y, z

    @property
    def throat(self) -> float:
        """Diameter of the neck where it meets the ball."""
        return 0.45 * self.ball if self.neck is None else self.neck

    @property
    def length(self) -> float:
        """Length of the lever: from the ball's centre to the mount."""
        return self.height - self.mount.top

    @property
    def _start(self) -> float:
        """Distance from the ball's centre to where the neck meets it."""
        return math.sqrt((self.ball / 2) ** 2 - (self.throat / 2) ** 2)

    @cached_property
    def root(self) -> float:
        """Diameter of the neck at the mount: the least whole one that is stiff enough."""
        widest = math.floor(self.mount.widest_root)
        for diameter in range(math.ceil(self.throat), widest):
            if self._bend(diameter) <= BEND_AIM:
                return diameter
        return max(widest, self.throat)

    @property
    def slope(self) -> float:
        """Growth of the neck's radius along it."""
        return (self.root - self.throat) / 2 / (self.length - self._start)

    @property
    def bend(self) -> float:
        """Deflection of the ball under FORCE sideways."""
        return self._bend(self.root)

    def _bend(self, root: float) -> float:
        """Return the deflection of a cantilever, the integral of F x²/(E I(x)) over its length.

        Euler-Bernoulli, round section, I = pi d⁴/64; the mount and the ball count as rigid. With d
        linear in x, u = x/d at the throat and v at the root, the integral of x²/d⁴ from s to l is

            (l - s) (u² + u v + v²) / (3 d(s) d(l))
        """
        u = self._start / self.throat
        v = self.length / root
        squares = u**2 + u * v + v**2
        integral = (self.length - self._start) * squares / (3 * self.throat * root)
        return FORCE * integral / (YOUNG * math.pi / 64)

    def solid(self) -> Solid:
        """Return the part, standing on z = 0."""
        # The cone's radius, carried on.
        centre = self.throat / 2 - self.slope * self._start
        top = self.height - 0.5 * self._start
        neck = frustum(
            top - self.mount.top + 1,
            self.root / 2 + self.slope,
            centre + self.slope * 0.5 * self._start,
        ).at(z=self.mount.top - 1)
        body = union(self.mount.body, neck)
        radius = self.ball / 2
        if self.bought:
            body = body - sphere(radius + GLUE).at(z=self.height)
        else:
            body = body | sphere(radius).at(z=self.height)
        # The ball's height is engraved on the mount, where there is room for it.
        text = f"Z {self.height - self.mount.origin:g}"
        inner = self.root / 2 + 1.0
        room = math.hypot(inner + HEIGHT, text_width(text) / 2)
        if room > (self.mount.lettering or 0.0):
            return body
        return body - engraving(text, 0.0, -inner - HEIGHT / 2, self.mount.top)

    def envelope(self) -> Solid:
        """Return what moves with the part: itself, a bought ball and the heads of its screws."""
        parts = [self.solid()]
        if self.bought:
            parts.append(sphere(self.ball / 2).at(z=self.height))
        if self.mount.hardware:
            parts.append(self.mount.hardware)
        return union(*parts)

"""A set of parts, the base and the balls that go with it: built and checked."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial, reduce
from itertools import product, starmap
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...solver.identification.robot import turn
from .anchor import ARMS, AnchoredBase
from .ball import BEND_LIMIT, FORCE, BallPart
from .kernels import COARSE, Mesh, to_manifold, to_mesh
from .print_time import BALL, BASE, WALLS, Recipe, print_of
from .socket_base import SocketBase
from .solid import BED, TABLES, TILT, Point, PrintableError, Solid, sphere

if TYPE_CHECKING:
    from jinja2 import Environment

DENSITIES: Mapping[str, float] = TABLES["densities"]
"""Of solid plastic [kg/m³]."""

LIFT = 0.1
"""Height of the ball above its pads, to tell contact from collision [mm]."""
COLLISION = 1e-6  # [mm³]
AZIMUTHS = np.radians(np.arange(0, 360, 15))
SPINS = (0.0, math.pi / 4, math.pi / 2)  # of the ball part about its own neck


@cache
def templates() -> "Environment":
    """Return the templates of files."""
    from jinja2 import Environment, FileSystemLoader

    folder = FileSystemLoader(Path(__file__).parent / "templates")
    return Environment(loader=folder, trim_blocks=True)  # noqa: S701 (texts are escaped one by one)


def rendered(template: str, **values: Any) -> list[str]:
    """Return the lines of a template of text, without those that are empty."""
    text = templates().get_template(template).render(**values)
    return [line for line in text.splitlines() if line]


class Ball(NamedTuple):
    """A ball in a socket: its centre in the part's frame, its diameter, and words [mm]."""

    x: float
    y: float
    z: float
    diameter: float
    text: str


@dataclass(frozen=True)
class Part:
    """A part that passed its checks."""

    name: str
    """Of its files, without the suffix."""
    solid: Solid
    mesh: Mesh
    levels: Sequence[Point] = ()
    """Heights between which a drawing tells the distance."""
    spans: Sequence[Point] = ()
    """Values of x between which a drawing tells the distance."""
    circles: Sequence[tuple[float, str]] = ()
    """Diameters of circles of holes about its axis, and a drawing's words for each."""
    balls: Sequence[Ball] = ()
    """Balls that lie in it, as a drawing shows them."""
    facts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Properties of it, in SI units, as JSON has them."""

    @property
    def making(self) -> str:
        """Its masses, settings of the printer and the time to print it, in a line."""
        mass_by_plastic = self.facts["mass"].items()
        masses = ", ".join(f"{1000 * m:.0f} g of {name}" for name, m in mass_by_plastic)
        recipe = self.facts["print"]
        infill = f"{WALLS} walls, {100 * recipe['infill']:.0f} % infill"
        brim = f", a brim of {1000 * recipe['brim']:g} mm" if recipe["brim"] else ""
        hours = self.facts["print_time"] / 3600
        settings = f"layers of {1000 * recipe['layer']:g} mm, {infill}{brim}"
        return f"{masses}; {settings}: printed in some {hours:.1f} h"

    @property
    def lines(self) -> list[str]:
        """The facts that its user needs, a line each."""
        limits = {"force": FORCE, "bend_limit": BEND_LIMIT, "degrees": math.degrees(1)}
        return rendered("part.txt.j2", part=self.facts, **limits)


def build_parts(base: SocketBase, balls: Mapping[str, BallPart]) -> Iterator[Part]:
    """Build and check a socket base and the ball parts for it, by their names, one after the other.

    Raises:
        PrintableError: A part cannot be printed, or hits the base when it leans.
    """
    yield base_part(base)
    if isinstance(base, AnchoredBase):
        yield _checked(part_names(base)[1], base.fit_test(), {}, BASE)
    for name, ball in balls.items():
        try:
            check_tilt(base, ball)
        except PrintableError as error:
            raise PrintableError(f"{name}: {error}") from None
        yield ball_part(name, ball)


def part_names(base: SocketBase) -> list[str]:
    """Return the names of the parts that a base consists of."""
    return (
        [base.name, f"fit-test-{base.arm}"]
        if isinstance(base, AnchoredBase)
        else [base.name]
    )


def base_part(base: SocketBase) -> Part:
    """Build and check a socket base."""
    facts: dict[str, Any] = {
        "distance": _metres(base.distance),
        "ball_diameter": _metres(base.ball),
        "sockets": _metres([(x, y, base.height) for x, y in base.centres]),
        "holes": _metres(base.holes),
        "caliper": {"outside": _metres(base.outside), "inside": _metres(base.inside)},
    }
    if isinstance(base, AnchoredBase):
        facts["sockets_in_base"] = _metres(base.sockets_in_base)
        facts["second_axis_height"] = _metres(ARMS[base.arm].shoulder)
    levels = [(0.0, base.height)]
    balls = [
        Ball(*centre, base.height, base.ball, f"socket {i}, dust hole")
        for i, centre in enumerate(base.centres)
    ]
    drawing = {"levels": levels, "spans": base.spans, "balls": balls}
    return _checked(base.name, base.solid(), facts, BASE, **drawing)


def ball_part(name: str, ball: BallPart) -> Part:
    """Build a ball part, and check it by itself."""
    facts = {
        "ball": _metres(ball.position),
        "ball_diameter": _metres(ball.ball),
        "bought_ball": ball.bought,
        "neck": _metres([ball.throat, ball.root]),
        "flanges": dict(ball.mount.links),
        "note": ball.mount.note,
        "bend": _metres(ball.bend),
        "tilt": TILT,
        "overhangs": [] if ball.bought else ["under the ball, beside its neck"],
    }
    circles = [ball.mount.holes] if ball.mount.holes else []
    levels = [(ball.mount.origin, ball.height)]
    part = _checked(name, ball.solid(), facts, BALL, levels=levels, circles=circles)
    # This is the centre of its mass, full of plastic.
    middle = ball.in_frame(float(part.mesh.center_mass[2]))
    return replace(part, facts={**part.facts, "centre_of_mass": _metres(middle)})


def _metres(millimetres: Any) -> Any:
    """Return a number, or nested lists of them, in metres."""
    return (np.array(millimetres) / 1000).tolist()


def _checked(
    name: str, solid: Solid, facts: Mapping[str, Any], recipe: Recipe, **drawing: Any
) -> Part:
    """Build a part, with fields for its drawing, or refuse what cannot be printed."""
    body = to_manifold(solid)
    mesh = to_mesh(body)
    if not (
        len(body.decompose()) == 1 and mesh.is_watertight and mesh.is_winding_consistent
    ):
        raise PrintableError(f"{name}: these parameters make no single closed body")
    if max(mesh.extents) > BED:
        size = " x ".join(f"{edge:.0f}" for edge in mesh.extents)
        raise PrintableError(f"{name} would be {size} mm, larger than {BED:g} mm")
    volume = body.volume() * 1e-9
    of_print = print_of(to_manifold(solid, COARSE), recipe)
    plastic = of_print.plastic if recipe.infill < 1.0 else volume
    identity = {
        "name": name,
        "size": [round(edge / 1000, 7) for edge in mesh.extents.tolist()],
        "volume": volume,
        "mass": {
            material: density * plastic for material, density in DENSITIES.items()
        },
        "print": {
            "layer": _metres(recipe.layer),
            "infill": recipe.infill,
            "brim": of_print.brim,
        },
        "print_time": of_print.time,
    }
    return Part(name, solid, mesh, facts={**identity, **facts}, **drawing)


def check_tilt(base: SocketBase, part: BallPart) -> None:
    """Lean the ball part in every socket, all around, and refuse any collision with the base."""
    sphere_of_ball = sphere(part.ball / 2).at(z=part.height)
    # However it leans, a ball stays where it is; the rest of the part seldom comes near the base.
    ball = to_manifold(sphere_of_ball, COARSE)
    bed = to_manifold(part.envelope() - sphere_of_ball, COARSE)
    fixed = to_manifold(base.solid(), COARSE)
    for socket in range(base.sockets):
        pose_of = partial(leaning, base, part, socket)
        poses = starmap(partial(pose_of, TILT), product(AZIMUTHS, SPINS))
        placed = [ball.transform(pose_of(0.0, 0.0)), *map(bed.transform, poses)]
        if any((solid ^ fixed).volume() > COLLISION for solid in placed):
            raise PrintableError(
                f"it hits the base when it leans {math.degrees(TILT):.0f} degrees in "
                f"socket {socket}: take a reach of {part.shortest_reach:g} mm or more, "
                "higher sockets or a larger distance"
            )


def leaning(
    base: SocketBase,
    part: BallPart,
    socket: int,
    tilt: float,
    azimuth: float,
    spin: float = 0.0,
) -> np.ndarray:
    """Return the pose of a ball part that sits in a socket LIFT above its seat, shape (3, 4) [mm].

    Its neck leans by a tilt from the vertical to an azimuth from x, turned by a spin [rad].
    """
    turns = (
        (0.0, 0.0, azimuth),
        (0.0, tilt, 0.0),
        (0.0, 0.0, spin - azimuth),
        (math.pi, 0.0, 0.0),
    )
    lean = reduce(np.matmul, [turn(np.array(vector)) for vector in turns])
    centre = np.array((*base.centres[socket], base.height + LIFT))
    return np.column_stack((lean, centre - lean[:, 2] * part.height))

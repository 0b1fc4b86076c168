"""A set of parts: the base and the balls that go with it, built, checked and described."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .anchor import ARMS, AnchoredBase
from .ball import BallPart
from .checks import check_body, check_tilt
from .design_rules import TILT, PrintableError
from .mesh import Mesh, to_manifold, to_mesh
from .socket_base import SocketBase
from .solid import Solid


@dataclass(frozen=True)
class Part:
    """A part that passed its checks."""

    name: str
    """Of its files, without the suffix."""
    solid: Solid
    mesh: Mesh
    facts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """What is worth knowing about it, in SI units, as JSON has it."""


def build_parts(base: SocketBase, balls: Mapping[str, BallPart]) -> Iterator[Part]:
    """Build and check a socket base and the ball parts for it, one after the other.

    Args:
        base: The socket base.
        balls: The ball parts by name.

    Raises:
        PrintableError: A part cannot be printed, or hits the base when it leans.
    """
    yield base_part(base)
    if isinstance(base, AnchoredBase):
        yield _checked(part_names(base)[1], base.fit_test(), {})
    for name, ball in balls.items():
        try:
            check_tilt(base, ball)
        except PrintableError as error:
            raise PrintableError(f"{name}: {error}") from None
        yield ball_part(name, ball)


def part_names(base: SocketBase) -> list[str]:
    """Return the names of the parts that a base consists of."""
    return [base.name, f"fit-test-{base.arm}"] if isinstance(base, AnchoredBase) else [base.name]


def base_part(base: SocketBase) -> Part:
    """Build and check a socket base.

    Raises:
        PrintableError: It cannot be printed.
    """
    facts: dict[str, Any] = {
        "distance": base.distance / 1000,
        "ball_diameter": base.ball / 1000,
        "sockets": [[x / 1000, y / 1000, base.height / 1000] for x, y in base.centres],
        "holes": [[x / 1000, y / 1000] for x, y in base.holes],
        "caliper": {"outside": base.outside / 1000, "inside": base.inside / 1000},
    }
    if isinstance(base, AnchoredBase):
        facts["sockets_in_base"] = [[x / 1000 for x in place] for place in base.sockets_in_base]
        facts["second_axis_height"] = ARMS[base.arm].shoulder / 1000
    return _checked(base.name, base.solid(), facts)


def ball_part(name: str, ball: BallPart) -> Part:
    """Build a ball part, and check it by itself.

    Raises:
        PrintableError: It cannot be printed.
    """
    facts = {
        "ball": [x / 1000 for x in ball.position],
        "ball_diameter": ball.ball / 1000,
        "bought_ball": ball.bought,
        "flanges": dict(ball.mount.links),
        "note": ball.mount.note,
        "bend": ball.bend / 1000,
        "tilt": TILT,
        "overhangs": [overhang.where for overhang in ball.overhangs],
    }
    return _checked(name, ball.solid(), facts)


def _checked(name: str, solid: Solid, facts: Mapping[str, Any]) -> Part:
    body = to_manifold(solid)
    mesh = to_mesh(body)
    check_body(name, body, mesh)
    size = [round(float(edge) / 1000, 7) for edge in np.ptp(mesh.vertices, axis=0)]
    common = {"name": name, "size": size, "volume": body.volume() * 1e-9}
    return Part(name, solid, mesh, {**common, **facts})

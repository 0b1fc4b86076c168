"""Checks on the triangles themselves before anything is written."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from .ball import BallPart
from .kernels import Mesh, to_manifold
from .socket_base import SocketBase
from .solid import BED, TILT, PrintableError, Sphere

if TYPE_CHECKING:
    from manifold3d import Manifold

LIFT = 0.1
"""Height of the ball above its pads, to tell contact from collision [mm]."""
COARSE = 0.02  # round surfaces are that exact here [mm]: far less than LIFT, and ten times faster
COLLISION = 1e-6  # [mm³]
AZIMUTHS = np.radians(np.arange(0, 360, 15))
SPINS = (0.0, math.pi / 4, math.pi / 2)  # of the ball part about its own neck


def is_closed(mesh: Mesh) -> bool:
    """Tell whether each edge joins two triangles that agree on which side is out."""
    starts, ends = mesh.triangles, np.roll(mesh.triangles, -1, axis=1)
    count = len(mesh.vertices)
    there = np.sort((starts * count + ends).ravel())
    back = np.sort((ends * count + starts).ravel())
    return bool((np.diff(there) > 0).all() and (there == back).all())


def check_body(name: str, body: "Manifold", mesh: Mesh) -> None:
    """Refuse a part that is not one closed body, or does not fit the printer."""
    bodies = len(body.decompose())
    if bodies != 1 or not is_closed(mesh):
        raise PrintableError(f"{name}: these parameters make no single closed body")
    size = np.ptp(mesh.vertices, axis=0)
    if size.max() > BED:
        shown = " x ".join(f"{edge:.0f}" for edge in size)
        raise PrintableError(f"{name} would be {shown} mm, larger than {BED:g} mm")


def check_tilt(base: SocketBase, part: BallPart) -> None:
    """Lean the ball part in every socket, all around, and refuse any collision with the base."""
    ball = Sphere(part.ball / 2).at(z=part.height)
    # However it leans, a ball stays where it is; the rest of the part seldom comes near the base.
    rest = to_manifold(part.envelope() - ball, COARSE)
    leans = [(TILT, float(azimuth), spin) for azimuth in AZIMUTHS for spin in SPINS]
    poses: list[tuple[int, Any]] = []
    for socket in range(base.sockets):
        upright = leaning(base, part, socket, 0.0, 0.0)
        poses.append((socket, to_manifold(ball, COARSE).transform(upright)))
        poses += [(socket, rest.transform(leaning(base, part, socket, *lean))) for lean in leans]
    fixed = to_manifold(base.solid(), COARSE)
    for socket, placed in poses:
        if (placed ^ fixed).volume() > COLLISION:
            raise PrintableError(
                f"it hits the base when it leans {math.degrees(TILT):.0f} degrees in "
                f"socket {socket}: take a reach of {part.shortest_reach:g} mm or more, "
                "higher sockets or a larger distance"
            )


def leaning(
    base: SocketBase, part: BallPart, socket: int, tilt: float, azimuth: float, spin: float = 0.0
) -> np.ndarray:
    """Return the pose of a ball part that sits in a socket LIFT above its seat, shape (3, 4) [mm].

    Its neck leans by a tilt from the vertical to an azimuth from x, turned by a spin [rad].
    """
    flipped = np.diag((1.0, -1.0, -1.0))
    lean = _turn_z(azimuth) @ _turn_y(tilt) @ _turn_z(spin - azimuth) @ flipped
    centre = np.array((*base.centres[socket], base.height + LIFT))
    return np.column_stack((lean, centre - lean[:, 2] * part.height))


def _turn_z(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))


def _turn_y(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))

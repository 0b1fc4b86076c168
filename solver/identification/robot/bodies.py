"""The masses on a chain of joints, read from a URDF's text."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....errors import ON_FLANGE
from .chain import Joint
from .rotations import matrix_rpy
from .urdf_text import ModelError, UrdfText, Vector, numbers

HEAVIEST, TAPER = 5.0, 0.8
"""Of a model without masses: that of the first link [kg], and each next one's share of it."""


@dataclass(frozen=True)
class Body:
    """A mass that moves with a link of the chain."""

    joint: int
    """Index of the chain's joint whose child link carries it."""
    mass: float
    """[kg]."""
    centre: Vector
    """Centre of mass in that link's frame [m]."""


def find_bodies(
    text: UrdfText,
    joints: Sequence[Joint],
) -> tuple[Body, ...]:
    """Return all masses that the chain moves; joints beside it, as of a gripper, are at zero.

    Raises:
        ModelError: A mass is negative or no number, or its centre is none, or in millimetres.
    """
    index = {joint.child: i for i, joint in enumerate(joints)}
    bodies: list[Body] = []
    for link, element in text.links.items():
        inertial = element.first("inertial")
        if inertial is None:
            continue
        where = f"{text.source}: link {link!r}"
        value = inertial.read("mass", "value", "0")
        [mass] = numbers(value, where, "mass", 1)
        xyz = inertial.read("origin", "xyz", "0 0 0")
        centre = np.array(numbers(xyz, where, "origin", 3))
        if mass < 0:
            raise ModelError(f"{where}: a mass of {mass:g} kg; write zero or more")
        name = link
        while mass and name not in index and name in text.parents:
            joint, name = text.parents[name]
            origin = text.origins[joint]
            centre = origin.xyz + matrix_rpy(origin.rpy) @ centre
        if not mass or name not in index:
            continue
        if doubt := ON_FLANGE.doubt(centre.tolist()):
            raise ModelError(f"{where}: its centre of mass: {doubt}")
        x, y, z = centre.tolist()
        bodies.append(Body(index[name], mass, (x, y, z)))
    return tuple(bodies)


def crude_bodies(joints: Sequence[Joint]) -> tuple[Body, ...]:
    """Return a mass for each link that moves, half way to the next joint, or to the ball.

    Their total is any, since a compliance is as much larger as the masses are smaller; and so is
    the share of each next link, :data:`TAPER`.
    """
    last = len(joints) - 1
    moving = [i for i, joint in enumerate(joints) if joint.actuated]
    bodies: list[Body] = []
    for rank, i in enumerate(moving):
        following = moving[rank + 1] if rank + 1 < len(moving) else last
        place = np.zeros(3)
        for joint in joints[following:i:-1]:
            place = joint.origin.xyz + matrix_rpy(joint.origin.rpy) @ place
        x, y, z = (place / 2).tolist()
        bodies.append(Body(i, HEAVIEST * TAPER**rank, (x, y, z)))
    return tuple(bodies)

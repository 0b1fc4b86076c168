"""The chain of joints from the base to the ball, and the masses on it, read from a URDF's text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .urdf_text import ModelError, Origin, UrdfText, numbers

_CALIBRATED = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Joint:
    """A joint of the chain."""

    name: str
    type: str
    """``revolute``, ``continuous``, ``prismatic`` or ``fixed``."""
    parent: str
    child: str
    origin: Origin
    axis: tuple[float, float, float]
    """Unit vector in the joint's own frame; arbitrary where the joint is fixed."""
    lower: float = -math.inf
    """Lower limit [rad], [m] for a prismatic joint; minus infinity where there is none."""
    upper: float = math.inf

    @property
    def actuated(self) -> bool:
        """True for a joint that moves."""
        return self.type != "fixed"


@dataclass(frozen=True)
class Body:
    """A mass that moves with a link of the chain."""

    joint: int
    """Index of the chain's joint whose child link carries it."""
    mass: float
    """[kg]."""
    centre: tuple[float, float, float]
    """Centre of mass in that link's frame [m]."""


def find_root(text: UrdfText) -> str:
    """Return the one link that has no parent.

    Raises:
        ModelError: There is none, or more than one, or a link that does not hang on it.
    """
    parents = text.parents
    roots = [link for link in text.links if link not in parents]
    if not roots:
        raise ModelError(
            f"{text.source}: no root link, the joints form a loop where a tree is needed"
        )
    if len(roots) > 1:
        raise ModelError(
            f"{text.source}: {len(roots)} links have no parent ({', '.join(roots[:4])}); "
            "a robot has one root, so join them by fixed joints"
        )
    for link in sorted(text.links):
        above, steps = link, 0
        while above in parents and steps < len(text.links):  # more would be round a loop
            above, steps = parents[above][1], steps + 1
        if above != roots[0]:
            raise ModelError(f"{text.source}: the joints above {link!r} form a loop")
    return roots[0]


def require_link(text: UrdfText, link: str, hint: str = "") -> None:
    """Refuse a name that is no link's."""
    if link not in text.links:
        some = ", ".join([*text.links][-6:]) or "none"
        raise ModelError(f"{text.source}: no link is called {link!r}{hint} (last links: {some})")


def find_chain(text: UrdfText, base: str, tip: str) -> tuple[Joint, ...]:
    """Return the joints from base to tip, in that order.

    Raises:
        ModelError: There is no such chain, or one of its joints is not of a kind to calibrate.
    """
    names: list[str] = []
    link = tip
    while link != base:
        if link not in text.parents:
            raise ModelError(f"{text.source}: {tip!r} is not below {base!r}; choose another --base")
        name, link = text.parents[link]
        names.append(name)
    return tuple(_joint(text, name) for name in reversed(names))


def _joint(text: UrdfText, name: str) -> Joint:
    where, written = f"{text.source}: joint {name!r}", text.joints[name]
    kind = written.attributes.get("type", "without a type")
    if kind not in (*_CALIBRATED, "fixed"):
        raise ModelError(f"{where} is {kind}, which a chain to calibrate cannot have")
    if kind != "fixed" and written.first("mimic"):
        leader = written.read("mimic", "joint")
        raise ModelError(f"{where} mimics {leader!r}; a chain's joint must move freely")
    limits = written.first("limit")
    lower, upper = -math.inf, math.inf
    if kind in ("revolute", "prismatic") and limits and {"lower", "upper"} & {*limits.attributes}:
        lower, upper = (
            numbers(limits.attributes.get(key, "0"), where, key, 1, finite=False)[0]
            for key in ("lower", "upper")
        )
    if not lower <= upper:
        raise ModelError(f"{where}: its limits {lower} to {upper} leave no room")
    axis = (1.0, 0.0, 0.0)
    if kind != "fixed":  # a joint that does not move has no axis, whatever is written there
        along = numbers(written.read("axis", "xyz", "1 0 0"), where, "axis", 3)
        length = float(np.linalg.norm(along))
        if not 1e-9 <= length < math.inf:
            raise ModelError(f"{where}: axis {along} is no direction")
        x, y, z = (np.array(along) / length).tolist()
        axis = (x, y, z)
    parent, child = (written.read(role, "link") for role in ("parent", "child"))
    return Joint(name, kind, parent, child, text.origins[name], axis, lower, upper)


def find_bodies(text: UrdfText, joints: Sequence[Joint]) -> tuple[Body, ...]:
    """Return all masses that the chain moves; joints beside it, as of a gripper, are at zero."""
    index = {joint.child: i for i, joint in enumerate(joints)}
    bodies: list[Body] = []
    for link, element in text.links.items():
        inertial, where = element.first("inertial"), f"{text.source}: link {link!r}"
        if inertial is None:
            continue
        (mass,) = numbers(inertial.read("mass", "value", "0"), where, "mass", 1)
        centre = np.array(numbers(inertial.read("origin", "xyz", "0 0 0"), where, "origin", 3))
        name = link
        while mass and name not in index and name in text.parents:
            joint, name = text.parents[name]
            centre = text.origins[joint].xyz + matrix_rpy(text.origins[joint].rpy) @ centre
        if mass and name in index:
            x, y, z = centre.tolist()
            bodies.append(Body(index[name], mass, (x, y, z)))
    return tuple(bodies)


def rpy_axes(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the axes about which roll, pitch and yaw turn, in columns, shape (3, 3)."""
    _, pitch, yaw = rpy
    roll_axis, pitch_axis = matrix_rpy((0, pitch, yaw))[:, 0], matrix_rpy((0, 0, yaw))[:, 1]
    return np.stack([roll_axis, pitch_axis, np.array([0, 0, 1])], axis=1)


def matrix_rpy(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll) of numbers, shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def across(axis: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the two axes about which a joint tilts, at right angles to it and each other."""
    # For one of its frame's axes they are the two others, in the order x, y, z.
    first, second = (np.eye(3)[i] for i in sorted(np.argsort(np.abs(axis))[:2].tolist()))
    b = first - np.dot(first, axis) * np.array(axis)
    b /= np.linalg.norm(b)
    c = np.cross(axis, b)
    c *= np.copysign(1.0, c @ second)
    return tuple(b.tolist()), tuple(c.tolist())

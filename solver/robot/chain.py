"""The chain of joints from the base to the ball, and the masses on it, read from a URDF's text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .rotations import matrix_rpy
from .urdf_text import ModelError, Origin, UrdfText, numbers

Vector = tuple[float, float, float]
PARALLEL = 0.1
"""Sine of the angle of two axes, below which they count as parallel."""
APART = 1e-3
"""Distance of two parallel axes, below which they count as one line [m]."""
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
    tilt_axes: "tuple[Vector, Vector] | None" = None
    """Axes b and c about which it tilts, in its own frame; None for those :func:`across` its axis
    that are nearest to its frame's."""

    @property
    def tilts_by_frame(self) -> bool:
        """True if it tilts about the axes :func:`across` its own, as all joints did in 1.0."""
        return self.tilt_axes is None or bool(
            np.allclose(self.tilt_axes, across(self.axis))
        )

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
    """Return the one link that has no parent, on which all others hang.

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
    reached = {*roots}
    while (
        below := {link for link, (_, above) in parents.items() if above in reached}
        - reached
    ):
        reached |= below
    others = sorted({*text.links} - reached)
    if others:
        raise ModelError(f"{text.source}: the joints above {others[0]!r} form a loop")
    return roots[0]


def require_link(text: UrdfText, link: str, hint: str = "") -> None:
    """Refuse a name that is no link's."""
    if link not in text.links:
        some = ", ".join([*text.links][-6:]) or "none"
        raise ModelError(
            f"{text.source}: no link is called {link!r}{hint} (last links: {some})"
        )


def find_chain(text: UrdfText, base: str, tip: str) -> tuple[Joint, ...]:
    """Return the joints from base to tip, in that order.

    Raises:
        ModelError: There is no such chain, or one of its joints is not of a kind to calibrate.
    """
    names: list[str] = []
    link = tip
    while link != base:
        if link not in text.parents:
            raise ModelError(
                f"{text.source}: {tip!r} is not below {base!r}; choose another --base"
            )
        name, link = text.parents[link]
        names.append(name)
    return with_tilt_axes([_joint(text, name) for name in reversed(names)])


def with_tilt_axes(joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """Return the joints of a chain with the axes about which they tilt.

    They do not depend on how frames are drawn: b is the common normal of the joint's axis and the
    next one, as the x axis of a modified Denavit-Hartenberg frame, and c is at right angles to
    both. Where there is no normal, the joint beyond counts, or at last the one before, all at zero.
    """
    rotation = np.eye(3)
    p = np.zeros(3)
    frames: list[np.ndarray] = []
    lines: list[tuple[np.ndarray, np.ndarray]] = []
    for joint in joints:
        p = p + rotation @ np.array(joint.origin.xyz)
        rotation = rotation @ matrix_rpy(joint.origin.rpy)
        if joint.actuated:
            frames.append(rotation)
            lines.append((rotation @ np.array(joint.axis), p))
    tilting = list(joints)
    for i, j in enumerate(k for k, joint in enumerate(joints) if joint.actuated):
        neighbours = [*lines[i + 1 :], *reversed(lines[:i])]
        normals = [common_normal(lines[i], line) for line in neighbours]
        normal = next((n for n in normals if n is not None), None)
        if normal is not None:
            b = frames[i].T @ normal
            c = np.cross(joints[j].axis, b)
            tilting[j] = replace(joints[j], tilt_axes=(_axis(b), _axis(c)))
    return tuple(tilting)


def common_normal(
    line: tuple[np.ndarray, np.ndarray], second: tuple[np.ndarray, np.ndarray]
) -> np.ndarray | None:
    """Return the direction across two lines, each a unit vector and a point; None for one line."""
    a, p = line
    a_other, p_other = second
    normal = np.cross(a, a_other)
    if np.linalg.norm(normal) < PARALLEL:
        normal = p_other - p
        normal = normal - (normal @ a) * a
        if np.linalg.norm(normal) < APART:
            return None
    normal = normal - (normal @ a) * a
    return normal / np.linalg.norm(normal)


def _axis(direction: np.ndarray) -> Vector:
    """Return a unit vector whose largest number is positive, without the dust of rounding."""
    clean = np.where(np.abs(direction) < 1e-12, 0.0, direction)
    clean = clean * np.sign(clean[np.argmax(np.abs(clean))])
    x, y, z = (clean / np.linalg.norm(clean)).tolist()
    return x, y, z


def _joint(text: UrdfText, name: str) -> Joint:
    where = f"{text.source}: joint {name!r}"
    written = text.joints[name]
    kind = written.attributes.get("type", "without a type")
    if kind not in (*_CALIBRATED, "fixed"):
        child = written.read("child", "link")
        cure = (
            f"; begin the chain below it: --base {child}"
            if kind in ("floating", "planar")
            else ""
        )
        raise ModelError(
            f"{where} is {kind}, which a chain to calibrate cannot have{cure}"
        )
    if kind != "fixed" and written.first("mimic"):
        leader = written.read("mimic", "joint")
        raise ModelError(f"{where} mimics {leader!r}; a chain's joint must move freely")
    limits = written.first("limit")
    lower = -math.inf
    upper = math.inf
    if (
        kind in ("revolute", "prismatic")
        and limits
        and {"lower", "upper"} & {*limits.attributes}
    ):
        lower = numbers(
            limits.attributes.get("lower", "0"), where, "lower", 1, finite=False
        )[0]
        upper = numbers(
            limits.attributes.get("upper", "0"), where, "upper", 1, finite=False
        )[0]
    if not lower < upper:
        raise ModelError(
            f"{where}: its limits {lower:g} to {upper:g} leave no room; write its range, or make "
            "it continuous, or fixed if it cannot move"
        )
    axis = (1.0, 0.0, 0.0)
    # A joint that does not move has no axis, whatever is written there.
    if kind != "fixed":
        along = numbers(written.read("axis", "xyz", "1 0 0"), where, "axis", 3)
        length = float(np.linalg.norm(along))
        if not 1e-9 <= length < math.inf:
            raise ModelError(f"{where}: axis {along} is no direction")
        x, y, z = (np.array(along) / length).tolist()
        axis = (x, y, z)
    parent = written.read("parent", "link")
    child = written.read("child", "link")
    return Joint(name, kind, parent, child, text.origins[name], axis, lower, upper)


def find_bodies(text: UrdfText, joints: Sequence[Joint]) -> tuple[Body, ...]:
    """Return all masses that the chain moves; joints beside it, as of a gripper, are at zero."""
    index = {joint.child: i for i, joint in enumerate(joints)}
    bodies: list[Body] = []
    for link, element in text.links.items():
        inertial = element.first("inertial")
        where = f"{text.source}: link {link!r}"
        if inertial is None:
            continue
        (mass,) = numbers(inertial.read("mass", "value", "0"), where, "mass", 1)
        centre = np.array(
            numbers(inertial.read("origin", "xyz", "0 0 0"), where, "origin", 3)
        )
        name = link
        while mass and name not in index and name in text.parents:
            joint, name = text.parents[name]
            centre = (
                text.origins[joint].xyz + matrix_rpy(text.origins[joint].rpy) @ centre
            )
        if mass and name in index:
            x, y, z = centre.tolist()
            bodies.append(Body(index[name], mass, (x, y, z)))
    return tuple(bodies)


def across(axis: Sequence[float]) -> tuple[Vector, Vector]:
    """Return two axes at right angles to a joint's and each other, near those of its frame."""
    # For one of its frame's axes they are the two others, in the order x, y, z.
    first, second = np.eye(3)[np.sort(np.argsort(np.abs(axis))[:2])]
    b = first - np.dot(first, axis) * np.array(axis)
    b /= np.linalg.norm(b)
    c = np.cross(axis, b)
    c *= np.copysign(1.0, c @ second)
    return _axis(b), _axis(c)


def even_bodies(joints: Sequence[Joint]) -> tuple[Body, ...]:
    """Return a mass at each joint's origin, by which a model without any bends much as the arm."""
    return tuple(Body(i, 1.0, (0.0, 0.0, 0.0)) for i in range(len(joints)))

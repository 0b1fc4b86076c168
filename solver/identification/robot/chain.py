"""The chain of joints from the base to the ball, read from a URDF's text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ....errors import JOINT_POSITION
from .rotations import matrix_rpy
from .urdf_text import Element, ModelError, Origin, UrdfText, Vector, numbers

X_AXIS = (1.0, 0.0, 0.0)
PARALLEL = 0.1
"""Sine of the angle of two axes, below which they count as parallel."""
APART = 1e-3
"""Distance of two parallel axes, below which they count as one line [m]."""
ENDLESS = 1e3
"""Limits beyond stand for none, as in models of wheels [rad]; smaller ones may be degrees."""
_TYPES = ("revolute", "continuous", "prismatic", "fixed")


@dataclass(frozen=True)
class Joint:
    """A joint of the chain."""

    name: str
    type: str
    """``revolute``, ``continuous``, ``prismatic`` or ``fixed``."""
    parent: str
    child: str
    origin: Origin
    axis: Vector
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


class Line(NamedTuple):
    """A line in space."""

    direction: np.ndarray
    """Unit vector, shape (3,)."""
    point: np.ndarray
    """On the line, shape (3,) [m]."""


def find_root(text: UrdfText) -> str:
    """Return the one link that has no parent, on which all others hang.

    Raises:
        ModelError: There is none, or more than one, or a link that does not hang on it.
    """
    parents = text.parents
    if not text.links:
        raise ModelError(f"{text.source}: a <robot> without a <link>")
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
    _require_tree(text, roots[0])
    return roots[0]


def _require_tree(text: UrdfText, root: str) -> None:
    """Refuse links that do not hang on the root."""
    hanging = {root}
    for link in sorted(text.links):
        above: set[str] = set()
        name = link
        while name not in hanging:
            if name in above:
                raise ModelError(
                    f"{text.source}: the joints above {link!r} form a loop"
                )
            above.add(name)
            _, name = text.parents[name]
        hanging |= above


def require_link(
    text: UrdfText,
    link: str,
    hint: str = "",
) -> None:
    """Refuse a name that is no link's."""
    if link not in text.links:
        last = [*text.links][-6:]
        some = ", ".join(last) or "none"
        raise ModelError(
            f"{text.source}: no link is called {link!r}{hint} (last links: {some})"
        )


def find_chain(
    text: UrdfText,
    base: str,
    tip: str,
) -> tuple[Joint, ...]:
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
    joints = [_joint(text, name) for name in reversed(names)]
    return with_tilt_axes(joints)


def with_tilt_axes(joints: Sequence[Joint]) -> tuple[Joint, ...]:
    """Return the joints of a chain with the axes about which they tilt.

    They do not depend on how frames are drawn: b is the common normal of the joint's axis and the
    next one, as the x axis of a modified Denavit-Hartenberg frame, and c is at right angles to
    both. Where there is no normal, the joint beyond counts, or at last the one before, all at zero.
    """
    lines, frames = _lines_at_zero(joints)
    moving = [i for i, joint in enumerate(joints) if joint.actuated]
    with_axes = list(joints)
    for k, i in enumerate(moving):
        normal = _first_normal(lines, k)
        if normal is not None:
            joint = joints[i]
            b = frames[k].T @ normal
            c = np.cross(joint.axis, b)
            with_axes[i] = replace(joint, tilt_axes=(_axis(b), _axis(c)))
    return tuple(with_axes)


def _lines_at_zero(joints: Sequence[Joint]) -> tuple[list[Line], list[np.ndarray]]:
    """Return the axes of the joints that move, all at zero, and the rotations of their frames."""
    rotation = np.eye(3)
    p = np.zeros(3)
    lines: list[Line] = []
    frames: list[np.ndarray] = []
    for joint in joints:
        p = p + rotation @ np.array(joint.origin.xyz)
        rotation = rotation @ matrix_rpy(joint.origin.rpy)
        if joint.actuated:
            direction = rotation @ np.array(joint.axis)
            lines.append(Line(direction, p))
            frames.append(rotation)
    return lines, frames


def _first_normal(
    lines: Sequence[Line],
    k: int,
) -> np.ndarray | None:
    """Return the common normal of a line and the next one that has any, or else one before."""
    before = reversed(lines[:k])
    for line in (*lines[k + 1 :], *before):
        normal = common_normal(lines[k], line)
        if normal is not None:
            return normal
    return None


def common_normal(line: Line, second: Line) -> np.ndarray | None:
    """Return the direction across two lines, shape (3,); None for one line."""
    a = line.direction
    normal = np.cross(a, second.direction)
    if np.linalg.norm(normal) < PARALLEL:
        between = second.point - line.point
        normal = between - (between @ a) * a
        if np.linalg.norm(normal) < APART:
            return None
    normal = normal - (normal @ a) * a
    return normal / np.linalg.norm(normal)


def _axis(direction: np.ndarray) -> Vector:
    """Return a unit vector whose largest number is positive, without the dust of rounding."""
    clean = np.where(np.abs(direction) < 1e-12, 0.0, direction)
    largest = np.argmax(np.abs(clean))
    clean = clean * np.sign(clean[largest])
    unit: np.ndarray = clean / np.linalg.norm(clean)
    x, y, z = unit.tolist()
    return x, y, z


def _joint(text: UrdfText, name: str) -> Joint:
    """Return a joint of the chain as written."""
    where = f"{text.source}: joint {name!r}"
    element = text.joints[name]
    kind = element.attributes.get("type", "without a type")
    parent = element.read("parent", "link")
    child = element.read("child", "link")
    _require_type(kind, where, child)
    origin = text.origins[name]
    if kind == "fixed":
        return Joint(name, kind, parent, child, origin, X_AXIS)
    if element.first("mimic"):
        leader = element.read("mimic", "joint")
        raise ModelError(
            f"{where} mimics {leader!r}; a chain's joint must move freely: begin the chain "
            f"below it: --base {child}"
        )
    lower, upper = _limits(element, kind, where)
    axis = _unit_axis(element, where)
    return Joint(name, kind, parent, child, origin, axis, lower, upper)


def _require_type(kind: str, where: str, child: str) -> None:
    """Refuse a joint of a type that no calibration knows."""
    if kind in _TYPES:
        return
    cure = f"its joints are {', '.join(_TYPES[:-1])} or fixed"
    if kind in ("floating", "planar"):
        cure = f"begin the chain below it: --base {child}"
    raise ModelError(
        f"{where} is {kind}, which a chain to calibrate cannot have; {cure}"
    )


def _limits(
    element: Element,
    kind: str,
    where: str,
) -> tuple[float, float]:
    """Return a joint's lower and upper limit [rad], [m]; infinite where none is written."""
    limits = element.first("limit")
    written = {} if limits is None else dict(limits.attributes)
    if kind == "continuous" or not {"lower", "upper"} & {*written}:
        return -math.inf, math.inf
    lower, upper = (
        numbers(written.get(key, "0"), where, key, 1, finite=False)[0]
        for key in ("lower", "upper")
    )
    if not lower < upper:
        raise ModelError(
            f"{where}: its limits {lower:g} to {upper:g} leave no room; write its range, or make "
            "it continuous, or fixed if it cannot move"
        )
    stated = [limit for limit in (lower, upper) if abs(limit) < ENDLESS]
    doubt = JOINT_POSITION.doubt(stated)
    if kind == "revolute" and doubt:
        raise ModelError(f"{where}: its limit {doubt}")
    return lower, upper


def _unit_axis(element: Element, where: str) -> Vector:
    """Return the direction of a joint's axis, x where none is written."""
    words = element.read("axis", "xyz", "1 0 0")
    along = numbers(words, where, "axis", 3)
    length = math.hypot(*along)
    if not 1e-9 <= length < math.inf:
        raise ModelError(f"{where}: axis {along} is no direction")
    x, y, z = (number / length for number in along)
    return x, y, z


def across(axis: Sequence[float]) -> tuple[Vector, Vector]:
    """Return two axes at right angles to a joint's and each other, near those of its frame."""
    # For one of its frame's axes they are the two others, in the order x, y, z.
    least_aligned = np.argsort(np.abs(axis))[:2]
    first, second = np.eye(3)[np.sort(least_aligned)]
    a = np.array(axis)
    b = first - np.dot(first, a) * a
    b /= np.linalg.norm(b)
    c = np.cross(a, b)
    c *= np.copysign(1.0, c @ second)
    return _axis(b), _axis(c)

"""The chain of joints from the base to the ball, and the masses on it, read from a URDF's text."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .urdf_text import Element, ModelError, Origin, UrdfText

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


def find_parents(text: UrdfText, source: str) -> dict[str, str]:
    """Return the joint above each link; each link has one at most.

    Raises:
        ModelError: A joint without its two links, or a link with two parents.
    """
    parents: dict[str, str] = {}
    for joint in text.joints:
        for role in ("parent", "child"):
            link = _link(text, joint, role)
            if not link:
                raise ModelError(f'{source}: joint {joint!r} has no <{role} link="...">')
            if link not in text.links:
                raise ModelError(f"{source}: joint {joint!r} names a missing link {link!r}")
        child = _link(text, joint, "child")
        if child in parents:
            raise ModelError(
                f"{source}: link {child!r} has two parents, joints "
                f"{parents[child]!r} and {joint!r}: a loop, where a tree is needed"
            )
        parents[child] = joint
    return parents


def _link(text: UrdfText, joint: str, role: str) -> str:
    """Return the link that is a joint's ``parent`` or ``child``; empty for none."""
    return text.joints[joint].children.get(role, {}).get("link", "")


def find_root(text: UrdfText, parents: Mapping[str, str], source: str) -> str:
    """Return the one link that has no parent.

    Raises:
        ModelError: There is none, or more than one, or a link that does not hang on it.
    """
    roots = [link for link in text.links if link not in parents]
    if not roots:
        raise ModelError(f"{source}: no root link, the joints form a loop where a tree is needed")
    if len(roots) > 1:
        raise ModelError(
            f"{source}: {len(roots)} links have no parent ({', '.join(roots[:4])}); "
            "a robot has one root, so join them by fixed joints"
        )
    below: dict[str, list[str]] = {}
    for child, joint in parents.items():
        below.setdefault(_link(text, joint, "parent"), []).append(child)
    reached = roots[:]
    for link in reached:
        reached += below.get(link, [])
    lost = sorted(set(text.links) - set(reached))
    if lost:
        raise ModelError(f"{source}: the joints above {lost[0]!r} form a loop")
    return roots[0]


def require_link(text: UrdfText, link: str, source: str, hint: str = "") -> None:
    """Refuse a name that is no link's."""
    if link not in text.links:
        some = ", ".join(text.links[-6:]) or "none"
        raise ModelError(f"{source}: no link is called {link!r}{hint} (last links: {some})")


def find_chain(
    text: UrdfText, parents: Mapping[str, str], base: str, tip: str, source: str
) -> tuple[Joint, ...]:
    """Return the joints from base to tip, in that order, by the joint above each link.

    Raises:
        ModelError: There is no such chain, or one of its joints is not of a kind to calibrate.
    """
    names: list[str] = []
    link = tip
    while link != base:
        if link not in parents:
            raise ModelError(f"{source}: {tip!r} is not below {base!r}; choose another --base")
        names.append(parents[link])
        link = _link(text, parents[link], "parent")
    return tuple(_joint(text, name, source) for name in reversed(names))


def _joint(text: UrdfText, name: str, source: str) -> Joint:
    where, written = f"{source}: joint {name!r}", text.joints[name]
    kind = written.attributes.get("type", "without a type")
    if kind not in (*_CALIBRATED, "fixed"):
        raise ModelError(f"{where} is {kind}, which a chain to calibrate cannot have")
    mimic = written.children.get("mimic")
    if kind != "fixed" and mimic is not None:
        raise ModelError(f"{where} mimics {mimic.get('joint')!r}; a chain's joint must move freely")
    lower, upper = _limits(kind, written, where)
    if not lower <= upper:
        raise ModelError(f"{where}: its limits {lower} to {upper} leave no room")
    # A joint that does not move has no axis, whatever is written there.
    axis = (1.0, 0.0, 0.0) if kind == "fixed" else _axis(written, where)
    parent, child = (_link(text, name, role) for role in ("parent", "child"))
    return Joint(name, kind, parent, child, text.origins[name], axis, lower, upper)


def _axis(written: Element, where: str) -> tuple[float, float, float]:
    """Return the unit vector along a written axis."""
    words = written.children.get("axis", {}).get("xyz", "1 0 0")
    axis = _numbers(words, where, "axis")
    length = float(np.linalg.norm(axis))
    if axis.shape != (3,) or not math.isfinite(length) or length < 1e-9:
        raise ModelError(f"{where}: axis {axis.tolist()} is no direction")
    x, y, z = (axis / length).tolist()
    return x, y, z


def _limits(kind: str, written: Element, where: str) -> tuple[float, float]:
    """Return the limits of a joint: infinite where it turns without end or none is written."""
    limit = written.children.get("limit", {})
    if kind in ("continuous", "fixed") or not {"lower", "upper"} & set(limit):
        return (-math.inf, math.inf)
    lower, upper = (_number(limit.get(key, "0"), where, key) for key in ("lower", "upper"))
    return lower, upper


def _number(word: str, where: str, what: str) -> float:
    numbers = _numbers(word, where, what)
    if len(numbers) != 1:
        raise ModelError(f"{where}: not a valid URDF: {what} {word!r} is not one number")
    return float(numbers[0])


def _numbers(words: str, where: str, what: str) -> np.ndarray:
    try:
        return np.array([float(word) for word in words.split()])
    except ValueError:
        raise ModelError(f"{where}: not a valid URDF: {what} {words!r} is no number") from None


def find_bodies(
    text: UrdfText, parents: Mapping[str, str], joints: Sequence[Joint], source: str
) -> tuple[Body, ...]:
    """Return all masses that the chain moves; joints beside it, as of a gripper, are at zero."""
    index = {joint.child: i for i, joint in enumerate(joints)}
    bodies: list[Body] = []
    for link, inertial in text.inertials.items():
        where = f"{source}: link {link!r}"
        mass = _number(inertial.children.get("mass", {}).get("value", "0"), where, "mass")
        centre = _numbers(inertial.children.get("origin", {}).get("xyz", "0 0 0"), where, "origin")
        if centre.shape != (3,) or not np.isfinite([mass, *centre]).all():
            raise ModelError(f"{where}: its mass and the place of it must be finite numbers")
        name = link
        while mass and name not in index and name in parents:
            origin = text.origins[parents[name]]
            centre = origin.xyz + matrix_rpy(origin.rpy) @ centre
            name = _link(text, parents[name], "parent")
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

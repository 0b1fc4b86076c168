"""One URDF with several robots, each where a calibration has it."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Pose
from ..robot import ModelError, Origin, Robot, add_ball, rotation_rpy, scan, set_origins

WORLD = "world"


@dataclass(frozen=True)
class Placed:
    """A calibrated robot, and where its base stands."""

    name: str
    robot: Robot
    """The nominal robot."""
    origins: np.ndarray
    """Calibrated origins of its joints, shape (joints, 6)."""
    urdf: bytes
    """The calibrated URDF."""
    pose: Pose
    """Of its base link in that of the first robot."""


def joined_urdf(robots: Sequence[Placed]) -> bytes:
    """Return one URDF with all robots.

    Robots of files of their own get their name before each of their links and joints, and stand on
    a link ``world``, which is the first one's base. Robots that are chains of one file stay there:
    what the later ones' bases turned out to be off is put into the first joint that is their own.

    Raises:
        ModelError: Chains of one file share a joint that moves, or have different bases.
    """
    first = robots[0].robot
    if all(one.robot.source == first.source for one in robots) and _different(robots):
        return _in_one_file(robots)
    root = ET.Element("robot", name="_".join(one.name for one in robots))
    ET.SubElement(root, "link", name=WORLD)
    for one in robots:
        tree = _renamed(_tree(one.urdf), one.name)
        root.extend(list(tree))
        root.append(_stand(one))
    ET.indent(root)
    return b'<?xml version="1.0"?>\n' + ET.tostring(root) + b"\n"


def _tree(urdf: bytes) -> ET.Element:
    """Return a URDF as a tree; it was read before, and refused if it defined any entity."""
    return ET.fromstring(urdf)  # noqa: S314


def _different(robots: Sequence[Placed]) -> bool:
    """Tell whether the robots are different chains, and not one model used several times."""
    tips = [one.robot.tip for one in robots]
    return len(set(tips)) == len(tips)


def _renamed(tree: ET.Element, prefix: str) -> ET.Element:
    """Return a model with a prefix before the names of its links, joints and materials."""
    links = {e.get("name") for e in tree.findall("link")}
    joints = {e.get("name") for e in tree.findall("joint")}
    owners: Mapping[str, set[str | None]] = {
        "name": set(),
        "link": links,
        "reference": links | joints,
        "joint": joints,
    }
    for element in tree.iter():
        if element is tree:
            continue
        named = {"link": links, "joint": joints}.get(element.tag, set())
        for key, known in owners.items():
            value = element.get(key)
            whole = element.tag == "material" and key == "name"
            if value and (value in known or whole or (key == "name" and value in named)):
                element.set(key, f"{prefix}_{value}")
    return tree


def _stand(one: Placed) -> ET.Element:
    """Return the joint from the world to a robot's root."""
    root = _root(one.robot)
    origin = _origin(_after(one.pose, _to_base(one, root).inverse()))
    joint = ET.Element("joint", name=f"{WORLD}_to_{one.name}", type="fixed")
    xyz, rpy = (" ".join(f"{value:.17g}" for value in part) for part in (origin.xyz, origin.rpy))
    ET.SubElement(joint, "origin", xyz=xyz, rpy=rpy)
    ET.SubElement(joint, "parent", link=WORLD)
    ET.SubElement(joint, "child", link=f"{one.name}_{root}")
    return joint


def _root(robot: Robot) -> str:
    """Return the model's root link."""
    tree = _tree(robot.text.data)
    children = {child.get("link") for child in tree.iterfind("joint/child")}
    return next(link for link in robot.text.links if link not in children)


def _to_base(one: Placed, root: str) -> Pose:
    """Return the pose of a robot's base link in its model's root, all joints at zero."""
    pose, link = Pose(np.eye(3), np.zeros(3)), one.robot.base
    tree = _tree(one.urdf)
    above = {_link(joint, "child"): joint for joint in tree.findall("joint")}
    origins = scan(one.urdf, one.name).origins
    while link != root:
        joint = above[link]
        if joint.get("type") != "fixed":
            raise ModelError(
                f"{one.name}: joint {joint.get('name')!r} moves the base link {one.robot.base!r}; "
                "one URDF with all robots needs a base that stands"
            )
        pose = _after(pose_of(origins[str(joint.get("name"))]), pose)
        link = _link(joint, "parent")
    return pose


def _link(joint: ET.Element, end: str) -> str:
    """Return the name of a joint's parent or child link."""
    element = joint.find(end)
    return "" if element is None else element.get("link", "")


def _in_one_file(robots: Sequence[Placed]) -> bytes:
    """Return the one file with the calibrated origins of all chains."""
    first, text = robots[0].robot, robots[0].robot.text
    for one in robots[1:]:
        flange, ball = (one.robot.loaded_with.get(key) for key in ("flange", "ball"))
        if flange is not None and ball is not None and one.robot.tip not in text.links:
            x, y, z = ball
            text = scan(add_ball(text, flange, (x, y, z), one.robot.tip), first.source)
    changed: dict[str, Origin] = {}
    for one in reversed(robots):
        if one.robot.base != first.base:
            raise ModelError(
                f"{one.name}: base {one.robot.base!r}, but {robots[0].name} has {first.base!r}; "
                "chains of one URDF start at one link: give it by --base"
            )
        shared = 0
        while one.robot is not first and one.robot.joints[shared].name == first.joints[shared].name:
            if first.joints[shared].actuated:
                raise ModelError(
                    f"joint {first.joints[shared].name!r} moves both {robots[0].name} and "
                    f"{one.name}; give the link behind it by --base"
                )
            shared += 1
        origins = one.origins.copy()
        if one.robot is not first:
            before = _chain(one, shared)
            moved = _after(_after(before.inverse(), one.pose), before)
            own = _after(moved, pose_of(_origin_of(origins[shared])))
            origins[shared] = (*own.translation, *rpy_of(own.rotation))
        for joint, numbers in zip(one.robot.joints, origins, strict=True):
            changed[joint.name] = _origin_of(numbers)
    return set_origins(text, changed)


def _chain(one: Placed, count: int) -> Pose:
    """Return the pose after the first joints of a chain, none of which moves."""
    pose = Pose(np.eye(3), np.zeros(3))
    for numbers in one.origins[:count]:
        pose = _after(pose, pose_of(_origin_of(numbers)))
    return pose


def pose_of(origin: Origin) -> Pose:
    """Return a joint's origin as a pose."""
    return Pose(np.array(rotation_rpy(origin.rpy).full()), np.array(origin.xyz))


def _after(outer: Pose, inner: Pose) -> Pose:
    """Return a pose in the outer frame that is given in the inner one."""
    return Pose(outer.rotation @ inner.rotation, outer.apply(inner.translation[None])[0])


def _origin(pose: Pose) -> Origin:
    return _origin_of(np.array([*pose.translation, *rpy_of(pose.rotation)]))


def _origin_of(numbers: np.ndarray) -> Origin:
    x, y, z, roll, pitch, yaw = numbers.tolist()
    return Origin((x, y, z), (roll, pitch, yaw))


def rpy_of(rotation: np.ndarray) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    flat = float(np.hypot(rotation[0, 0], rotation[1, 0]))
    pitch = float(np.arctan2(-rotation[2, 0], flat))
    if flat < 1e-9:  # roll and yaw turn about one axis: all of it is called yaw
        return 0.0, pitch, float(np.arctan2(-rotation[0, 1], rotation[1, 1]))
    roll = float(np.arctan2(rotation[2, 1], rotation[2, 2]))
    return roll, pitch, float(np.arctan2(rotation[1, 0], rotation[0, 0]))

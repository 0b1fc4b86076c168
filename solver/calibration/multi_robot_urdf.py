"""One URDF with several robots, each where a calibration has it."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import takewhile
from pathlib import Path

from ..identification.data import IDENTITY, Pose
from ..identification.robot import (
    ModelError,
    Origin,
    Robot,
    add_link,
    find_chain,
    find_root,
    scan,
    set_origins,
)
from ..results import CalibratedRobot

WORLD = "world"


@dataclass(frozen=True)
class Placed:
    """A calibrated robot, and where its base stands."""

    name: str
    calibrated: CalibratedRobot
    pose: Pose
    """Of its base link in that of the first robot."""

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.calibrated.robot


def joined_urdf(robots: Sequence[Placed], folder: Path | None = None) -> bytes:
    """Return one URDF with all robots, in which meshes are found from a folder."""
    first = robots[0].robot
    # Different chains, and not one model several times.
    tips = {arm.robot.tip for arm in robots}
    if all(arm.robot.source == first.source for arm in robots) and len(tips) == len(
        robots
    ):
        return _in_one_file(robots)
    root = ET.Element("robot", name="_".join(arm.name for arm in robots))
    ET.SubElement(root, "link", name=WORLD)
    for arm in robots:
        urdf = arm.calibrated.urdf(folder)
        tree = ET.fromstring(urdf)  # noqa: S314 - it was refused if it defined any entity
        root.extend(list(_renamed(tree, arm.name)))
        root.append(_stand(arm, urdf))
    ET.indent(root)
    return b'<?xml version="1.0"?>\n' + ET.tostring(root) + b"\n"


def _renamed(tree: ET.Element, prefix: str) -> ET.Element:
    """Return a model with a prefix before the names of its links, joints and materials."""
    links = {e.get("name") for e in tree.findall("link")}
    joints = {e.get("name") for e in tree.findall("joint")}
    materials = {e.get("name") for e in tree.iter("material")}
    named = {"link": links, "joint": joints, "material": materials}
    references = {"link": links, "joint": joints, "reference": links | joints}
    for element in tree.iter():
        for key, names in {"name": named.get(element.tag, set()), **references}.items():
            value = element.get(key)
            if value and value in names:
                element.set(key, f"{prefix}_{value}")
    return tree


def _stand(arm: Placed, urdf: bytes) -> ET.Element:
    """Return the joint from the world to a robot's root."""
    text = arm.robot.text
    root = find_root(text)
    in_root = IDENTITY
    origins = scan(urdf, arm.name).origins
    for joint in find_chain(text, root, arm.robot.base):
        if joint.actuated:
            raise ModelError(
                f"{arm.name}: joint {joint.name!r} moves the base link {arm.robot.base!r}; "
                "one URDF with all robots needs a base that stands"
            )
        in_root = in_root @ Pose.of(origins[joint.name])
    origin = (arm.pose @ in_root.inverse()).origin
    stand = ET.Element("joint", name=f"{WORLD}_to_{arm.name}", type="fixed")
    xyz = " ".join(f"{value:.17g}" for value in origin.xyz)
    rpy = " ".join(f"{value:.17g}" for value in origin.rpy)
    ET.SubElement(stand, "origin", xyz=xyz, rpy=rpy)
    ET.SubElement(stand, "parent", link=WORLD)
    ET.SubElement(stand, "child", link=f"{arm.name}_{root}")
    return stand


def _in_one_file(robots: Sequence[Placed]) -> bytes:
    """Return the one file with the calibrated origins of all chains."""
    first = robots[0].robot
    text = first.text
    for arm in robots[1:]:
        flange = arm.robot.loaded_with.get("flange")
        if flange is not None and arm.robot.tip not in text.links:
            origin = arm.robot.ball_joint.origin
            with_ball = add_link(text, flange, origin, arm.robot.tip)
            text = scan(with_ball, first.source)
    changed: dict[str, Origin] = {}
    for arm in reversed(robots):
        if arm.robot.base != first.base:
            raise ModelError(
                f"{arm.name}: base {arm.robot.base!r}, but {robots[0].name} has {first.base!r}; "
                "chains of one URDF start at one link: give it by --base"
            )
        names = [joint.name for joint in arm.robot.joints]
        origins = list(map(Origin.of, arm.calibrated.origins))
        if arm.robot is not first:
            pairs = zip(first.joints, names, strict=False)
            shared = [
                joint
                for joint, _ in takewhile(lambda pair: pair[0].name == pair[1], pairs)
            ]
            moving = [joint.name for joint in shared if joint.actuated]
            if moving:
                raise ModelError(
                    f"joint {moving[0]!r} moves both {robots[0].name} and {arm.name}; give the "
                    "link behind it by --base"
                )
            k = len(shared)
            before = reduce(Pose.__matmul__, map(Pose.of, origins[:k]), IDENTITY)
            shift = before.inverse() @ arm.pose @ before
            origins[k] = (shift @ Pose.of(origins[k])).origin
        changed |= zip(names, origins, strict=True)
    return set_origins(text, changed)

"""The calibrated robot as an SDFormat model, for Gazebo and Drake, to the last digit.

A joint's pose is its URDF origin, relative to its parent link, and each link is posed relative to
the joint above it. The ball and the tools found are frames.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping

from .request import Exported, ExportError, Request, exported, plain

WORLD = "world"
"""No link of SDFormat may be called so: it is the world."""
LEAST_MASS = {"mass": "0.001", "inertia": "1e-06"}
"""Of links without any [kg, kg m2]: SDFormat takes 1 kg where it reads none."""
_TYPES = ("revolute", "continuous", "prismatic", "fixed")
_AT_JOINT = "0 0 0 0 0 0"
_DROPPED = ("gazebo", "ros2_control", "transmission")


def write(request: Request) -> Exported:
    """Return the model, with all links, joints, shapes and masses of the URDF."""
    calibrated = request.calibration.calibrated
    urdf = ET.fromstring(calibrated.urdf(request.file.parent))  # noqa: S314 - scanned before
    version = "1.9" if urdf.find("joint/mimic") is None else "1.11"
    sdf = ET.Element("sdf", version=version)
    about = "; ".join(request.identity.lines())
    sdf.append(ET.Comment(f" {about} "))
    model = ET.SubElement(sdf, "model", name=urdf.get("name", ""))
    links = [link for link in urdf.iterfind("link") if link.get("name") != WORLD]
    joints = list(urdf.iterfind("joint"))
    names = _names(links)
    renamed = {
        name: f"{name}_joint" if name in names else name for name in _names(joints)
    }
    above = {
        _link(joint, "child"): renamed[name]
        for name, joint in zip(_names(joints), joints, strict=True)
    }
    colors = _colors(urdf)
    for link in links:
        _add_link(model, link, above, colors)
    for joint in joints:
        _add_joint(model, joint, renamed)
    for name, (link, pose) in _frames(request).items():
        frame = ET.SubElement(model, "frame", name=name, attached_to=link)
        _add_pose(frame, pose)
    ET.indent(sdf)
    body = ET.tostring(sdf)
    text = b'<?xml version="1.0"?>\n%s\n' % body
    massless = _names(link for link in links if link.find("inertial") is None)
    lines = ["The ball is the frame mukca_ball; tools found are frames, too."]
    if massless:
        mass = f"{1e3 * float(LEAST_MASS['mass']):g} g"
        lines.append(f"Without a mass in the URDF, here {mass}: {', '.join(massless)}.")
    dropped = [tag for tag in _DROPPED if urdf.find(tag) is not None]
    if dropped:
        lines.append(f"Left out: what the URDF has in <{'>, <'.join(dropped)}>.")
    return exported(request, text, lines)


def _names(elements: Iterable[ET.Element]) -> list[str]:
    return [element.get("name", "") for element in elements]


def _attributes(element: ET.Element, tag: str) -> Mapping[str, str]:
    """Return the attributes of the first tag of a name in an element; none without it."""
    child = element.find(tag)
    return {} if child is None else child.attrib


def _link(joint: ET.Element, role: str) -> str:
    """Return the name of a joint's ``parent`` or ``child``."""
    return _attributes(joint, role).get("link", "")


def _frames(request: Request) -> dict[str, tuple[str, str]]:
    """Return the link and the pose in it of the ball and of each tool, by name."""
    ball = " ".join(map(repr, request.origins[-1].tolist()))
    parent = request.robot.ball_joint.parent
    frames = {"mukca_ball": (parent, ball)}
    for tool in request.calibration.document.tools:
        pose = " ".join(map(repr, [*tool.xyz, *tool.rpy]))
        frames[f"mukca_{plain(tool.name)}"] = (tool.parent, pose)
    return frames


def _add(parent: ET.Element, tag: str, text: str, **attributes: str) -> None:
    """Add a tag with a text."""
    ET.SubElement(parent, tag, attributes).text = text


def _add_pose(parent: ET.Element, pose: str, **attributes: str) -> None:
    """Add a pose: x y z [m] and roll pitch yaw [rad], as URDF has them."""
    _add(parent, "pose", pose, **attributes)


def _origin(element: ET.Element) -> str:
    """Return the origin of a URDF's element."""
    numbers = _attributes(element, "origin")
    xyz = numbers.get("xyz", "0 0 0")
    rpy = numbers.get("rpy", "0 0 0")
    return f"{xyz} {rpy}"


def _add_link(
    model: ET.Element,
    link: ET.Element,
    above: Mapping[str, str],
    colors: Mapping[str, str],
) -> None:
    """Add a link at the joint above it."""
    name = link.get("name", "")
    new = ET.SubElement(model, "link", name=name)
    if name in above:
        _add_pose(new, _AT_JOINT, relative_to=above[name])
    inertial = ET.SubElement(new, "inertial")
    urdf = link.find("inertial")
    if urdf is None:
        _add(inertial, "mass", LEAST_MASS["mass"])
        moments = {f"i{axis}": LEAST_MASS["inertia"] for axis in ("xx", "yy", "zz")}
    else:
        _add_pose(inertial, _origin(urdf))
        _add(inertial, "mass", _attributes(urdf, "mass").get("value") or "0")
        moments = _attributes(urdf, "inertia")
    tensor = ET.SubElement(inertial, "inertia")
    for key, moment in moments.items():
        _add(tensor, key, moment)
    for kind in ("visual", "collision"):
        for i, shape in enumerate(link.iterfind(kind)):
            tag = ET.SubElement(new, kind, name=f"{name}_{kind}_{i}")
            _add_shape(tag, shape, colors)


def _add_shape(new: ET.Element, shape: ET.Element, colors: Mapping[str, str]) -> None:
    """Fill in a visual or a collision."""
    _add_pose(new, _origin(shape))
    geometry = ET.SubElement(new, "geometry")
    for solid in shape.iterfind("geometry/*"):
        kind = ET.SubElement(geometry, solid.tag)
        for key, value in solid.attrib.items():
            name = "uri" if key == "filename" else key
            _add(kind, name, value.replace("package://", "model://", 1))
    material = shape.find("material")
    if material is None:
        return
    named = colors.get(material.get("name", ""))
    if rgba := _attributes(material, "color").get("rgba", named):
        looks = ET.SubElement(new, "material")
        _add(looks, "ambient", rgba)
        _add(looks, "diffuse", rgba)


def _colors(urdf: ET.Element) -> dict[str, str]:
    """Return the colours of the URDF's materials by name, which other links only name."""
    return {
        material.get("name", ""): _attributes(material, "color").get("rgba", "")
        for material in urdf.iter("material")
        if material.find("color") is not None
    }


def _add_joint(
    model: ET.Element, joint: ET.Element, renamed: Mapping[str, str]
) -> None:
    """Add a joint."""
    name = joint.get("name", "")
    kind = joint.get("type", "")
    if kind not in _TYPES:
        raise ExportError(f"--to sdformat: joint {name!r} is {kind}: not in SDFormat")
    new = ET.SubElement(model, "joint", name=renamed[name], type=kind)
    parent = _link(joint, "parent")
    frame = "__model__" if parent == WORLD else parent
    _add_pose(new, _origin(joint), relative_to=frame)
    _add(new, "parent", parent)
    _add(new, "child", _link(joint, "child"))
    if kind == "fixed":
        return
    axis = ET.SubElement(new, "axis")
    _add(axis, "xyz", _attributes(joint, "axis").get("xyz", "1 0 0"))
    mimic = joint.find("mimic")
    if mimic is not None:
        other = ET.SubElement(axis, "mimic", joint=renamed[mimic.get("joint", "")])
        for key, default in (("multiplier", "1"), ("offset", "0")):
            _add(other, key, mimic.get(key, default))
        _add(other, "reference", "0")
    for part in ("limit", "dynamics"):
        limits = ET.SubElement(axis, part)
        for key, value in _attributes(joint, part).items():
            if kind != "continuous" or key not in ("lower", "upper"):
                _add(limits, key, value)

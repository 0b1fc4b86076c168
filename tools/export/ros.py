"""Files for ROS: calibrated URDF with tools, a xacro macro, kinematics files of the makers."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from xml.sax.saxutils import quoteattr

import numpy as np

from ...errors import ON_FLANGE, ROTATION, read_beside
from ...solver.calibration import pose_of_numbers, quaternion_of
from ...solver.identification.robot import (
    COMPONENTS,
    ModelError,
    Origin,
    add_comment,
    add_link,
    scan,
)
from .request import (
    Exported,
    ExportError,
    Request,
    after_last_exported,
    exported,
    filled,
    plain,
    redistributed_origins,
)

SAME_ROBOT = 0.02
"""Largest distance of an origin in a file of the same robot from nominal [m]."""


@dataclass(frozen=True, kw_only=True)
class Vendor:
    """One maker's file, as ``vendors.json`` has it."""

    makes: str
    keys: Mapping[str, str]
    """The key of each joint, by the end of the joint's name in the maker's URDF."""
    root: str
    """Ending of the name of the first joint's parent link."""
    outer: Sequence[str] = ()
    inner: Sequence[str] = ()
    """Keys round all joints, and round the numbers of each."""
    lines: Sequence[str] = ()


def write(request: Request) -> Exported:
    """Return the file of the maker that ``request.format`` names."""
    tables = read_beside(__file__, "vendors.json")
    vendor = Vendor(**tables[request.format])
    keys = _keys(request, vendor)
    lines = list(vendor.lines)
    name = ""
    if request.format == "ur":
        name, note = _hash(request, keys)
        lines.append(note)
    origins = {
        keys[joint]: dict(zip(COMPONENTS, map(_number, origin.tolist()), strict=True))
        for joint, origin in redistributed_origins(request, keys).items()
    }
    content = filled(
        "kinematics.yaml.j2",
        about=request.identity.lines(),
        identity=request.identity.in_yaml,
        outer=vendor.outer,
        inner=vendor.inner,
        origins=origins,
        hash=name,
    )
    return exported(request, content, lines, after_last_exported(request, keys))


def _keys(request: Request, vendor: Vendor) -> dict[str, str]:
    """Return the file's key of each joint it carries."""
    robot = request.robot
    keys: dict[str, str] = {}
    for joint, (suffix, key) in product(robot.joints, vendor.keys.items()):
        if re.search(rf"(^|[_/]){suffix}$", joint.name):
            keys.setdefault(joint.name, key)
    moving = set(robot.joint_names)
    first = next((joint for joint in robot.joints if joint.name in keys), None)
    complete = (
        set(keys.values()) == set(vendor.keys.values()) or request.format == "xarm"
    )
    fits = complete and moving <= set(keys)
    if first and fits and first.parent.endswith(vendor.root):
        return keys
    # joint1 .. are many makers' names.
    if first is None or not fits or request.format == "xarm":
        raise ExportError(
            f"--to {request.format}: {robot.name} does not have the joints of {vendor.makes}, "
            f"{', '.join(vendor.keys)} from a link {vendor.root}; --to xacro works for any arm"
        )
    ending = next(key for key in vendor.keys if first.name.endswith(key))
    prefix = first.name.removesuffix(ending)
    raise ExportError(
        f"--to {request.format}: the parent of {first.name} is {first.parent}, in {vendor.makes} "
        f"{prefix}{vendor.root}; solve by a model with that link and --base {prefix}{vendor.root}; "
        "--to xacro works for any arm"
    )


def write_tesseract(request: Request) -> Exported:
    """Return the calibration that an SRDF of Tesseract names, without the ball's joint."""
    joints = request.robot.joints[:-1]
    poses = pose_of_numbers(request.origins[:-1])
    turns = quaternion_of(poses[:, :3, :3])
    places = poses[:, :3, 3].tolist()
    rows = [
        (json.dumps(joint.name), list(map(_number, place)), list(map(_number, turn)))
        for joint, place, turn in zip(joints, places, turns.tolist(), strict=True)
    ]
    about = request.identity.lines()
    content = filled("tesseract.yaml.j2", about=about, joints=rows)
    ball = request.robot.ball_joint.name
    line = f'Name it in the SRDF: <calibration_config filename="{request.file.name}"/>'
    return exported(request, content, (line,), [ball])


def _number(value: float) -> str:
    """Return a number that every YAML reader takes for one: 1e-05 is text to some of them."""
    mantissa, e, exponent = repr(value).partition("e")
    return f"{mantissa}.0e{exponent}" if e and "." not in mantissa else repr(value)


def _hash(request: Request, keys: Mapping[str, str]) -> tuple[str, str]:
    """Return the key ``hash``, the maker's digest of the factory calibration, and a line on it."""
    like = request.like
    if not like:
        return (
            f"mukca_{request.identity.sha256[:16]}",
            "The driver will log once that the calibration parameters do not match the robot's, "
            "since `hash` is not the robot's own; that is harmless. --like takes it from the "
            "file that ur_calibration wrote.",
        )
    text, sections = _read(request)
    nominal = {joint.name: joint.origin.xyz for joint in request.robot.joints}
    for name, key in keys.items():
        numbers = sections.get(key, {})
        xyz = [numbers.get(c, float("nan")) for c in "xyz"]
        if not np.linalg.norm(np.subtract(xyz, nominal[name])) < SAME_ROBOT:
            raise ExportError(
                f"{like}: another robot's: `{key}` does not stand where "
                f"{request.robot.name} has it"
            )
    match = re.search(r"^\s*hash:\s*[\"']?([\w.-]+)[\"']?\s*$", text, re.M)
    if not match:
        raise ExportError(f"{like}: no `hash`; give the file that ur_calibration wrote")
    return match[1], f"`hash` is the robot's own, from {like}."


def _read(request: Request) -> tuple[str, dict[str, dict[str, float]]]:
    """Return the text of the user's file without comments, and its numbers by section and key."""
    text = re.sub(r"#.*", "", request.like_text())
    sections: dict[str, dict[str, float]] = {}
    section = ""
    words: Sequence[tuple[str, str]] = re.findall(
        r"([\w-]+)\s*:[ \t]*([-+.\d][-+.\deE]*)?", text
    )
    for key, number in words:
        try:
            sections.setdefault(section, {})[key] = float(number)
        except ValueError:
            section = key
    return text, sections


def write_urdf(request: Request) -> Exported:
    """Return the URDF; mesh paths are rewritten to be found from where it will stand."""
    robot = request.robot
    flange = request.flange
    name = str(request.file)
    text = scan(request.calibration.calibrated.urdf(request.file.parent), name)
    text = scan(add_comment(text, request.identity.lines()), name)
    if flange not in text.links:
        raise ExportError(f"--flange {flange}: no link of {robot.name} is called so")
    tools = request.options.get("tools", {})
    for tool, numbers in tools.items():
        if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
            raise ExportError(
                f"--tool {tool}={','.join(f'{number:g}' for number in numbers)}: give a place in "
                "metres and a turn in radians, as in --tool gripper=0,0,0.12,0,0,1.57"
            )
        x, y, z, roll, pitch, yaw = numbers
        origin = Origin((x, y, z), (roll, pitch, yaw))
        doubts = {
            "place": ON_FLANGE.doubt(origin.xyz),
            "turn": ROTATION.doubt(origin.rpy),
        }
        for part, doubt in doubts.items():
            if doubt:
                raise ExportError(f"--tool {tool}: {part}: {doubt}")
        try:
            text = scan(add_link(text, flange, origin, tool), name)
        except ModelError as error:
            raise ExportError(f"--tool {tool}: {error}") from None
    lines = tuple(f"{tool} stands fixed on {flange}" for tool in tools)
    return exported(request, text.data, lines)


def write_xacro(request: Request) -> Exported:
    """Return a file for any robot's xacro: a macro that stands for each joint's origin."""
    joints = request.robot.joints
    entries: list[str] = []
    for joint, origin in zip(joints, request.origins.tolist(), strict=True):
        if any(mark in joint.name for mark in "'\\{}$"):
            raise ExportError(
                f"joint {joint.name!r}: xacro cannot say that name; rename it"
            )
        xyz = " ".join(map(repr, origin[:3]))
        rpy = " ".join(map(repr, origin[3:]))
        entries.append(f"('{joint.name}', dict(xyz='{xyz}', rpy='{rpy}'))")
    rows = ",\n    ".join(entries)
    table = quoteattr(f"${{dict([\n    {rows}])}}").replace("&#10;", "\n")
    about, joint = request.identity.lines(), plain(joints[0].name)
    content = filled("origins.xacro.j2", about=about, joint=joint, table=table)
    lines = (
        f'In the robot\'s xacro, write  <xacro:include filename="{request.file.name}"/>',
        "In each of its joints, replace the <origin> by one with that joint's name, as in  "
        f'<xacro:calibrated_origin joint="{joints[0].name}"/>',
    )
    return exported(request, content, lines)

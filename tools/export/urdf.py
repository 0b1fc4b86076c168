"""The calibrated URDF with tools fixed to its flange, and a xacro file of its joint origins."""

import math
from xml.sax.saxutils import quoteattr

from ...solver.robot import ModelError, Origin, add_comment, add_link, scan
from .request import Exported, ExportError, Request, losses_without


def write(request: Request) -> Exported:
    """Return the URDF; mesh paths are rewritten to be found from where it will stand."""
    robot, flange = request.calibration.robot, request.flange
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
        try:
            data = add_link(text, flange, Origin((x, y, z), (roll, pitch, yaw)), tool)
        except ModelError as error:
            raise ExportError(f"--tool {tool}: {error}") from None
        text = scan(data, name)
    lines = tuple(f"{tool} stands fixed on {flange}" for tool in tools)
    return Exported({request.file.name: text.data}, losses_without(request), lines)


def write_xacro(request: Request) -> Exported:
    """Return a file for any robot's xacro: a macro that stands for each joint's origin."""
    request.require_ending(".xacro")
    joints = request.calibration.robot.joints
    entries: list[str] = []
    for joint, origin in zip(joints, request.origins.tolist(), strict=True):
        if any(mark in joint.name for mark in "'\\{}$"):
            raise ExportError(f"joint {joint.name!r}: xacro cannot say that name; rename it")
        xyz, rpy = (" ".join(map(repr, part)) for part in (origin[:3], origin[3:]))
        entries.append(f"('{joint.name}', dict(xyz='{xyz}', rpy='{rpy}'))")
    table = quoteattr("${dict([\n    " + ",\n    ".join(entries) + "])}").replace("&#10;", "\n")
    said = "\n     ".join(line.replace("--", "-") for line in request.identity.lines())
    content = f"""<?xml version="1.0"?>
<!-- {said}
     Include this file, and put the macro into each of these joints instead of its origin:
     <xacro:calibrated_origin joint="{joints[0].name}"/> -->
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="calibrated_origins" value={table}/>
  <xacro:macro name="calibrated_origin" params="joint">
    <origin xyz="${{calibrated_origins[joint]['xyz']}}"
            rpy="${{calibrated_origins[joint]['rpy']}}"/>
  </xacro:macro>
</robot>
"""
    lines = (
        f'Include it by  <xacro:include filename="{request.file.name}"/>  and write  '
        f'<xacro:calibrated_origin joint="{joints[0].name}"/>  instead of the <origin> of each of '
        "its joints.",
    )
    return Exported({request.file.name: content.encode()}, losses_without(request), lines)

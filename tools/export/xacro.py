"""A xacro file that any robot's own xacro can include: its calibrated joint origins."""

from xml.sax.saxutils import quoteattr

from .losses import losses_without
from .request import Exported, ExportError, Request


def write(request: Request) -> Exported:
    """Return a file with a macro that stands for the ``<origin>`` of each joint."""
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

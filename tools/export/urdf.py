"""The calibrated URDF, with tools fixed to its flange."""

import math

from ...solver.robot import ModelError, Origin, add_comment, add_link, scan
from .losses import losses_without
from .request import Exported, ExportError, Request


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

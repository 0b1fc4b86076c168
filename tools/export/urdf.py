"""The calibrated URDF, with tools fixed to its flange."""

from ...solver.robot import ModelError, Origin, add_comment, add_link, scan
from .export import Exported, ExportError, Request, losses_without


def export(request: Request) -> Exported:
    """Return the URDF; mesh paths are rewritten to be found from where it will stand."""
    robot = request.calibration.robot
    flange = request.flange or robot.ball_joint.parent
    name = str(request.file)
    text = scan(request.calibration.calibrated.urdf(request.file.parent), name)
    text = scan(add_comment(text, request.identity.lines()), name)
    if flange not in text.links:
        raise ExportError(f"--flange {flange}: no link of {robot.name} is called so")
    for tool, numbers in request.tools.items():
        x, y, z, roll, pitch, yaw = numbers
        try:
            data = add_link(text, flange, Origin((x, y, z), (roll, pitch, yaw)), tool)
        except ModelError as error:
            raise ExportError(f"--tool {tool}: {error}") from None
        text = scan(data, name)
    lines = tuple(f"{tool} stands fixed on {flange}" for tool in request.tools)
    return Exported({request.file.name: text.data}, losses_without(request, ()), lines)

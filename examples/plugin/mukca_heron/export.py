"""Calibrated origins of joints as the Heron reads them: ``NAME x y z roll pitch yaw``."""

from mukca.tools.export import Exported, Request, losses_without


def write(request: Request) -> Exported:
    """Return the file, with what it cannot say [m, rad]."""
    request.require_ending(".heron")
    robot = request.calibration.robot
    rows = zip(robot.joints, request.origins.tolist(), strict=True)
    lines = [f"# {line}" for line in request.identity.lines()]
    lines += [f"{joint.name} {' '.join(map(str, origin))}" for joint, origin in rows]
    files = {request.file.name: "\n".join([*lines, ""]).encode()}
    return Exported(files, losses_without(request))

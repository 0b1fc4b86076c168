"""Warnings of a robot's model that its recordings are fitted to, and refusals of it."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .. import results
from ..data import Measurement
from ..robot import Parameter, Robot, choose_parameters
from .option import UsageError
from .options import SolveOptions

LOCKED = math.radians(6)
"""A pitch nearer than this to 90 degrees leaves roll and yaw hardly two turns."""


def held_as_exact(robot: Robot, options: SolveOptions) -> list[str]:
    """Return what a few free numbers of a calibrated URDF cannot know."""
    file = Path(robot.source).with_name("calibration.json")
    if not options.free or options.prior or Path(robot.source).suffix != ".urdf":
        return []
    try:
        calibrated = results.calibrated_robot(results.read_calibration(file), str(file))
    except results.DocumentError:
        return []
    same = robot.joint_names == calibrated.robot.joint_names
    if not same or not np.array_equal(robot.origins, calibrated.origins):
        return []
    return [
        f"{robot.source}: calibrated, and --free takes the rest of it for exact: neither its "
        f"elasticity nor how well it is known is in a URDF. mukca rezero, tool or handeye {file} "
        f"hold it with both; mukca solve --prior {file} fits all of it again"
    ]


def locked_angles(robot: Robot, options: SolveOptions) -> list[str]:
    """Return a warning of joints whose roll and yaw are nearly one turn, which the paper fits."""
    variable = {
        p.joint for p in choose_parameters(robot, options.free, options.fix) if p.unit == "rad"
    }
    joints = [joint for joint in robot.joints if joint.name in variable and joint.actuated]
    locked = [j.name for j in joints if abs(math.cos(j.origin.rpy[1])) < math.sin(LOCKED)]
    if options.method != "paper" or not locked:
        return []
    return [
        f"{', '.join(locked)}: a pitch near 90 degrees makes roll and yaw one turn, and the third "
        "turn is lost to --method paper; --method auto has all three"
    ]


def weightless(robot: Robot, data: Sequence[Measurement], options: SolveOptions) -> list[str]:
    """Return a warning of a model without masses, whose arm does not bend under its weight."""
    if robot.bodies or options.method == "paper" or all(m.efforts is not None for m in data):
        return []
    return [
        f"{robot.source}: the URDF has no masses, so how the arm bends under its weight is not "
        "fitted; give its links <inertial> with <mass> and <origin>"
    ]


def check_zeros(robot: Robot, parameters: Sequence[Parameter], options: SolveOptions) -> None:
    """Refuse zeros that the URDF could not hold."""
    variable = {parameter.name for parameter in parameters}
    for joint in robot.actuated if options.zeros else ():
        angles = {f"{joint.name}.{angle}" for angle in ("roll", "pitch", "yaw")}
        if joint.type == "prismatic" or not angles <= variable:
            raise UsageError(f"--zeros: {joint.name} must turn, and its angles be free")

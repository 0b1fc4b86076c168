"""Warnings of a robot's model that its recordings are fitted to, and refusals of it."""

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .. import results
from ..identification.robot import Robot, choose_parameters
from .option import UsageError
from .options import SolveOptions

LOCKED = math.radians(6)
"""A pitch nearer than this to 90 degrees leaves roll and yaw hardly two turns."""


def model_warnings(robot: Robot, options: SolveOptions) -> Iterator[str]:
    """Yield what is to be said of a robot's model before its recordings are fitted."""
    if options.free and not options.prior and Path(robot.source).suffix == ".urdf":
        yield from _held_as_exact(robot)
    if options.method == "paper":
        yield from _locked_angles(robot, options)
    elif robot.masses_assumed:
        yield (
            f"{robot.source}: the URDF has no masses; each link counts as a mass half way to the "
            "next joint, so stiffnesses are right but for a common factor, and efforts do not count"
        )


def _held_as_exact(robot: Robot) -> Iterator[str]:
    """Yield what a few free numbers of a calibrated URDF cannot know."""
    file = Path(robot.source).with_name("calibration.json")
    try:
        # A URDF with other meshes, or a further link, has the same origins.
        document = results.read(file, results.CalibrationDocument, results.FORMAT)
        calibrated = results.calibrated_robot(document, str(file))
    except results.DocumentError:
        return
    same = robot.joint_names == calibrated.robot.joint_names
    if same and np.array_equal(robot.origins, calibrated.origins):
        yield (
            f"{robot.source}: calibrated, and --free takes the rest of it for exact: neither its "
            "elasticity nor how well it is known is in a URDF. mukca rezero, tool or handeye "
            f"{file} hold it with both; mukca solve --prior {file} fits all of it again"
        )


def _locked_angles(robot: Robot, options: SolveOptions) -> Iterator[str]:
    """Yield a warning of joints whose roll and yaw are nearly one turn, which the paper fits."""
    parameters = choose_parameters(robot, options.free, options.fix)
    variable = {parameter.joint for parameter in parameters if parameter.unit == "rad"}
    joints = [joint for joint in robot.actuated if joint.name in variable]
    near = math.sin(LOCKED)
    locked = [
        joint.name for joint in joints if abs(math.cos(joint.origin.rpy[1])) < near
    ]
    if locked:
        yield (
            f"{', '.join(locked)}: a pitch near 90 degrees makes roll and yaw one turn, and the "
            "third turn is lost to --method paper; --method auto has all three"
        )


def check_zeros(robot: Robot, options: SolveOptions) -> None:
    """Refuse to look for zeros where the URDF could hold none."""
    parameters = choose_parameters(robot, options.free, options.fix)
    angles = Counter(
        parameter.joint for parameter in parameters if parameter.unit == "rad"
    )
    turning = [joint for joint in robot.actuated if joint.type != "prismatic"]
    if options.zeros and not any(angles[joint.name] == 3 for joint in turning):
        raise UsageError("--zeros: a joint must turn, and its angles be free")

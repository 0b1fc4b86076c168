"""A calibration with something found since: zeros of joints, or a tool."""

from collections.abc import Sequence
from itertools import starmap

import msgspec
import numpy as np

from ..bayes.model.effects import EFFECTS, JOINT_OFFSET
from ..bayes.results import offsets_in_origins
from ..calibration import Calibration
from ..results import (
    CalibratedRobot,
    CalibrationDocument,
    Coefficient,
    LaterZero,
    ParameterValue,
    ToolFrame,
    calibrated_robot,
)
from ..robot import BallModel, Origin, Robot, add_link, all_parameters, scan


def with_zeros(calibration: Calibration, later: Sequence[LaterZero]) -> Calibration:
    """Return a calibration whose joints have other zeros since.

    The geometry and everything else stay. The samples in it are put into the new readings' terms,
    so that its errors stay, too.

    Args:
        calibration: The calibration.
        later: What has to be added to the readings of each joint that changed.
    """
    document, robot = calibration.document, calibration.robot
    names = robot.joint_names
    offsets, known = np.zeros(len(names)), {zero.joint: zero for zero in document.later_zeros}
    for zero in later:
        offsets[names.index(zero.joint)] = zero.offset
        before = known[zero.joint].offset if zero.joint in known else 0.0
        known[zero.joint] = msgspec.structs.replace(zero, offset=before + zero.offset)
    old = dict(document.deflection)
    zeros = np.array(old.get(JOINT_OFFSET.name, np.zeros(len(names)))) + offsets
    deflection = {JOINT_OFFSET.name: tuple(zeros.tolist()), **old}
    deflection[JOINT_OFFSET.name] = tuple(zeros.tolist())
    ordered = {name: deflection[name] for name in EFFECTS if name in deflection}
    calibrated = calibration.calibrated
    exported = offsets_in_origins(
        calibrated.model, calibrated.parameters, calibrated.geometry, offsets
    )
    coefficients = {one.name: one for one in document.coefficients or ()}
    for name, value, joint in zip(
        JOINT_OFFSET.coefficient_names(names), zeros.tolist(), names, strict=True
    ):
        if joint in known:
            deviation = known[joint].standard_deviation
            coefficients[name] = Coefficient(
                name=name, unit="rad", value=value, standard_deviation=deviation
            )
    return _calibration(
        msgspec.structs.replace(
            document,
            later_zeros=tuple(known.values()),
            deflection=ordered,
            coefficients=tuple(coefficients.values()),
            parameters=tuple(starmap(_exported, zip(document.parameters, exported, strict=True))),
            data=tuple(data.shifted((-offsets).tolist()) for data in document.data),
        ),
        calibration.source,
    )


def urdf_with_zeros(robot: Robot, offsets: Sequence[float]) -> bytes:
    """Return the URDF of a nominal robot with zeros of its joints [rad] put into its origins."""
    parameters = all_parameters(robot)
    model = BallModel(robot, [p.index for p in parameters])
    values = offsets_in_origins(model, parameters, model.nominal, np.array(offsets))
    return CalibratedRobot(robot, tuple(parameters), values).urdf()


def with_tool(calibration: Calibration, tool: ToolFrame) -> Calibration:
    """Return a calibration whose robot has one more link, fixed to the flange.

    Raises:
        ModelError: The model already has such a link.
    """
    document, robot = calibration.document, calibration.robot
    origin = Origin(tool.xyz, tool.rpy)
    text = add_link(robot.text, robot.ball_joint.parent, origin, tool.name)
    model = msgspec.structs.replace(document.model, nominal_urdf=text.decode())
    tools = (*document.tools, tool)
    scan(text, "nominal_urdf")
    return _calibration(
        msgspec.structs.replace(document, model=model, tools=tools), calibration.source
    )


def _calibration(document: CalibrationDocument, source: str) -> Calibration:
    """Return the calibration of a document whose robot changed."""
    calibrated = calibrated_robot(document, source)
    model = msgspec.structs.replace(document.model, calibrated_urdf=calibrated.urdf().decode())
    return Calibration(msgspec.structs.replace(document, model=model), calibrated, source)


def _exported(value: ParameterValue, exported: float) -> ParameterValue:
    return msgspec.structs.replace(value, exported=float(exported))

"""The robot of a ``calibration.json``, whose arrays fit each other and whose names are there."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ...errors import JOINT_POSITION, LENGTH, MukcaError
from ...recorder import LAST_SOCKET
from ..identification.effects import EFFECTS
from ..identification.model import Deflection
from ..identification.robot import Robot, all_parameters, parse_robot, scan
from .calibrated import CalibratedRobot
from .calibration import CalibrationDocument, misfit
from .placements import PlacementSamples, RecordedSample

DEGREES = 360
"""Values of an error curve, one a degree."""


def calibrated_robot(document: CalibrationDocument, source: str) -> CalibratedRobot:
    """Return the robot that a calibration describes, which messages name by its source."""
    model = document.model
    try:
        text = scan(model.nominal_urdf.encode(), "nominal_urdf")
        text.source = model.source
        robot = parse_robot(text, base=model.base, tip=model.tip)
        # Older files have the tilts of the frames' axes.
        if document.rotation_numbers == "rpy":
            joints = tuple(replace(joint, tilt_axes=None) for joint in robot.joints)
            robot = replace(robot, joints=joints)
    except MukcaError as error:
        raise misfit(source, "model", str(error)) from None
    values = {value.name: value for value in document.parameters}
    parameters = tuple(p for p in all_parameters(robot) if p.name in values)
    if not len(parameters) == len(values) == len(document.parameters):
        raise misfit(
            source, "parameters", "not those of the joints of model.nominal_urdf"
        )
    for key, words in _conflicts(document, robot):
        raise misfit(source, key, words)
    calibrated = np.array([values[p.name].calibrated for p in parameters], dtype=float)
    exported = np.array([values[p.name].exported for p in parameters], dtype=float)
    deflection = Deflection(
        tuple(document.deflection), tuple(map(np.array, document.deflection.values()))
    )
    return CalibratedRobot(
        robot,
        parameters,
        calibrated,
        deflection,
        document.load,
        exported if document.deflection else None,
        document.rotation_numbers,
    )


def _conflicts(
    document: CalibrationDocument, robot: Robot
) -> Iterator[tuple[str, str]]:
    """Yield the keys of a document that do not fit its robot or its other keys, and why.

    Args:
        document: All of ``calibration.json``.
        robot: The robot of its model.
    """
    names = robot.joint_names
    if document.model.joint_names != names:
        yield "model.joint_names", f"the URDF has {', '.join(names)}"
    for extension, coefficients in document.deflection.items():
        effect = EFFECTS.get(extension)
        expected = len(effect.coefficient_names(names)) if effect else 0
        if effect is None:
            yield f"deflection.{extension}", "no extension of this version"
        elif len(coefficients) != expected:
            words = f"{len(coefficients)} coefficients, but the joints need {expected}"
            yield f"deflection.{extension}", words
    for i, placement in enumerate(document.data):
        for key, words in _of_placement(placement, len(names)):
            yield f"data[{i}].{key}", words
    stored = document.posterior
    if stored is not None:
        kinds = {
            "sockets" if p.samples[0].point is None else "points" for p in document.data
        }
        if absent := kinds.difference(stored.noises):
            yield "posterior.noises", f"none of {', '.join(absent)}"
    yield from _of_estimates(document, names)


def _of_estimates(
    document: CalibrationDocument, names: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """Yield the zeros, curves and tools that are not of joints of these names, and why."""
    curves = document.curves.joints if document.curves else ()
    for i, zero in enumerate(document.later_zeros):
        if zero.joint not in names:
            yield f"later_zeros[{i}]", f"no joint is called {zero.joint!r:.60}"
    for i, curve in enumerate(curves):
        if curve.joint not in names:
            yield f"curves.joints[{i}]", f"no joint is called {curve.joint!r:.60}"
        if not len(curve.values) == len(curve.deviations) == DEGREES:
            yield f"curves.joints[{i}]", f"{DEGREES} values and deviations are needed"
    for i, tool in enumerate(document.tools):
        if np.array(tool.covariance, dtype=object).shape != (3, 3):
            yield f"tools[{i}].covariance", "three rows of three numbers are needed"


def _of_placement(
    placement: PlacementSamples, joints: int
) -> Iterator[tuple[str, str]]:
    """Yield the keys of a placement's samples that do not fit so many joints, and why."""
    if not placement.samples:
        yield "samples", "none"
    if not 0 <= placement.distance <= LENGTH.largest:
        yield "distance", f"{placement.distance:g} m"
    for i, sample in enumerate(placement.samples):
        for key, words in _of_sample(sample, joints):
            yield f"samples[{i}].{key}", words
    for key in ("point", "orientation"):
        kinds = {getattr(sample, key) is None for sample in placement.samples}
        if len(kinds) > 1:
            yield f"samples.{key}", "some samples have it, and some do not"


def _of_sample(sample: RecordedSample, joints: int) -> Iterator[tuple[str, str]]:
    """Yield the keys of a sample that do not fit so many joints, and why."""
    for key in ("position", "effort"):
        values = getattr(sample, key)
        if values is not None and len(values) != joints:
            yield key, f"{len(values)} numbers, but the robot has {joints} joints"
    if doubt := JOINT_POSITION.doubt(sample.position):
        yield "position", doubt
    if not 0 <= sample.socket <= LAST_SOCKET:
        yield "socket", f"{sample.socket} is not from 0 to {LAST_SOCKET}"
    if sample.orientation is not None and not any(sample.orientation):
        yield "orientation", "no quaternion has length 0"

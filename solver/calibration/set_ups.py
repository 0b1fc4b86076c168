"""An instrument that is set up anew for each placement: its frame, and its target on the flange."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...recorder import Sample
from ..identification.data import FrameError, HandEye, Measurement, hand_eye
from ..identification.robot import Robot
from ..results import CalibratedRobot
from .poses import quaternion_of
from .problem import CalibrationProblem

ENOUGH = 10
"""Samples that tell where a frame and a target are, by themselves."""
FAR_TURNED = 0.1
"""A target turned by more between two placements was put on otherwise [rad]; the fit has unknowns
for less."""


def set_up_anew(problem: CalibrationProblem) -> CalibrationProblem:
    """Return recordings of one robot, each placement of points in a frame of its own.

    A tracker is set up anew from day to day, and so is its target. Several robots are tied by what
    was measured in one frame, and so are measured sockets: those frames stay.
    """
    if problem.name or problem.options.as_recorded:
        return problem
    tied = {item.frame for item in problem.options.located}
    first: dict[str, Measurement] = {}
    measurements: list[Measurement] = []
    warnings = list(problem.warnings)
    for m in problem.measurements:
        if not is_own(m) or m.frame in tied:
            measurements.append(m)
            continue
        other = first.setdefault(m.frame, m)
        if other is not m:
            m, words = _as_first(problem.robot, m, other)
            warnings += words
            m = in_own_frame(m)
        measurements.append(m)
    return replace(problem, measurements=tuple(measurements), warnings=tuple(warnings))


def is_own(measured: Measurement) -> bool:
    """Tell whether an instrument measured enough to find its frame and target by this alone."""
    return measured.kind == "points" and len(measured.points) >= ENOUGH


def in_own_frame(measured: Measurement) -> Measurement:
    """Return a placement in a frame of its own."""
    frame = f"{measured.frame} at {measured.name}"
    return replace(measured, placement=replace(measured.placement, frame=frame))


def _as_first(
    robot: Robot, measured: Measurement, first: Measurement
) -> tuple[Measurement, Sequence[str]]:
    """Return measured poses of a target as if it sat as it did first, where it is turned by far."""
    if not (measured.has_orientations and first.has_orientations):
        return measured, ()
    try:
        tool, tool_first = (_on_nominal(robot, m).tool for m in (measured, first))
    except FrameError:
        return measured, ()
    change = tool.inverse() @ tool_first
    cosine = (np.trace(change.rotation) - 1) / 2
    angle = float(np.arccos(np.clip(cosine, -1, 1)))
    if angle < FAR_TURNED:
        return measured, ()
    M = measured.rotations
    points = measured.points + M @ change.translation
    turned_back = with_points(measured, points, M @ change.rotation)
    words = (
        f"{measured.name}: the target is turned by {np.rad2deg(angle):.0f} deg from that of "
        f"{first.name}; taken as turned back"
    )
    return turned_back, [words]


def _on_nominal(robot: Robot, measured: Measurement) -> HandEye:
    """Return frame and target of measured poses by the nominal robot."""
    nominal = CalibratedRobot(robot)
    R, p = nominal.rotations(measured), nominal.predict(measured)
    where = str(measured.placement.where)
    return hand_eye(R, p, measured.rotations, measured.points, where)


def with_points(
    measured: Measurement, points: np.ndarray, rotations: np.ndarray | None = None
) -> Measurement:
    """Return a placement with other measured points, and orientations."""
    samples: list[Sample] = []
    for k, sample in enumerate(measured.placement.samples):
        x, y, z = points[k].tolist()
        sample = replace(sample, point=(x, y, z))
        if rotations is not None:
            (turn,) = quaternion_of(rotations[[k]]).tolist()
            sample = replace(sample, orientation=tuple(turn))
        samples.append(sample)
    placement = replace(measured.placement, samples=tuple(samples))
    return replace(measured, placement=placement)

"""An instrument that is set up anew for each placement: its frame, and its target on the flange.

Checks see recordings as if one target sat alike everywhere, wherever each set-up has its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...errors import NotConverged
from ...recorder import Sample
from ..identification.data import (
    FrameError,
    Measurement,
    Pose,
    RobotRecordings,
    as_point,
    check_handedness,
    evaluate,
    fit_pose,
    hand_eye,
    nearest_rotation,
    observe,
    tip_shift,
)
from ..identification.inference import estimate
from ..identification.model import extend
from ..identification.robot import Robot, choose_parameters
from ..identification.selection import set_ups
from ..results import CalibratedRobot
from .fit import CalibrationProblem
from .poses import quaternion_of

ENOUGH = 10
"""Samples that tell where a frame and a target are, by themselves."""
FAR_TURNED = 0.1
"""A target turned by more between two placements was put on otherwise [rad]; the fit has unknowns
for less."""


def right_handed(problem: CalibrationProblem) -> CalibrationProblem:
    """Return recordings whose points no mirror explains far better than the nominal robot.

    Joints of other signs may explain a mirror exactly: so this comes before all explanations.
    One sign that explains as much is simpler.

    Raises:
        FrameError: Coordinates are left-handed.
    """
    nominal = CalibratedRobot(problem.robot)
    for m in (m for _, m in problem.placements if is_own(m)):
        balls = nominal.predict(m)
        mirror = evaluate(balls, with_points(m, -m.points)).mean_absolute_error
        signs = 2 * m.positions[:, None] * np.eye(m.positions.shape[1])  # (N, m, m)
        flipped = [nominal.predict(m.shifted(-turn)) for turn in signs.swapaxes(0, 1)]
        if all(evaluate(one, m).mean_absolute_error > mirror for one in flipped):
            what = f"{m.wheres[0]}: coordinates of frame {m.frame!r}"
            check_handedness(m.points, balls, what)
    return problem


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
    nominal = CalibratedRobot(robot)
    tools: list[Pose] = []
    for m in (measured, first):
        p, R, _ = nominal.tips(m)
        try:
            by_both = hand_eye(R, p, m.rotations, m.points, str(m.placement.where))
        except FrameError:
            return measured, ()
        tools.append(by_both.tool)
    change = tools[0].inverse() @ tools[1]
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


def with_points(
    measured: Measurement, points: np.ndarray, rotations: np.ndarray | None = None
) -> Measurement:
    """Return a placement with other measured points, and orientations."""
    samples: list[Sample] = []
    for k, sample in enumerate(measured.placement.samples):
        sample = replace(sample, point=as_point(points[k]))
        if rotations is not None:
            (turn,) = quaternion_of(rotations[[k]]).tolist()
            sample = replace(sample, orientation=tuple(turn))
        samples.append(sample)
    placement = replace(measured.placement, samples=tuple(samples))
    return replace(measured, placement=placement)


MOST = 200
"""Samples of a placement by which set-ups are compared."""
SHARE = 0.5
"""Share of the error that a frame and target of its own leave at most, if a placement has them."""

Originals = Mapping[object, Sample]
"""Samples as they were recorded, by the points of those aligned."""


def aligned(problem: CalibrationProblem) -> tuple[CalibrationProblem, Originals]:
    """Return recordings as if all targets sat alike, by a rigid fit, and the samples as recorded.

    With shift d of a target in its link, R_i its orientation, and F the frame, points are

        y_i' = y_i - F^T R_i d
    """
    arm = _rigid_arm(problem)
    if arm is None:
        return problem, {}
    originals: dict[object, Sample] = {}
    train, test = list(problem.measurements), list(problem.test)
    poses: dict[str, Pose] = {}
    for k, m in enumerate(train):
        if is_own(m):
            train[k] = _with_one_target(arm, m, originals)
            poses[m.frame] = fit_pose(train[k].points, arm.predict(m))
    for k, m in enumerate(test):
        if is_own(m) and m.frame in poses:
            if not _is_elsewhere(arm, m, poses):
                continue
            m = in_own_frame(m)
        if is_own(m):
            test[k] = _with_one_target(arm, m, originals)
    view = replace(problem, measurements=tuple(train), test=tuple(test))
    return view, originals


def as_recorded(measured: Measurement, originals: Originals) -> Measurement:
    """Return a placement with its samples as they were recorded."""
    samples = measured.placement.samples
    before = tuple(originals.get(sample.point, sample) for sample in samples)
    return replace(measured, placement=replace(measured.placement, samples=before))


def _rigid_arm(problem: CalibrationProblem) -> CalibratedRobot | None:
    """Return the robot by a rigid fit; None for a single set-up, or where nothing was found."""
    measured = [m for _, m in problem.placements if is_own(m)]
    tied = problem.name or problem.options.located or problem.options.as_recorded
    few: list[Measurement] = []
    for m in filter(is_own, problem.measurements):
        count = len(m.points)
        few.append(m.only(np.arange(0, count, -(-count // MOST))))
    if tied or not few or len(measured) < 2:
        return None
    robot = problem.robot
    data = observe(RobotRecordings(robot, few, problem.load), require_scale=False)
    model = extend(robot, choose_parameters(robot))
    try:
        fit = estimate(model, data, differences=set_ups(data), average_widths=False)
    except (NotConverged, FrameError):
        return None
    return CalibratedRobot(robot, model.parameters, fit.arm.values)


def _with_one_target(
    arm: CalibratedRobot, measured: Measurement, originals: dict[object, Sample]
) -> Measurement:
    """Return a placement as if its target sat where the arm has it, and keep its samples."""
    tips = arm.tips(measured)
    offsets = tips.rotations @ tip_shift([tips])
    frame = fit_pose(tips.measured, tips.points + offsets)
    points = tips.measured - offsets @ frame.rotation
    turned_back: np.ndarray | None = None
    if measured.has_orientations:
        M = measured.rotations
        turns = np.einsum("nji,njk->ik", tips.rotations, frame.rotation @ M)
        turned_back = M @ nearest_rotation(turns).T
    view = with_points(measured, points, turned_back)
    pairs = zip(view.placement.samples, measured.placement.samples, strict=True)
    originals |= {sample.point: original for sample, original in pairs}
    return view


def _is_elsewhere(
    arm: CalibratedRobot, measured: Measurement, poses: Mapping[str, Pose]
) -> bool:
    """Tell whether a frame and target of their own leave much less of a placement's error."""
    tips = arm.tips(measured)
    shifted = tips.points + tips.rotations @ tip_shift([tips])
    error = evaluate(tips.points, measured, poses).mean_absolute_error
    return evaluate(shifted, measured).mean_absolute_error < SHARE * error

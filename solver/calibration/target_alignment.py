"""Recordings as checks of them see them: with one target, wherever each set-up has its own."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...errors import NotConverged
from ...recorder import Sample
from ..identification.data import (
    FrameError,
    Measurement,
    Pose,
    RobotRecordings,
    TipSamples,
    evaluate,
    fit_pose,
    nearest_rotation,
    observe,
    tip_shift,
)
from ..identification.inference import estimate
from ..identification.model import extend
from ..identification.robot import choose_parameters
from ..identification.selection import set_ups
from ..results import CalibratedRobot
from .problem import CalibrationProblem
from .set_ups import in_own_frame, is_own, with_points

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
    few = [_thinned(m) for m in problem.measurements if is_own(m)]
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


def _thinned(measured: Measurement) -> Measurement:
    N = len(measured.points)
    return measured.only(np.arange(0, N, -(-N // MOST)))


def _tips(arm: CalibratedRobot, measured: Measurement) -> TipSamples:
    return TipSamples(arm.predict(measured), arm.rotations(measured), measured.points)


def _with_one_target(
    arm: CalibratedRobot, measured: Measurement, originals: dict[object, Sample]
) -> Measurement:
    """Return a placement as if its target sat where the arm has it, and keep its samples."""
    tips = _tips(arm, measured)
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
    tips = _tips(arm, measured)
    shifted = tips.points + tips.rotations @ tip_shift([tips])
    error = evaluate(tips.points, measured, poses).mean_absolute_error
    return evaluate(shifted, measured).mean_absolute_error < SHARE * error

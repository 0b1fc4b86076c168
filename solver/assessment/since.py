"""Rows of the verdict on an old calibration, by recordings made since."""

from collections.abc import Sequence
from dataclasses import replace

from msgspec import structs

from ..data import Measurement
from ..diagnostics import inspect_all
from ..results import CalibratedRobot, Hypothesis, Summary
from ..robot import Origin
from .data_sufficiency import checks_row
from .held_out import error_rows
from .limits import LimitResult, Limits

FEW = 15
"""Samples in a socket below which its mean is too unsure for a limit on means of many."""
TRAINED = "all of these were trained on, so their errors prove nothing"


def rows_since(
    calibrated: CalibratedRobot,
    new: Summary | None,
    data: Sequence[Measurement],
    limits: Limits,
    *,
    zeros: bool,
    told: bool,
) -> tuple[list[LimitResult], tuple[Hypothesis, ...]]:
    """Return whether errors keep their limits and what else is seen, and explanations of it.

    Args:
        calibrated: The calibration's robot.
        new: The errors; None where all data were trained on.
        data: The recordings that were not.
        limits: What is allowed.
        zeros: Whether the arm's joints have zeros of their own, as servos have.
        told: Whether something else tells what changed, so that a few samples, or an arm of which
            no limit is known, need not be held to one: it is a warning then, or left out.
    """
    full = None if new is None or new.geometric is None else new.calibrated
    rows = error_rows(None if new is None else new.loaded, full, limits, TRAINED)
    if new is not None:
        rows = rows if new.loaded.distance_error is not None else rows[:1]
        rows = [row for row in rows if not told or row.limit is not None]
        few = told and any(count < FEW for m in data for count in m.counts)
        rows = [_warning(row) if few and row.status == "fail" else row for row in rows]
    pairs = zip(calibrated.robot.joints, calibrated.origins.tolist(), strict=True)
    joints = tuple(replace(joint, origin=Origin.of(numbers)) for joint, numbers in pairs)
    robot = replace(calibrated.robot, joints=joints)
    survey = inspect_all(robot, data, zeros=zeros, repeatability=limits.repeatability)
    return [*rows, checks_row(survey.diagnostics)], survey.hypotheses


def _warning(row: LimitResult) -> LimitResult:
    return structs.replace(row, status="warning", text=f"{row.text}, by a few samples")

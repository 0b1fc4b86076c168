"""An old calibration on recordings made since: the verdict, and its most likely cause."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..data import Measurement
from ..diagnostics import Survey, inspect_all
from ..results import CalibratedRobot, CalibrationDocument, Summary
from ..robot import Origin
from .data_sufficiency import checks_row
from .formatting import mm
from .held_out import error_rows
from .limits import Limits, limit_row
from .verdict import Verdict, judge
from .verification import NearestCause, nearest_cause

EXPLAINS = 0.6
"""An offset explains a drift if it leaves less than this share of the error."""
WORSE = 1.5
"""Errors beyond this many times those at the calibration itself are a drift."""
FEWEST_SAMPLES = 10
"""New samples below which nothing is said of an old calibration."""
TRAINED = "all of these were trained on, so their errors prove nothing"


@dataclass(frozen=True)
class Drift:
    """A verdict on an old calibration by new recordings."""

    verdict: Verdict
    reason: str
    cause: NearestCause | None = None
    advice: str = ""

    @property
    def text(self) -> str:
        """The verdict in a sentence, and the advice."""
        return f"Verdict: {self.verdict.title}: {self.reason}{self.advice and ' '}{self.advice}"

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        nearest = None if self.cause is None else vars(self.cause)
        return {**self.verdict.as_said(), "text": self.text, "nearest_cause": nearest}


def too_few(count: int) -> str:
    """Return why a few new samples tell nothing, and how many would."""
    return f"{count} samples say too little; record 6 in each of two sockets"


def judge_drift(
    document: CalibrationDocument,
    calibrated: CalibratedRobot,
    summary: Summary | None,
    data: Sequence[Measurement],
    limits: Limits,
) -> Drift:
    """Return whether a calibration still keeps its limits.

    Args:
        document: The calibration.
        calibrated: Its robot.
        summary: The errors on the new recordings; None where all of them were trained on.
        data: The new recordings.
        limits: What is allowed.
    """
    full = None if summary is None or summary.geometric is None else summary.calibrated
    rows = error_rows(None if summary is None else summary.loaded, full, limits, TRAINED)
    if summary is not None and summary.loaded.distance_error is None:
        rows = rows[:1]
    survey = _survey(document, calibrated, data if summary is not None else (), limits)
    known = [checks_row(survey.diagnostics)]
    if (count := sum(len(m.positions) for m in data)) < FEWEST_SAMPLES and summary is not None:
        text = too_few(count)
        known.append(limit_row("samples", "samples", "not enough", text, text=text))
    verdict = judge([*rows, *known], (), survey.hypotheses)
    allowed, most = limits.mean_absolute_error.value, limits.distance_error.value
    if summary is None or allowed is None or most is None:
        return Drift(verdict, f"not known; {rows[0].reason}.")
    mean, length = summary.loaded.mean_absolute_error, summary.loaded.distance_error
    figures = f"{mm(mean)}, limit {mm(allowed)}"
    if verdict.status == "pass":
        return Drift(verdict, f"still valid ({figures}).")
    if rows[0].status == rows[-1].status == "pass":
        return Drift(verdict, f"within its limits ({figures}), but look: {verdict.text}")
    if mean <= allowed and length is not None:
        reason = f"not valid: the sockets' distance is off by {mm(length)}, limit {mm(most)}"
        return Drift(verdict, f"{reason}; check --distance, and calibrate again.")
    then = document.summary.test or document.summary.train
    before = None if then is None else then.loaded.mean_absolute_error
    if before is not None and mean <= WORSE * before:
        text = f"not valid ({figures}), and it was no better when it was made."
        return Drift(verdict, f"{text} Calibrate again with more placements.")
    cause = nearest_cause(calibrated, data, before or allowed)
    text = f"drifted: {figures}"
    if before is not None:
        text += f", {mm(before)} when it was made"
    if cause is None or cause.error > EXPLAINS * mean:
        return Drift(verdict, f"{text}. No single joint explains it: calibrate again.")
    how_much = f"{math.degrees(cause.offset):+.2f} deg"
    joint = next(j for j in calibrated.robot.actuated if j.name == cause.joint)
    if joint.type == "prismatic":
        how_much = f"{1e3 * cause.offset:+.2f} mm"
    text += f"; nearest cause {cause.joint}, off by {how_much}: with it {mm(cause.error)} are left"
    return Drift(verdict, f"{text}.", cause, "Calibrate again.")


def _survey(
    document: CalibrationDocument,
    calibrated: CalibratedRobot,
    data: Sequence[Measurement],
    limits: Limits,
) -> Survey:
    """Return what is seen in new recordings, by the arm as it was calibrated."""
    pairs = zip(calibrated.robot.joints, calibrated.origins.tolist(), strict=True)
    joints = tuple(replace(joint, origin=Origin.of(numbers)) for joint, numbers in pairs)
    return inspect_all(
        replace(calibrated.robot, joints=joints),
        data,
        zeros=bool(document.settings.get("zeros")),
        repeatability=limits.repeatability,
    )

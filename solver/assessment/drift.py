"""Drift of a calibration on recordings made since, and its most likely cause.

A knock, or a joint that was mastered anew, shifts one joint's zero. So each joint in turn gets an
offset fitted, and the one that lowers the errors most is the nearest cause.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..data import Measurement, evaluate, mean_metrics, socket_centres, targets
from ..results import CalibratedRobot, CalibrationDocument, Summary
from .formatting import mm
from .limits import Limits

STEPS = 4
"""Gauss-Newton steps for one offset; the problem is nearly linear."""
SLIGHT = 1e-5
"""Step of the derivative by a joint position [rad or m]."""
EXPLAINS = 0.6
"""An offset explains a drift if it leaves less than this share of the error."""
WORSE = 1.5
"""Errors beyond this many times those at the calibration itself are a drift."""


@dataclass(frozen=True)
class Cause:
    """An offset of one joint, and the error that is left with it."""

    joint: str
    offset: float
    """[rad], [m] for a prismatic joint."""
    error: float
    """Mean absolute error [m]."""


@dataclass(frozen=True)
class Drift:
    """A verdict on an old calibration by new recordings."""

    status: str
    """``valid``, ``invalid``, or ``unknown`` where nothing says what is good for the arm."""
    reason: str
    cause: Cause | None = None
    advice: str = ""

    @property
    def text(self) -> str:
        """The verdict in a sentence, and the advice."""
        return f"Verdict: {self.reason}{self.advice and ' '}{self.advice}"

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        cause = None if self.cause is None else vars(self.cause)
        return {"status": self.status, "text": self.text, "nearest_cause": cause}


def judge_drift(
    document: CalibrationDocument,
    calibrated: CalibratedRobot,
    summary: Summary,
    data: Sequence[Measurement],
    limits: Limits,
) -> Drift:
    """Return whether a calibration still keeps its limits.

    Args:
        document: The calibration.
        calibrated: Its robot.
        summary: The errors on the new recordings.
        data: The new recordings.
        limits: What is allowed.
    """
    mean, length = summary.loaded.mean_absolute_error, summary.loaded.distance_error
    allowed, most = limits.mean_absolute_error.value, limits.distance_error.value
    if allowed is None or most is None:
        return Drift("unknown", f"not known; {limits.mean_absolute_error.source}.")
    figures = f"{mm(mean)}, limit {mm(allowed)}"
    if mean <= allowed and (length is None or length <= most):
        return Drift("valid", f"still valid ({figures}).")
    if mean <= allowed and length is not None:
        return Drift(
            "invalid",
            f"not valid: the sockets' distance is off by {mm(length)}, limit "
            f"{mm(most)}; check --distance, and calibrate again.",
        )
    then = document.summary.test or document.summary.train
    before = None if then is None else then.loaded.mean_absolute_error
    if before is not None and mean <= WORSE * before:
        text = f"not valid ({figures}), and it was no better when it was made."
        return Drift("invalid", f"{text} Calibrate again with more placements.")
    cause = nearest_cause(calibrated, data)
    text = f"drifted: {figures}"
    if before is not None:
        text += f", {mm(before)} when it was made"
    if cause is None or cause.error > EXPLAINS * mean:
        return Drift("invalid", f"{text}. No single joint explains it: calibrate again.")
    how_much = f"{math.degrees(cause.offset):+.2f} deg"
    joint = next(j for j in calibrated.robot.actuated if j.name == cause.joint)
    if joint.type == "prismatic":
        how_much = f"{1e3 * cause.offset:+.2f} mm"
    text += f"; nearest cause {cause.joint}, off by {how_much}: with it {mm(cause.error)} are left"
    return Drift("invalid", f"{text}.", cause, "Calibrate again.")


def nearest_cause(calibrated: CalibratedRobot, data: Sequence[Measurement]) -> Cause | None:
    """Return the joint whose offset, fitted alone, lowers the errors most; None without joints."""
    causes = [_cause(calibrated, data, i) for i in range(len(calibrated.robot.joint_names))]
    return min(causes, key=lambda cause: cause.error, default=None)


def _cause(calibrated: CalibratedRobot, data: Sequence[Measurement], joint: int) -> Cause:
    shift = np.zeros(len(calibrated.robot.joint_names))

    def at(offset: float) -> list[np.ndarray]:
        shift[joint] = offset
        return [calibrated.geometric_ball(m.positions + shift) for m in data]

    offset = 0.0
    for _ in range(STEPS):
        here = _residuals(at(offset), data)
        slope = (_residuals(at(offset + SLIGHT), data) - here) / SLIGHT
        if (steep := float(slope @ slope)) > 0:
            offset -= float(slope @ here) / steep
    errors = [evaluate(points, m) for points, m in zip(at(offset), data, strict=True)]
    return Cause(
        calibrated.robot.joint_names[joint], offset, mean_metrics(errors).mean_absolute_error
    )


def _residuals(points: Sequence[np.ndarray], data: Sequence[Measurement]) -> np.ndarray:
    """Return each ball less its socket's mean, and the errors of the distances [m]."""
    parts: list[np.ndarray] = []
    for each, measured in zip(points, data, strict=True):
        centres = socket_centres(each, measured)
        parts.append((each - targets(each, measured)).ravel())
        if measured.has_distance:
            length = np.linalg.norm(centres[1] - centres[0]) - measured.distance
            parts.append(np.array([length * math.sqrt(len(each))]))
    return np.concatenate(parts)

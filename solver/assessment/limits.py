"""The largest errors that a calibration may have: three times the arm's repeatability.

For the distance of two sockets, which are means of many samples, once; where gears have play twice.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from msgspec.structs import replace

from ..diagnostics import LARGEST_PREDICTED
from ..identification.data import KnownDistance
from ..results import Better, CalibrationDocument, Document, Interval, misfit
from .formatting import mm
from .repeatability import ARMS, RESOLUTION, Arm, known_arm

Status = Literal["pass", "warning", "fail", "not enough", "not evaluated"]
"""``warning``: look at it; ``not enough``: too little was recorded to say."""
OF_ERRORS = 3
"""Held-out errors may come to so many times the arm's repeatability."""
BAND = 1.96
"""Half the width of a 95 % interval, in standard deviations."""


class Limit(Document):
    """The largest value that passes."""

    value: float | None
    """[m]; None where nothing says what is good for this arm."""
    source: str
    """Origin of the limit, or what is needed to have it."""


class Limits(Document):
    """Limits on the errors of a calibration."""

    repeatability: float | None
    """Repeatability of the arm [m], where it is known."""
    repeatability_source: str
    mean_absolute_error: Limit
    distance_error: Limit
    between_placements: Limit


class LimitResult(Document):
    """One limit of the verdict, and whether it is kept."""

    name: str
    title: str
    found: float | None
    """Value reached by ``calibrated.urdf`` [m]."""
    limit: float | None
    """[m]."""
    status: Status
    deviation: float | None = None
    """Standard deviation of that value [m]: a limit is missed only beyond it, and is ``not enough``
    where the value is above the limit by less."""
    interval: Interval | None = None
    """68 % interval of a predicted value, whose upper end keeps the limit or not."""
    full: float | None = None
    """Value reached by the full model, if ``calibrated.urdf`` is not all of it [m]."""
    full_status: Status | None = None
    text: str
    reason: str
    """Origin of the limit, or what is missing."""

    @property
    def doubt(self) -> str:
        """Reason for which a limit that counts as kept is not shown to be kept; empty where it is.

        Shown is what the whole 95 % interval of the value keeps: value + 1.96 deviations.
        """
        if self.status != "pass" or self.found is None or self.limit is None:
            return ""
        upper = self.found + BAND * (self.deviation or 0.0)
        if upper > self.limit:
            return (
                f"{self.title} may be up to {mm(upper, 3)} (limit {mm(self.limit, 3)})"
            )
        return ""


WORKSPACE, NEAR = "predicted_distance", "predicted_distance_near"
"""Rows on predicted errors of distances, in the whole workspace and near the recorded places."""
READING = "reading"
"""Row on a distance that was read once: it bars a PASS, and no better model."""
LIMITS = (
    "mean_absolute_error",
    "distance_error",
    "between_placements",
    NEAR,
    WORKSPACE,
)
"""Rows with a figure and a limit; all others are reasons."""
TITLES = {
    "mean_absolute_error": "mean held-out error",
    "distance_error": "held-out distance error",
    "held_out": "what was held out",
    "distance_deviations": "held-out distance, in standard deviations",
    "between_placements": "distances between placements",
    "data_checks": "data checks",
    "drift": "steady drift where it was trained",
    "drift_held_out": "steady drift held out",
    "distortion": "sockets' distance reproduced",
    "distance_given": "distance of the sockets",
    "scale": "size of the arm",
    READING: "reading of the sockets' distance",
    "samples": "number of samples",
    "validity": "what changed",
    "known": "how well it is known",
    "travel": "travel of each joint",
    NEAR: "distances near the recorded places",
    WORKSPACE: "distances in the workspace",
}
"""Every row of a verdict by its name."""


def limit_row(
    name: str,
    status: Status,
    reason: str,
    value: float | None = None,
    limit: float | None = None,
    *,
    text: str = "",
    deviation: float | None = None,
) -> LimitResult:
    """Return a row of the verdict; its text is its title and the reason, if not said otherwise."""
    title = TITLES[name]
    text = text or (reason if status == "not enough" else f"{title}: {reason}")
    return LimitResult(
        name=name,
        title=title,
        status=status,
        reason=reason,
        found=value,
        limit=limit,
        deviation=deviation,
        text=text,
    )


def with_full(row: LimitResult, corrected: float | None, beyond: Status) -> LimitResult:
    """Return a row with the full model's value, if any, and its status beyond the limit."""
    if corrected is None or row.limit is None:
        return row
    return replace(
        row, full=corrected, full_status="pass" if corrected <= row.limit else beyond
    )


@dataclass(frozen=True)
class Options:
    """Limits and known distances, as far as the user gives them."""

    repeatability: float | None = None
    """Of the arm [m]; None for what is known of it."""
    mean_absolute_error: float | None = None
    """Limit [m]; None, here and below, for a multiple of the repeatability."""
    distance_error: float | None = None
    between_placements: float | None = None
    known: Sequence[KnownDistance] = ()
    task: float | None = None
    """The error that the user's task allows [m]; None where nobody said."""


def setting(document: CalibrationDocument, source: str, key: str) -> float | None:
    """Return a number that was given to ``mukca solve``, if any.

    Raises:
        DocumentError: It is no number.
    """
    value = document.settings.get(key)
    if value is None:
        return None
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not math.isfinite(value)
    ):
        raise misfit(source, f"settings.{key}", f"{value!r} is no number")
    return float(value)


def limits_of(document: CalibrationDocument, source: str, options: Options) -> Limits:
    """Return what a calibration is held against: as the user says, or by the arm's repeatability.

    Raises:
        DocumentError: Its settings hold no number where one belongs.
    """
    name = known_arm(document.model)
    stored = setting(document, source, "repeatability_mm")
    repeatability = options.repeatability or (stored and stored / 1e3)
    arm: Arm | None = None
    if repeatability is not None:
        arm = Arm(repeatability, "given by --repeatability-mm")
    elif name is not None:
        arm = Arm(ARMS[name].repeatability, f"{name}: {ARMS[name].source}")
    elif document.settings.get("zeros") and (scatter := _scatter(document)):
        arm = Arm(
            scatter,
            "no maker's figure: so far these samples scatter about their sockets",
        )
    servos = 2 if document.settings.get("zeros") else 1  # their gears have play
    source = "no repeatability is known for this arm" if arm is None else arm.source
    errors, distances = options.mean_absolute_error, options.distance_error
    between = options.between_placements
    return Limits(
        repeatability=arm and arm.repeatability,
        repeatability_source=source,
        mean_absolute_error=_limit(arm, OF_ERRORS, errors, "--limit-mae-mm"),
        distance_error=_limit(arm, servos, distances, "--limit-distance-mm"),
        between_placements=_limit(arm, OF_ERRORS, between, "--limit-between-mm"),
    )


def _scatter(document: CalibrationDocument) -> float | None:
    """Return how far an arm of servos was off over two placements [m]; None where that is much."""
    summary = document.summary.train
    placements = sum(
        p.role == "train" and p.kind == "sockets" for p in document.placements
    )
    error = summary and summary.calibrated.mean_absolute_error
    if error is None or error > LARGEST_PREDICTED or placements < 2:
        return None
    return round(max(error, RESOLUTION), 5)


def error_limit(repeatability: float | None) -> float | None:
    """Return the limit on held-out errors by an arm's repeatability [m]; None where unknown."""
    if repeatability is None:
        return None
    return OF_ERRORS * max(repeatability, RESOLUTION)


UNLIMITED = (
    "no limit is known: add --repeatability-mm with the figure of the arm's data sheet"
)
"""Said where an arm's repeatability is not known."""


def _limit(arm: Arm | None, margin: int, size: float | None, option: str) -> Limit:
    if size is not None:
        return Limit(value=size, source=f"given by {option}")
    if arm is None:
        return Limit(value=None, source=UNLIMITED)
    times = f"{margin} times the" if margin > 1 else "the"
    if arm.repeatability < RESOLUTION:
        words = f"{times} {1e3 * RESOLUTION:g} mm that limits go by at least"
    else:
        words = f"{times} arm's repeatability of {1e3 * arm.repeatability:g} mm"
    return Limit(value=margin * max(arm.repeatability, RESOLUTION), source=words)


def is_dwarfed(better: Better | None, workspace: float, near: float) -> bool:
    """Tell whether errors with others of such sizes [m] beside stay below those before.

    False where nobody knows the errors.
    """
    if better is None:
        return False
    pairs = zip(better.places, (workspace, near), strict=False)
    return all(errors.now.high + size < errors.before.low for errors, size in pairs)

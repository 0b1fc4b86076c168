"""Reason of a verdict on later samples, and the step that follows from it."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..assessment import LimitResult, Limits, limit_row, mm
from ..calibration import Calibration
from ..identification.data import Measurement
from ..results import CalibrationDocument, Summary
from .changes import Changes
from .evidence import EVERYTHING, LENGTHS, NOTHING

WORSE = 1.5
"""Factor on the errors of the calibration itself, beyond which errors are new."""
CERTAIN = 0.99
"""Probability from which the change of a joint's zero is none that small errors excuse."""
NEXT = {
    "tool": "The ball or tool was moved: find it by mukca tool, or mukca rezero --ball-moved.",
    "base": "The base was moved: leave out --stood.",
    EVERYTHING: "No single joint explains it: mukca rezero says whether several zeros do. Else, "
    "is it another arm's calibration? If not, record placements, and calibrate again.",
}


class Reason(NamedTuple):
    """Reason of a verdict."""

    text: str
    """A sentence without its capital."""
    advice: str = ""
    """The next step; empty where all is well."""
    as_made: bool = False
    """True where a limit is missed, though nothing became worse since the calibration was made."""


@dataclass(frozen=True)
class LaterErrors:
    """Errors of later samples, against limits and those when the calibration was made."""

    new: Summary
    then: Summary | None
    """Those when it was made; None where they are not known."""
    limits: Limits
    rows: Sequence[LimitResult]
    """Rows of the verdict: limits, and the checks of the data."""
    rezero: str
    """Command that finds zeros by the later samples."""
    by_points: bool
    """True of points that an instrument measured, which ``mukca rezero`` does not take."""

    @property
    def failed(self) -> list[LimitResult]:
        """The rows that fail."""
        return [row for row in self.rows if row.status == "fail"]

    @property
    def limit(self) -> str:
        """The limit on the mean absolute error, in words; empty for none."""
        allowed = self.limits.mean_absolute_error.value
        return f", limit {mm(allowed)}" if allowed else ""

    @property
    def figures(self) -> str:
        """The mean absolute error of ``calibrated.urdf`` and its limit, in words."""
        return f"{mm(self.new.loaded.mean_absolute_error)}{self.limit}"

    @property
    def before(self) -> float | None:
        """Mean absolute error of the full model when it was made [m]."""
        return self.then and self.then.calibrated.mean_absolute_error

    @property
    def is_no_worse(self) -> bool:
        """True where the full model's errors are about as large as when it was made."""
        now = self.new.calibrated.mean_absolute_error
        return self.before is not None and now <= WORSE * self.before

    @property
    def since_made(self) -> str:
        """The errors now and when it was made, of which model each, as a sentence's end."""
        now, then = self.new.loaded.mean_absolute_error, self.then
        assert then is not None  # asked where they are no worse
        if now <= WORSE * then.loaded.mean_absolute_error:
            return "but no worse than when it was made"
        made = mm(then.loaded.mean_absolute_error)
        return (
            f"{made} when it was made; corrected joint positions are no worse than then"
        )

    @property
    def drifted(self) -> str:
        """The full model's errors now and then, in words."""
        now = mm(self.new.calibrated.mean_absolute_error)
        before = f", {mm(self.before)} when it was made" if self.before else ""
        return f"drifted: {now}{self.limit}{before}"

    @property
    def wrong_length(self) -> str:
        """The error of the sockets' distance, in words."""
        length = mm(self.new.loaded.distance_error or 0.0)
        return f"not valid: the sockets' distance is off by {length}"

    @property
    def missed_length(self) -> bool:
        """True where the distance of the sockets alone is beyond its limit."""
        names = {row.name for row in self.failed}
        known = self.new.loaded.distance_error and self.limits.distance_error.value
        missed = "distance_error" in names and "mean_absolute_error" not in names
        return missed and bool(known)


def later_errors(
    calibration: Calibration,
    data: Sequence[Measurement],
    new: Summary,
    limits: Limits,
    rows: Sequence[LimitResult],
) -> LaterErrors:
    """Return the errors of later samples beside those when the calibration was made."""
    made = calibration.document.summary
    by_points = any(m.kind == "points" for m in data)
    command = _rezero_command(calibration.source, data, by_points)
    return LaterErrors(new, made.proof or made.train, limits, rows, command, by_points)


def _rezero_command(source: str, data: Sequence[Measurement], by_points: bool) -> str:
    """Return the command that finds zeros by the samples, and by a calibration's file.

    By points that is a new fit, from the arm as it was calibrated.
    """
    folder = source.removesuffix("/calibration.json")
    folders = dict.fromkeys(str(m.placement.where) for m in data)
    if by_points:
        urdf = f"{folder}/calibrated.urdf"
        return shlex.join(["mukca", "solve", *folders, "--robot", urdf, "--zeros"])
    typed = {m.distance for m in data if m.distance_source == "given"}
    command = shlex.join(["mukca", "rezero", folder, *folders])
    return command + "".join(f" --distance {distance:.7g}" for distance in typed)


def reason_of(changes: Changes, errors: LaterErrors) -> Reason:
    """Return the reason of a verdict: a change that the evidence names, or else the errors."""
    if changes.changed and changes.likeliest == LENGTHS:
        text = f"{errors.wrong_length} ({changes.share})."
        return Reason(
            text, "Check --distance, or state it: mukca info DATA --set-distance M."
        )
    if changes.cause is not None:
        text = f"{errors.drifted}; {changes.cause.text(changes.share)}."
        command = errors.rezero
        if not errors.by_points:
            command += f" --joint {shlex.quote(changes.likeliest)}"
        return Reason(text, f"This finds the joint's new zero: {command}")
    if not changes.changed and (corrected := _kept_when_corrected(errors)):
        return corrected
    if errors.missed_length:
        longest = mm(errors.limits.distance_error.value or 0.0)
        text = f"{errors.wrong_length}, limit {longest}"
        return Reason(f"{text}; check --distance, and calibrate again.")
    if changes.changed:
        text = f"{errors.drifted}; {changes.change} ({changes.share})."
        return Reason(text, NEXT[changes.likeliest])
    if any(row.name == "mean_absolute_error" for row in errors.failed):
        return _of_large_errors(errors)
    return _of_small_errors(changes, errors)


def _kept_when_corrected(errors: LaterErrors) -> Reason | None:
    """Return the reason where corrected joint positions alone keep all limits; else None."""
    failed = errors.failed
    if not failed or any(row.full_status != "pass" for row in failed):
        return None
    texts = "; ".join(row.text for row in failed)
    return Reason(
        f"only corrected joint positions keep its limits: {texts}.",
        "Where these matter, command them: mukca command.",
        as_made=True,
    )


def _of_large_errors(errors: LaterErrors) -> Reason:
    """Return the reason where nothing changed, but the errors are beyond their limit."""
    if errors.is_no_worse:
        text = f"beyond its limit ({errors.figures}), {errors.since_made}."
        return Reason(text, "Calibrate again with more placements.", as_made=True)
    text = f"{errors.drifted}. No single joint explains it: calibrate again."
    return Reason(text)


def _of_small_errors(changes: Changes, errors: LaterErrors) -> Reason:
    """Return the reason where nothing changed, and no error is beyond its limit."""
    row_of = {row.name: row for row in errors.rows}
    if not changes.likeliest and errors.limits.mean_absolute_error.value is None:
        reason = errors.rows[0].reason
        return Reason(f"{reason}.")
    checks, error = row_of["data_checks"], row_of.get("mean_absolute_error")
    if checks.status != "pass":
        words = f"errors of {errors.figures}; look"
        if error is not None and error.status == "pass":
            words = f"within its limits ({errors.figures}), but look"
        return Reason(f"{words}: {checks.text}.")
    odds = f": {odds}" if (odds := _odds(changes)) else ""
    if error is None or error.status != "warning":
        return Reason(f"still valid ({errors.figures}){odds}.")
    now = mm(errors.new.loaded.mean_absolute_error)
    limit = f"the limit of {mm(error.limit or 0.0)} is for the mean of more samples"
    return Reason(f"no change shows ({now} by these few samples; {limit}){odds}.")


def _odds(changes: Changes) -> str:
    """Return how probable the likeliest explanation is, in words; empty without any."""
    likely = changes.likeliest
    odds = ""
    if likely == NOTHING:
        odds = f"nothing changed, with a probability of {changes.share}"
    elif likely:
        odds = f"{likely} may have changed ({changes.share}); record more samples"
    if changes.ball is not None:
        last = list(changes.probabilities)[-2]
        moved = mm(changes.ball)
        odds += f"; the ball sits {moved} from where it was, or {last} is off"
    return odds


def change_rows(
    changes: Changes,
    errors: LaterErrors,
    document: CalibrationDocument,
    text: str,
    repeatability: float | None,
) -> list[LimitResult]:
    """Return the row that says whether something changed; none where that was not compared."""
    if not changes.probabilities:
        return []
    status = "pass"
    if changes.changed:
        is_excused = not errors.failed and _is_excused(
            changes, document, errors.new, limited=bool(repeatability)
        )
        status = "warning" if is_excused else "fail"
    return [limit_row("validity", status, text[:-1], text=text[:-1])]


def _is_excused(
    changes: Changes, document: CalibrationDocument, new: Summary, *, limited: bool
) -> bool:
    """Return whether errors as small as held-out ones, or within given limits, excuse a change.

    They do not excuse that of a joint's zero, but by a calibration without the full model: a rigid
    chain's own errors look like one. Nor do they excuse a length, which they do not see.
    """
    if changes.likeliest == LENGTHS:
        return False
    held_out = document.summary.proof
    before = held_out.calibrated.mean_absolute_error if held_out else 0.0
    small = new.calibrated.mean_absolute_error <= before
    if changes.cause is None:
        return small or limited
    likely = changes.probabilities[changes.likeliest]
    return small and document.method != "auto" and likely <= CERTAIN

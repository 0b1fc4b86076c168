"""Changes since a calibration, and the reason of a verdict that follows."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..assessment import LimitResult, Limits, mm
from ..results import Summary
from .evidence import LENGTHS, NOTHING, NearestCause

CHANGED = 0.5
"""Probability from which a change is reported, more probable than not: in fewer than 2 of 100 cases
where nothing changed, and in 95 of 100 where a joint moved by 1 mrad."""
WORSE = 1.5
"""Factor on the errors of the calibration itself, beyond which errors are new."""
NEXT = {
    "tool": "The ball or tool was moved: find it by mukca tool, or mukca rezero --ball-moved.",
    "base": "The base was moved: leave out --stood.",
    "everything": "No single joint explains it: mukca rezero says whether several zeros do. Else, "
    "is it another arm's calibration? If not, record placements, and calibrate again.",
}


@dataclass(frozen=True)
class Changes:
    """Posterior probabilities of what changed, by samples in sockets."""

    probabilities: dict[str, float]
    """Of each explanation; empty without samples in sockets, or where no fit converged."""
    cause: NearestCause | None = None
    """The joint that changed; None for another change."""
    ball: float | None = None
    """Distance by which a remounted ball moved [m]; None where it did not."""
    untold: tuple[str, ...] = ()
    """Joints whose zeros the samples do not identify; empty where something else is to be said."""

    @property
    def likeliest(self) -> str:
        """The most probable explanation; of the changes alone, where something changed."""
        names = [name for name in self.probabilities if not (self.changed and name == NOTHING)]
        return max(names, key=self.probabilities.__getitem__, default="")

    @property
    def changed(self) -> bool:
        """True where something changed."""
        return 1 - self.probabilities.get(NOTHING, 1.0) > CHANGED


def reason_and_advice(
    changes: Changes,
    rows: Sequence[LimitResult],
    new: Summary,
    limits: Limits,
    then: Summary | None,
) -> tuple[str, str]:
    """Return the reason of the verdict, by the full model's errors, and the next step."""
    mean, length = new.loaded.mean_absolute_error, new.loaded.distance_error
    likely, before = changes.likeliest, then and then.calibrated.mean_absolute_error
    allowed, largest = limits.mean_absolute_error.value, limits.distance_error.value
    limit, corrected = (
        f", limit {mm(allowed)}" if allowed else "",
        new.calibrated.mean_absolute_error,
    )
    figures = f"{mm(mean)}{limit}"
    drifted = f"drifted: {mm(corrected)}{limit}" + (
        f", {mm(before)} when it was made" if before else ""
    )
    share = f"{100 * changes.probabilities.get(likely, 0.0):.1f} %"
    status = {row.name: row.status for row in rows}
    if changes.changed and likely == LENGTHS:
        reason = f"not valid: the sockets' distance is off by {mm(length or 0.0)} ({share})."
        return reason, "Check --distance, or state it: mukca info DATA --set-distance M."
    if changes.cause is not None:
        return (
            f"{drifted}; {changes.cause.text(share)}.",
            f"mukca rezero --joint {likely} finds its zero.",
        )
    if (
        status.get("distance_error") == "fail" != status["mean_absolute_error"]
        and length
        and largest
    ):
        reason = f"not valid: the sockets' distance is off by {mm(length)}, limit {mm(largest)}"
        return f"{reason}; check --distance, and calibrate again.", ""
    if changes.changed:
        return f"{drifted}; nearest cause: {likely}, with a probability of {share}.", NEXT[likely]
    if status.get("mean_absolute_error") == "fail":
        if before is not None and corrected <= WORSE * before:
            text = f"not valid ({figures}), and it was no better when it was made."
            return text, "Calibrate again with more placements."
        return f"{drifted}. No single joint explains it: calibrate again.", ""
    if not likely and allowed is None:
        return f"not known whether it is still valid; {rows[0].reason}.", ""
    checks = next(row for row in rows if row.name == "data_checks")
    if checks.status != "pass":
        return f"within its limits ({figures}), but look: {checks.text}.", ""
    odds = f"{likely} may have changed ({share}); record more samples"
    if likely in (NOTHING, ""):
        odds = f"nothing changed, with a probability of {share}" if likely else ""
    if changes.ball is not None:
        last = list(changes.probabilities)[-2]
        odds += f"; the ball sits {mm(changes.ball)} from where it was, or {last} is off"
    return f"still valid ({figures}){odds and ': '}{odds}.", ""

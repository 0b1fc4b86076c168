"""Validity of a calibration by later samples: what changed, how large errors are, one verdict.

``mukca validate``, ``check --calibration``, ``record --quick --calibration`` and ``mukca fleet``
show it, each in its own detail, with the same exit status.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain
from typing import Any

from msgspec import structs

from ...recorder import Placement
from ..assessment import (
    LimitResult,
    Options,
    Verdict,
    assumed_distances,
    distance_row,
    is_better,
    judge,
    limit_row,
    limits_of,
    rows_since,
    sentence,
)
from ..calibration import Calibration, Errors, as_list
from ..identification.data import (
    Measurement,
    Metrics,
    Readings,
    check_distinct,
    measure,
    one_blas_thread,
)
from ..results import CalibrationDocument, Diagnostic, Summary
from .changes import Changes, changes_since, tip_words
from .evidence import NOTHING
from .reasons import (
    Reason,
    change_rows,
    later_errors,
    reason_of,
)
from .sockets import on_base_of, too_few

SURE_OF_CHANGE = 0.95
"""Probability from which one of many arms is called changed: beside it stands no other evidence."""
FEW = "few"
"""Code of a warning on samples that calibrate nothing, though they may suffice here."""
LEAST_SHOWN = 0.01
"""Probability below which an explanation is not shown."""


@dataclass(frozen=True, kw_only=True)
class Validity(Changes):
    """Validity of a calibration, by samples recorded since."""

    errors: Errors
    """Errors of each placement; those of training placements prove little."""
    verdict: Verdict
    """The verdict, by the same rules as that of a new calibration."""
    said: tuple[str, str]
    """The reason of the verdict; and the next step, empty where all is well."""
    measured: Sequence[Measurement]
    """The samples."""
    as_made: bool = False
    """True where a limit is missed, though nothing became worse since the calibration was made."""
    findings: Sequence[Diagnostic] = ()
    """Errors and warnings that a look at the recordings gave, on which the verdict rests, too."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Remarks on the samples."""
        return tuple(chain.from_iterable(m.warnings for m in self.measured))

    @property
    def drifted(self) -> bool:
        """True where the arm is surely no more what was calibrated."""
        failed = self.verdict.status == "fail" and not self.as_made
        return failed and not self.doubtful

    @property
    def doubtful(self) -> bool:
        """True where a change is more probable than not, but not sure."""
        return self.changed and self.probability < SURE_OF_CHANGE

    @property
    def brief(self) -> str:
        """The state of the calibration in few words."""
        if self.drifted:
            return self.change or "errors grew"
        if self.doubtful:
            return f"something may have changed ({100 * self.probability:.0f} %)"
        if self.verdict.status == "incomplete":
            return "not known"
        return "as calibrated, beyond its limit" if self.as_made else "valid"

    @property
    def text(self) -> str:
        """The verdict in a sentence, and the next step."""
        return f"Verdict: {self.verdict.title}: {' '.join(filter(None, self.said))}"

    def __repr__(self) -> str:
        return "\n".join((self.text, *self.odds, *self.not_shown))

    @property
    def odds(self) -> tuple[str, ...]:
        """Each explanation that is not ruled out, the most probable first, in words."""
        by_size = sorted(self.probabilities.items(), key=lambda pair: -pair[1])
        words = ", ".join(
            f"{name}{' changed' * (name == NOTHING)} {100 * p:.1f} %"
            for name, p in by_size
            if p > LEAST_SHOWN
        )
        return (f"Probability of each change since: {words}.",) if words else ()

    @property
    def not_shown(self) -> tuple[str, ...]:
        """A sentence on the zeros whose change would not show, where nothing changed."""
        if not self.untold:
            return ()
        advice = "mukca rezero says what to record for them"
        if any(m.kind == "points" for m in self.measured):
            advice = (
                "it would look like another place of the instrument or of its target"
            )
        return (
            f"A change of these joints' zeros would not show in such samples: "
            f"{', '.join(self.untold)}; {advice}.",
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict by name."""
        cause = None if self.cause is None else asdict(self.cause)
        told = {"text": self.text, "nearest_cause": cause}
        findings = [finding.as_dict() for finding in self.findings]
        return {**self.verdict.as_said(), **told, "findings": findings}


@one_blas_thread
def what_changed(
    calibration: Calibration,
    data: Placement | Sequence[Placement],
    stood: str = "",
    distance: Readings | None = None,
    *,
    repeatability: float | None = None,
    ball_moved: bool = False,
) -> Validity:
    """Tell what changed since a calibration, and how large its errors are.

    It is valid if the evidence names no change, or an excused one, and its errors keep the limits.

    Args:
        calibration: The calibration.
        data: Samples since, 6 in each of two sockets; of points, frame and target are refitted.
        stood: Placement of the calibration whose base still stands where it stood, or should.
        distance: Between the sockets' centres [m]; None for the recording's or else the base's.
        repeatability: Of the arm, from which its limits follow [m]; None for what is known of it.
        ball_moved: The ball may have been taken off since, which is no change then.

    Raises:
        UsageError: No such placement.
        MeasurementError: Samples of another arm.
    """
    document = calibration.document
    measured = _as_read_now(calibration, as_list(data), distance)
    changes, now = changes_since(calibration, measured, stood, ball_moved=ball_moved)
    errors = calibration.errors_of(measured, other_tip=True)
    new = _summary_now(errors, now)
    limits = limits_of(document, calibration.source, Options(repeatability))
    compared = bool(changes.probabilities)
    later = [m for m in measured if not calibration.was_trained_on(m)]
    arm, zeros = calibration.calibrated, bool(document.settings.get("zeros"))
    rows, seen = rows_since(arm, new, later, limits, zeros=zeros, compared=compared)
    if new is None:
        reason = Reason(f"{rows[0].reason}.")
    elif few := too_few(measured, unchanged=compared and not changes.changed):
        reason = Reason(few)
        rows = [limit_row("samples", "not enough", few, text=few[:-1])]
        changes = replace(changes, untold=())
    else:
        since = later_errors(calibration, measured, new, limits, rows)
        reason = reason_of(changes, since)
        reason = reason._replace(text=reason.text + tip_words(calibration, measured))
        rows += change_rows(changes, since, document, reason.text, repeatability)
    length = _length_row(document, measured)
    better = reason.as_made and bool(is_better(document.better, new))
    verdict = judge([*rows, length], seen.hypotheses, better=better)
    if length.status != "pass" and new is not None and verdict.kind == "not_enough":
        reason = reason._replace(text=f"{length.text}. {sentence(reason.text)}")
    return Validity(
        **vars(changes),
        errors=errors,
        verdict=verdict,
        said=(reason.text, reason.advice),
        measured=measured,
        as_made=reason.as_made,
        findings=[f for f in seen.diagnostics if f.level != "note" and f.code != FEW],
    )


def _length_row(
    document: CalibrationDocument, measured: Sequence[Measurement]
) -> LimitResult:
    """Return whether any length is measured: by these samples, or when the arm was calibrated."""
    stated = [m for m in measured if m.has_distance and m.distance_source != "default"]
    if stated or any(m.kind == "points" for m in measured):
        return distance_row([])
    return distance_row(assumed_distances(document))


def _as_read_now(
    calibration: Calibration, placements: Sequence[Placement], distance: Readings | None
) -> list[Measurement]:
    """Return checked placements, their joints as zeros found since read them."""
    robot, load = calibration.robot, calibration.load
    if distance is None:
        placements = [on_base_of(calibration, placement) for placement in placements]
    measured = [
        measure(calibration.at_scale(placement), robot, distance, sockets=1, load=load)
        for placement in placements
    ]
    check_distinct(measured)
    return [*map(calibration.as_read_now, measured)]


def _summary_now(errors: Errors, now: Metrics | None) -> Summary | None:
    """Return the errors held out, those of the full model by the zeros as they are now."""
    new = errors.summary.test
    if new is None or now is None:
        return new
    return structs.replace(new, calibrated=now, geometric=None)

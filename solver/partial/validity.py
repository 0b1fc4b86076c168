"""Validity of a calibration by later samples: what changed, how large errors are, one verdict.

``mukca validate``, ``check --calibration``, ``record --quick --calibration`` and ``mukca fleet``
show it, each in its own detail, with the same exit status.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from msgspec import structs

from ...recorder import Placement
from ..assessment import (
    LimitResult,
    Limits,
    Options,
    Verdict,
    assumed_distances,
    distance_row,
    judge,
    limit_row,
    limits_of,
    mm,
    rows_since,
)
from ..calibration import Calibration, Errors, as_list
from ..data import Measurement, Metrics, Readings, evaluate, mean_metrics, measure
from ..results import Summary
from .evidence import (
    DIVERGED,
    EVERYTHING,
    LENGTHS,
    NOTHING,
    UNIDENTIFIABLE,
    NearestCause,
    explanations,
    fit_with_zeros,
    linear_about,
    probabilities,
    zero_deviations,
)
from .fit import fit, next_step
from .sockets import prior_by_all_samples, socket_task, thinned, too_few

CHANGED = 0.7
"""Probability from which a change is reported: in fewer than 2 of 100 cases where nothing changed,
and in 95 of 100 where a joint moved by 1 mrad."""
CERTAIN = 0.99
"""Probability from which the change of a joint's zero is none that small errors excuse."""
MOST_SAMPLES = 150
"""Samples that are compared at most; with more, the model's own misfit would show."""
WORSE = 1.5
"""Factor on the errors of the calibration itself, beyond which errors are new."""
FAR_MOVED = 4.0
"""Standard deviations beyond which the ball is reported as moved."""
PUT_ON_AGAIN = 2e-3
"""Prior standard deviation of the place of a ball that was remounted [m]."""
LEAST_SHOWN = 0.01
"""Probability below which an explanation is not shown."""
_NEXT = {
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
        """The most probable explanation."""
        return max(self.probabilities, key=self.probabilities.__getitem__, default="")

    @property
    def changed(self) -> bool:
        """True where something changed."""
        return 1 - self.probabilities.get(NOTHING, 1.0) > CHANGED


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

    @property
    def warnings(self) -> tuple[str, ...]:
        """Remarks on the samples."""
        return tuple(warning for m in self.measured for warning in m.warnings)

    @property
    def text(self) -> str:
        """The verdict in a sentence, and the next step."""
        return f"Verdict: {self.verdict.title}: {' '.join(filter(None, self.said))}"

    def __repr__(self) -> str:
        return "\n".join((self.text, *self.odds, *self.not_shown))

    @property
    def odds(self) -> tuple[str, ...]:
        """Each explanation that is not ruled out, the most probable first, in words."""
        by_size = sorted(self.probabilities.items(), key=lambda one: -one[1])
        words = ", ".join(f"{name} {100 * p:.1f} %" for name, p in by_size if p > LEAST_SHOWN)
        return (f"Changed since, by the evidence: {words}.",) if words else ()

    @property
    def not_shown(self) -> tuple[str, ...]:
        """A sentence on the zeros whose change would not show, where nothing changed."""
        if not self.untold:
            return ()
        return (
            f"Zeros whose change would not show in such samples: {', '.join(self.untold)}; mukca "
            "rezero says what to record for them.",
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict by name."""
        cause = None if self.cause is None else asdict(self.cause)
        return {**self.verdict.as_said(), "text": self.text, "nearest_cause": cause}


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

    It is valid if the evidence, by the full model, names no change, and its errors keep the arm's
    limits. A change is allowed that leaves the errors of the full model as small as at held-out
    places, or within limits that are given; not that of a joint's zero, if it is certain.

    Args:
        calibration: The calibration.
        data: Samples recorded since, 6 in each of two sockets; of points errors alone are told.
        stood: Placement of the calibration whose base still stands where it stood, or should.
        distance: Between the sockets' centres [m]; None for the recording's.
        repeatability: Of the arm, from which its limits follow [m]; None for what is known of it.
        ball_moved: The ball may have been taken off since, which is no change then.

    Raises:
        UsageError: No such placement.
        MeasurementError: Samples of another arm.
    """
    given = [
        measure(p, calibration.robot, distance, sockets=1, load=calibration.load)
        for p in as_list(data)
    ]
    measured = [calibration.as_read_now(m) for m in given]
    changes, now = _changes_since(calibration, measured, stood, ball_moved=ball_moved)
    errors, document = calibration.errors_of(measured), calibration.document
    limits = limits_of(document, calibration.source, Options(repeatability))
    new = errors.summary.test
    if new is not None and now is not None:
        new = structs.replace(new, calibrated=now, geometric=None)
    held_out = [m for m in measured if not calibration.was_trained_on(m)]
    advice, zeros, compared = "", bool(document.settings.get("zeros")), bool(changes.probabilities)
    samples = calibration.calibrated, new, held_out, limits
    rows, causes = rows_since(*samples, zeros=zeros, compared=compared)
    if new is None:
        reason = f"not known; {rows[0].reason}."
    elif few := too_few(measured, unchanged=bool(changes.probabilities) and not changes.changed):
        reason, changes = few, replace(changes, untold=())
        rows = [limit_row("samples", "not enough", reason, text=reason[:-1])]
    else:
        then = document.summary.test or document.summary.train
        reason, advice = _reason_and_advice(changes, rows, new, limits, then)
        before = then.calibrated.mean_absolute_error if document.summary.test and then else 0.0
        small = new.calibrated.mean_absolute_error <= before
        moved = changes.cause is not None and changes.probabilities[changes.likeliest] > CERTAIN
        tolerable = (small and not moved) or (repeatability and changes.cause is None)
        allowed = tolerable and all(row.status != "fail" for row in rows)
        status = "pass" if not changes.changed else "warning" if allowed else "fail"
        row = limit_row("validity", status, reason[:-1], text=reason[:-1])
        rows += [row] if changes.probabilities else []
    length = distance_row(
        [] if any(map(_states_lengths, measured)) else assumed_distances(document)
    )
    verdict = judge([*rows, length], causes)
    if length.status != "pass" and new is not None and verdict.kind == "not_enough":
        reason = f"{length.text}. {reason[0].upper()}{reason[1:]}"
    said = reason, advice
    return Validity(**vars(changes), errors=errors, verdict=verdict, said=said, measured=measured)


def _changes_since(
    calibration: Calibration, data: Sequence[Measurement], stood: str, *, ball_moved: bool
) -> tuple[Changes, Metrics | None]:
    """Return what changed, and the errors with the ball's new place where it was remounted."""
    if any(m.kind == "points" for m in data):
        return Changes({}), None
    every = -(-sum(len(m.positions) for m in data) // MOST_SAMPLES)
    prior, data = prior_by_all_samples(calibration), [thinned(m, every) for m in data]
    again = dict.fromkeys(prior.ball.tolist(), PUT_ON_AGAIN) if ball_moved else {}
    task = replace(socket_task(prior, data, stood), free=again)
    each = explanations(task)
    single = [one for one in each if one.name not in (LENGTHS, EVERYTHING)]
    wide = {i: w for one in single for widths in one.widths for i, w in widths.items()}
    system, converged = linear_about(task, wide, lengths=True)
    if not converged:
        return Changes({}), None
    odds = probabilities(system, each).tolist()
    changes = Changes({one.name: p for one, p in zip(each, odds, strict=True)})
    joints = prior.robot.joint_names
    if changes.likeliest == NOTHING:
        wide_open = zero_deviations(system, task) >= UNIDENTIFIABLE
        changes = replace(changes, untold=tuple(np.array(joints)[wide_open].tolist()))
    if changes.changed and changes.likeliest in joints:
        j = joints.index(changes.likeliest)
        system, own = fit_with_zeros(task, [j]), prior.zeros.start + j
        if next_step(system) > DIVERGED:
            return Changes({}), None
        offset = float(system.state.x[own] - prior.mean[own])
        rows = [m.positions + offset * np.eye(len(joints))[j] for m in data]
        pairs = zip(rows, data, strict=True)
        left = mean_metrics([evaluate(calibration.calibrated.ball(q), m) for q, m in pairs])
        unit = "m" if prior.robot.actuated[j].type == "prismatic" else "rad"
        cause = NearestCause(changes.likeliest, offset, left.mean_absolute_error, unit)
        changes = replace(changes, cause=cause)
    if not ball_moved:
        return changes, None
    system = fit(task.with_exact_arm)
    shift = (system.state.x - prior.mean)[prior.ball]
    if shift @ np.linalg.solve(system.posterior_covariance(prior.ball), shift) > FAR_MOVED**2:
        changes = replace(changes, ball=float(np.linalg.norm(shift)))
    left = np.linalg.norm(system.residuals, axis=1)
    return changes, Metrics(float(left.mean()), float(left.max()), None)


def _states_lengths(measured: Measurement) -> bool:
    """Return True where a length of the recording was measured."""
    seated = measured.has_distance and measured.distance_source != "default"
    return measured.kind == "points" or seated


def _reason_and_advice(
    changes: Changes,
    rows: Sequence[LimitResult],
    new: Summary,
    limits: Limits,
    then: Summary | None,
) -> tuple[str, str]:
    """Return the reason of the verdict, by the full model's errors, and the next step."""
    mean, length = new.loaded.mean_absolute_error, new.loaded.distance_error
    likely, before = changes.likeliest, then and then.calibrated.mean_absolute_error
    allowed, most = limits.mean_absolute_error.value, limits.distance_error.value
    limit, full = f", limit {mm(allowed)}" if allowed else "", new.calibrated.mean_absolute_error
    figures = f"{mm(mean)}{limit}"
    drifted = f"drifted: {mm(full)}{limit}" + (f", {mm(before)} when it was made" if before else "")
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
    if status.get("distance_error") == "fail" != status["mean_absolute_error"] and length and most:
        reason = f"not valid: the sockets' distance is off by {mm(length)}, limit {mm(most)}"
        return f"{reason}; check --distance, and calibrate again.", ""
    if changes.changed:
        return f"{drifted}; nearest cause: {likely}, with a probability of {share}.", _NEXT[likely]
    if status.get("mean_absolute_error") == "fail":
        if before is not None and full <= WORSE * before:
            text = f"not valid ({figures}), and it was no better when it was made."
            return text, "Calibrate again with more placements."
        return f"{drifted}. No single joint explains it: calibrate again.", ""
    if not likely and allowed is None:
        return f"not known; {rows[0].reason}.", ""
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

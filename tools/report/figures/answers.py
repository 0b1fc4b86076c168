"""Answers of a report: use of the arm for a task, the next placement, the data."""

from collections.abc import Sequence

import numpy as np

from ....solver.assessment import (
    Assessment,
    Coverage,
    PlacementReport,
    RoleSummaries,
    SampleErrors,
    Verdict,
    area,
    brief_area,
    joined,
    mm,
    norms,
    short_names,
)
from ....solver.data import as_point
from ....solver.diagnostics import Diagnostic, farthest_place, fitted_alone
from ....solver.results import NextPlacement, Uncertainty
from .answer_data import data_answer, farthest_held_out, placements_with_errors
from .types import Answer, Answers, NextAnswer, UseAnswer, UseAtPlacement

_ANSWERS: dict[Answer, str] = {"yes": "yes", "mostly": "mostly (19 of 20 samples)", "no": "no"}
_BUT = {
    "fail": " But the verdict is FAIL, so mend that first.",
    "incomplete": " But the verdict is open, so see first what it lacks.",
}
SIDE = 0.05
"""A place nearer than this to the robot's x axis is neither left nor right [m]."""
_CANNOT_SEE = (
    "the flange's orientation and another tool's centre point: calibrate that tool by itself",
    "where the robot's base stands in the room, or what a camera sees",
    "loads other than the one carried while recording",
)
HARDLY_MOVED = float(np.radians(30))
"""A joint that turns less than this in a socket tells little about itself [rad]."""


def answers_of(found: Assessment, samples: Sequence[SampleErrors], tolerance: float) -> Answers:
    """Return the answers to a user's three questions, for a task's tolerance [m]."""
    document = found.predictions.document
    measured = [placement.measured for placement in found.predictions.placements]
    seated = [each for each in measured if each.kind == "sockets"]
    floors = fitted_alone(found.predictions.robot, seated)
    return Answers(
        use=_use_answer(found, document.uncertainty, tolerance),
        next=_next_answer(found, document.checks, document.next_placement),
        data=data_answer(found.placements, samples, floors, document.checks),
    )


def _use_answer(found: Assessment, uncertainty: Uncertainty | None, tolerance: float) -> UseAnswer:
    """Return the answer whether a task with a tolerance may be done, placement by placement."""
    placements, verdict = found.placements, found.verdict
    names = short_names([row.name for row in placements])
    rows = tuple(
        UseAtPlacement(
            name=name,
            called=f"{name}{_side(row.position)}",
            where=brief_area(row.position),
            answer=answer_at(row, tolerance),
        )
        for name, row in zip(names, placements, strict=True)
    )
    return UseAnswer(
        rows=rows,
        text=use_text(
            [row.called for row in rows],
            [row.answer for row in rows],
            f"{1e3 * tolerance:g}",
            verdict.status,
        ),
        meaning=_meaning_text(found.limits.repeatability),
        alone=_alone_text(found.summary),
        between=_between_text(verdict, uncertainty),
        cannot_see=(uncertainty.cannot_see if uncertainty else ()) or _CANNOT_SEE,
    )


def answer_at(row: PlacementReport, tolerance: float) -> Answer:
    """Return the answer by the URDF; ``trained on`` where errors prove nothing."""
    if row.role == "train":
        return "trained on"
    errors = row.quantiles.loaded
    if abs(row.loaded.distance_error or 0.0) > tolerance or errors.p95 > tolerance:
        return "no"
    return "yes" if errors.max <= tolerance else "mostly"


def use_text(called: Sequence[str], answers: Sequence[Answer], allowed: str, status: str) -> str:
    """Return the answer in words, from the placements' names and the answer at each."""
    at = {
        answer: joined(
            [name for name, given in zip(called, answers, strict=True) if given == answer]
        )
        for answer in _ANSWERS
    }
    parts = [f"{words} at {at[answer]}" for answer, words in _ANSWERS.items() if at[answer]]
    if not parts:
        return "Not known: no placement was held out, and errors on what was fitted prove nothing."
    text = f"For a task that allows an error of {allowed} mm: {'; '.join(parts)}."
    return text + _BUT.get(status, "")


def _side(position: Sequence[float]) -> str:
    """Return the robot's side of a place in words, since its name may be given from the other."""
    if abs(position[1]) < SIDE:
        return ""
    return f" (to the robot's {'left' if position[1] > 0 else 'right'})"


def _meaning_text(repeatability: float | None) -> str:
    """Return the definition of the error, and that the repeatability bounds it below."""
    text = (
        "The error is the distance in space of the ball's centre: for a peg, enter half of what "
        "its diameter leaves free. Tilt is not in it."
    )
    if repeatability is None:
        return text
    return f"{text} The arm itself repeats to {1e3 * repeatability:g} mm; nothing brings it below."


def _alone_text(summary: RoleSummaries) -> str | None:
    """Return the errors of the URDF and of the full model; None where they are one."""
    _, judged = summary.judged
    if judged.geometric is None:
        return None
    return (
        f"The exported URDF alone stands at {mm(judged.geometric.mean_absolute_error, 3)} on "
        "average, and that is what is answered for. With the joint positions corrected first, as "
        f"mukca export --to c does it, it is {mm(judged.calibrated.mean_absolute_error, 3)}."
    )


def _between_text(verdict: Verdict, uncertainty: Uncertainty | None) -> str:
    """Return the accuracy of points that were computed, as from a drawing, and not taught."""
    row = next(row for row in verdict.limits if row.name == "between_placements")
    start = (
        "This is about a point taught at the place itself and reached again in another "
        "configuration. A point computed from another place (a drawing, a pallet) also carries "
        "the error of the distance between the two: "
    )
    if row.found is not None:
        return f"{start}{mm(row.found)} on average here."
    text = f"{start}not evaluated, since no such distance is known."
    if uncertainty is None:
        return text
    known = uncertainty.distance_deviation
    expected = known.median if known.alone is None else known.alone
    return (
        f"{text} The calibration itself expects {mm(expected)} (one "
        "standard deviation, half of the distances in the workspace less)."
    )


def _next_answer(
    found: Assessment, checks: Sequence[Diagnostic] | None, advice: NextPlacement | None
) -> NextAnswer:
    """Return the placements to train on and to record next, and the joints to turn more.

    The method's own advice counts; without it, the place farthest from all others.
    """
    placements = found.placements
    names = short_names([row.name for row in placements])
    positions = np.array([row.position for row in placements])
    place = as_point(farthest_place(positions))
    joints = _hardly_moved(found.coverage)
    wrong = placements_with_errors(placements, checks)
    texts = [f"First mend {joined([names[i] for i in wrong])}, see below."] if wrong else []
    train_on: str | None = None
    if advice is not None and advice.text:
        texts.append(advice.text)
    else:
        farthest = farthest_held_out(placements, wrong)
        if farthest is not None:
            train_on = names[farthest[0]]
            texts.append(
                f"Train on {train_on} too: it is recorded already, and with {farthest[1]:.2f} m "
                "the farthest from what was trained on; the two most distant placements serve best."
            )
        gap = float(norms(positions - place).min())
        held_out = "" if any(row.role == "test" for row in placements) else ", to hold out,"
        texts.append(
            f"Record a new one{held_out} about {area(place)} as the robot sees it, "
            f"{gap:.2f} m from the nearest so far, or as near to there as your table allows."
        )
    if joints:
        texts.append(
            f"Turn {joined(joints)} more: in some socket trained on, too little to learn from."
        )
    return NextAnswer(text=" ".join(texts), train_on=train_on, place=place, joints=tuple(joints))


def _hardly_moved(coverage: Coverage) -> list[str]:
    """Return the joints that hardly turned in some socket that was trained on."""
    trained = [socket for socket in coverage.sockets if socket.role == "train"]
    return [
        joint.name
        for i, joint in enumerate(coverage.joints)
        if joint.unit == "rad"
        and any(socket.high[i] - socket.low[i] < HARDLY_MOVED for socket in trained)
    ]

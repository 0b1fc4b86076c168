"""Answers of a report to the three questions that a user has."""

from collections.abc import Sequence

import numpy as np

from ....solver import assessment, diagnostics
from ....solver.assessment import area
from ....solver.identification.data import as_point
from ....solver.results import Diagnostic
from . import types
from .templates import text
from .types import Answer

FAR = 3.0
"""A sample this many times its placement's mean error from its socket deserves a look."""
UNSOUND = 10.0
"""A placement whose error when fitted alone is so many repeatabilities is recorded wrongly."""
_DRIFTS = ("fail", "not enough", "warning")
"""Of the reasons of a verdict that tell of a drift, or leave one possible."""
SIDE = 0.05
"""A place nearer than this to the robot's x axis is neither left nor right [m]."""
_CANNOT_SEE = (
    "the flange's orientation and another tool's centre point: calibrate that tool by itself",
    "where the robot's base stands in the room, or what a camera sees",
    "loads other than the one carried while recording",
)
HARDLY_MOVED = float(np.radians(30))
"""A joint that turns less than this in a socket is hardly identifiable by it [rad]."""


def answers_of(
    result: assessment.Assessment, samples: Sequence[assessment.SampleErrors]
) -> types.Answers:
    """Return the answers to a user's three questions."""
    return types.Answers(
        use=_use_answer(result),
        next=_next_answer(result),
        data=_data_answer(result, samples),
    )


def _data_answer(
    result: assessment.Assessment,
    samples: Sequence[assessment.SampleErrors],
) -> types.DataAnswer:
    """Return the answer whether the recordings are sound: checks, lone fits, farthest samples."""
    placements = result.placements
    names = result.predictions.names
    checks = result.predictions.document.checks
    farthest = sorted(samples, key=lambda sample: -sample.error())[:5]
    worst = [_worst(sample, placements[sample.placement]) for sample in farthest]
    faulty = placements_with_errors(result)
    fits = _lone_fits(result)
    floors = [fit.mean_absolute_error for fit in fits]
    repeatability = result.limits.repeatability
    limit = np.inf if repeatability is None else UNSOUND * repeatability
    words = text(
        "data",
        checked=checks is not None,
        levels=[check.level for check in checks or ()],
        drifts=[
            row.text
            for row in result.verdict.reasons
            if "drift" in row.name and row.status in _DRIFTS
        ],
        trained=[names[i] for i in faulty if placements[i].role != "test"],
        floors=floors,
        repeatability=repeatability,
        unsound=[fit.name for fit in fits if fit.mean_absolute_error > limit],
        odd=_standing_out(fits),
        worst=worst[0],
        far=FAR,
    )
    return types.DataAnswer(text=words, worst=tuple(worst), floors=fits)


def _lone_fits(result: assessment.Assessment) -> tuple[types.LoneFit, ...]:
    """Return the error of each placement with sockets when it is fitted alone."""
    predictions = result.predictions
    measured = [placement.measured for placement in predictions.placements]
    in_sockets = [m for m in measured if m.kind == "sockets"]
    floors = diagnostics.fitted_alone(predictions.robot, in_sockets)
    return tuple(
        types.LoneFit(name=name, mean_absolute_error=floors[row.name])
        for name, row in zip(predictions.names, result.placements, strict=True)
        if row.name in floors
    )


def _standing_out(fits: Sequence[types.LoneFit]) -> list[str]:
    """Return the names of the placements whose error stands out among those of all."""
    if len(fits) < 2:
        return []
    medians = diagnostics.standing_out([fit.mean_absolute_error for fit in fits])
    pairs = zip(fits, medians, strict=True)
    return [fit.name for fit, median in pairs if median is not None]


def _worst(
    sample: assessment.SampleErrors, placement: assessment.PlacementReport
) -> types.WorstSample:
    mean = placement.calibrated.mean_absolute_error
    return types.WorstSample.filled(
        sample,
        where=sample.where or f"{placement.name}, sample {sample.number}",
        name=placement.name,
        error=sample.error(),
        ratio=sample.error() / mean if mean > 0 else 0.0,
    )


def _use_answer(result: assessment.Assessment) -> types.UseAnswer:
    """Return the answer whether the task may be done, placement by placement.

    Where nobody said what the task allows, it is the least that does.
    """
    document = result.predictions.document
    rows = _uses(result)
    status = result.verdict.stamp
    if result.task is None:
        least = {row.called: row.least for row in rows if row.least is not None}
        words = text("ask", least=least, status=status)
    else:
        called = [row.called for row in rows]
        answers: list[Answer] = [row.answer for row in rows]
        words = use_text(called, answers, f"{1e3 * result.tolerance:g}", status)
    limits = {row.name: row.found for row in result.verdict.limits}
    between = limits.get("between_placements")
    unseen = document.uncertainty and document.uncertainty.cannot_see
    return types.UseAnswer(
        rows=tuple(rows),
        text=words,
        meaning=text("meaning", repeatability=result.limits.repeatability),
        alone=text("alone", judged=result.summary.judged[1]) or None,
        between=text("between", found=between, better=document.better),
        cannot_see=unseen or _CANNOT_SEE,
    )


def _uses(result: assessment.Assessment) -> list[types.UseAtPlacement]:
    """Return the answer at each placement, with its name and the robot's side."""
    rows: list[types.UseAtPlacement] = []
    for name, row in zip(result.predictions.names, result.placements, strict=True):
        _, y, _ = row.position
        called = name
        if abs(y) >= SIDE:  # the name may be given from the other side
            side = "left" if y > 0 else "right"
            called += f" (to the robot's {side})"
        use = types.UseAtPlacement(
            name=name,
            called=called,
            where=area(row.position, brief=True),
            answer=answer_at(row, result.tolerance),
            least=least_allowed(row),
        )
        rows.append(use)
    return rows


def answer_at(row: assessment.PlacementReport, tolerance: float) -> Answer:
    """Return the answer by the URDF; ``trained on`` where errors prove nothing."""
    least = least_allowed(row)
    if least is None:
        return "trained on"
    if mostly_allowed(row) > tolerance:
        return "no"
    return "yes" if least <= tolerance else "mostly"


def mostly_allowed(row: assessment.PlacementReport) -> float:
    """Return the least error that a task may allow for 19 of 20 samples to keep it [m]."""
    return max(abs(row.loaded.distance_error or 0.0), row.quantiles.loaded.p95)


def least_allowed(row: assessment.PlacementReport) -> float | None:
    """Return the least error for all samples to keep it [m]; None where it was trained on."""
    if row.role == "train":
        return None
    return max(mostly_allowed(row), row.quantiles.loaded.max)


def use_text(
    called: Sequence[str], answers: Sequence[Answer], allowed: str, status: str
) -> str:
    """Return the answer in words, from the placements' names and the answer at each."""
    names: dict[str, list[str]] = {"yes": [], "mostly": [], "no": []}
    for name, answer in zip(called, answers, strict=True):
        names.setdefault(answer, []).append(name)
    return text("use", at=names, allowed=allowed, status=status)


def _next_answer(result: assessment.Assessment) -> types.NextAnswer:
    """Return what to train on and to record next: the method's advice, or the farthest place."""
    placements = result.placements
    names = result.predictions.names
    advice = result.predictions.document.next_placement
    positions = np.array([row.position for row in placements])
    place = as_point(diagnostics.farthest_place(positions))
    sockets = [socket for socket in result.coverage.sockets if socket.role == "train"]
    joints = [
        joint.name
        for i, joint in enumerate(result.coverage.joints)
        if joint.unit == "rad"
        and any(s.high[i] - s.low[i] < HARDLY_MOVED for s in sockets)
    ]
    advised = advice.text if advice else ""
    farthest = None if advised else farthest_held_out(result)
    train_on = names[farthest[0]] if farthest else None
    words = text(
        "next",
        wrong=[names[i] for i in placements_with_errors(result)],
        advice=advised,
        train_on=train_on,
        far=farthest and farthest[1],
        proved=any(row.role != "train" for row in placements),
        place=place,
        gap=float(np.linalg.norm(positions - place, axis=1).min()),
        joints=joints,
    )
    return types.NextAnswer(
        text=words, train_on=train_on, place=place, joints=tuple(joints)
    )


def placements_with_errors(result: assessment.Assessment) -> list[int]:
    """Return the indices of the placements in which the checks found errors.

    An error of all placements is of all of them only where none has one alone.
    """
    checks = result.predictions.document.checks or ()
    errors = [check for check in checks if check.level == "error"]
    faulty = placements_named(result, errors)
    everywhere = any(error.where == diagnostics.EVERYWHERE for error in errors)
    return [*range(len(result.placements))] if everywhere and not faulty else faulty


def placements_named(
    result: assessment.Assessment, checks: Sequence[Diagnostic]
) -> list[int]:
    """Return the indices of the placements that findings name."""
    paths = " ".join(f"/{check.where}/" for check in checks)
    return [i for i, row in enumerate(result.placements) if f"/{row.name}/" in paths]


def farthest_held_out(result: assessment.Assessment) -> tuple[int, float] | None:
    """Return the sound placement farthest from those trained on, and its distance to them [m]."""
    positions = np.array([row.position for row in result.placements])
    is_training = np.array([row.role == "train" for row in result.placements])
    faulty = placements_with_errors(result)
    candidates = [i for i in np.flatnonzero(~is_training).tolist() if i not in faulty]
    if not candidates or not is_training.any():
        return None
    offsets = positions[candidates][:, None] - positions[is_training]
    gaps = np.linalg.norm(offsets, axis=2).min(axis=1)
    best = int(np.argmax(gaps))
    return candidates[best], float(gaps[best])

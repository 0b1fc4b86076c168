"""Answers of a report, and the templates, which hold each sentence as a translator wants it."""

from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....solver import assessment, diagnostics
from ....solver.assessment import area, fixed, joined, mm, percent, plural, short_where
from ....solver.data import as_point
from . import types
from .types import Answer

if TYPE_CHECKING:
    from jinja2 import Environment

FOLDER = Path(__file__).parents[1] / "templates"


def each(rows: Iterable[object], form: str) -> list[str]:
    """Return each row written by a format of Python, in which it is ``0``."""
    return [form.format(row) for row in rows]


_FILTERS = (area, each, fixed, joined, mm, percent, plural, short_where)


@cache
def environment() -> "Environment":
    """Return the templates; what they insert is escaped in pages, and left as it is in texts."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

    templates = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=select_autoescape(["html.j2"]),
        undefined=StrictUndefined,
        extensions=["jinja2.ext.do"],
        trim_blocks=True,
        lstrip_blocks=True,
    )
    filters: dict[str, Any] = {function.__name__: function for function in _FILTERS}
    templates.filters.update(filters, short="{:g}".format)
    return templates


def lines(template: str, block: str, /, **values: object) -> list[str]:
    """Return the lines of a block of a template."""
    source = environment().get_template(template)
    written = "".join(source.blocks[block](source.new_context(values)))
    return [words for line in written.splitlines() if (words := " ".join(line.split()))]


def text(template: str, block: str, /, **values: object) -> str:
    """Return a block of a template as one line of text."""
    return " ".join(lines(template, block, **values))


FAR = 3.0
"""A sample this many times its placement's mean error from its socket deserves a look."""
UNSOUND = 10.0
"""A placement whose error when fitted alone is so many repeatabilities is recorded wrongly."""
_TEXTS = "answers.txt.j2"
_DRIFTS = ("fail", "not enough", "warning")
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
    result: assessment.Assessment, samples: Sequence[assessment.SampleErrors]
) -> types.DataAnswer:
    placements = result.placements
    names = result.predictions.names
    checks = result.predictions.document.checks
    farthest = sorted(samples, key=lambda sample: -sample.error())[:5]
    worst = [_worst(sample, placements[sample.placement]) for sample in farthest]
    measured = [placement.measured for placement in result.predictions.placements]
    in_sockets = [
        measurement for measurement in measured if measurement.kind == "sockets"
    ]
    floors = diagnostics.fitted_alone(result.predictions.robot, in_sockets)
    rows = zip(names, placements, strict=True)
    floor_by_name = {name: floors[row.name] for name, row in rows if row.name in floors}
    residuals = list(floor_by_name.values())
    typical = diagnostics.standing_out(residuals) if len(residuals) > 1 else residuals
    repeatability = result.limits.repeatability
    limit = np.inf if repeatability is None else UNSOUND * repeatability
    reasons = result.verdict.reasons
    words = text(
        _TEXTS,
        "data",
        checked=checks is not None,
        levels=[check.level for check in checks or ()],
        drifts=[
            row.text for row in reasons if "drift" in row.name and row.status in _DRIFTS
        ],
        trained=[
            names[i]
            for i in placements_with_errors(result)
            if placements[i].role == "train"
        ],
        floors=residuals,
        repeatability=repeatability,
        unsound=[name for name, floor in floor_by_name.items() if floor > limit],
        odd=[
            name
            for name, odd_one in zip(floor_by_name, typical, strict=True)
            if odd_one is not None
        ],
        worst=worst[0],
        far=FAR,
    )
    fits = [
        types.LoneFit(name=name, mean_absolute_error=floor)
        for name, floor in floor_by_name.items()
    ]
    return types.DataAnswer(text=words, worst=tuple(worst), floors=tuple(fits))


def _worst(
    sample: assessment.SampleErrors, placement: assessment.PlacementReport
) -> types.WorstSample:
    error = sample.error()
    mean = placement.calibrated.mean_absolute_error
    return types.WorstSample.filled(
        sample,
        where=sample.where or f"{placement.name}, sample {sample.number}",
        name=placement.name,
        error=error,
        ratio=error / mean if mean > 0 else 0.0,
    )


def _use_answer(result: assessment.Assessment) -> types.UseAnswer:
    """Return the answer whether the task may be done, placement by placement."""
    uncertainty = result.predictions.document.uncertainty
    answers: list[Answer] = [
        answer_at(row, result.tolerance) for row in result.placements
    ]
    rows: list[types.UseAtPlacement] = []
    for name, row, answer in zip(
        result.predictions.names, result.placements, answers, strict=True
    ):
        y = row.position[1]  # the name may be given from the other side
        side = (
            "" if abs(y) < SIDE else f" (to the robot's {'left' if y > 0 else 'right'})"
        )
        where = area(row.position, brief=True)
        use = types.UseAtPlacement(
            name=name,
            called=name + side,
            where=where,
            answer=answer,
            least=least_allowed(row),
        )
        rows.append(use)
    limits = {row.name: row.found for row in result.verdict.limits}
    called = [row.called for row in rows]
    status = result.verdict.stamp
    words = use_text(called, answers, f"{1e3 * result.tolerance:g}", status)
    if result.task is None:
        least = {row.called: row.least for row in rows if row.least is not None}
        words = text(_TEXTS, "ask", least=least, status=status)
    return types.UseAnswer(
        rows=tuple(rows),
        text=words,
        meaning=text(_TEXTS, "meaning", repeatability=result.limits.repeatability),
        alone=text(_TEXTS, "alone", judged=result.summary.judged[1]) or None,
        between=text(
            _TEXTS,
            "between",
            found=limits.get("between_placements"),
            uncertainty=uncertainty,
        ),
        cannot_see=(uncertainty.cannot_see if uncertainty else ()) or _CANNOT_SEE,
    )


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
    pairs = list(zip(called, answers, strict=True))
    words: tuple[Answer, ...] = ("yes", "mostly", "no")
    names_by_word = {
        word: [name for name, answer in pairs if answer == word] for word in words
    }
    return text(_TEXTS, "use", at=names_by_word, allowed=allowed, status=status)


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
        _TEXTS,
        "next",
        wrong=[names[i] for i in placements_with_errors(result)],
        advice=advised,
        train_on=train_on,
        far=farthest and farthest[1],
        held_out=any(row.role == "test" for row in placements),
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
    wheres = [check.where for check in checks if check.level == "error"]
    paths = " ".join(f"/{where}/" for where in wheres)
    faulty = [i for i, row in enumerate(result.placements) if f"/{row.name}/" in paths]
    everywhere = diagnostics.EVERYWHERE in wheres
    return [*range(len(result.placements))] if everywhere and not faulty else faulty


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

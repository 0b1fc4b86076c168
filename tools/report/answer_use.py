"""May I use this arm for my task? The answer, placement by placement."""

from collections.abc import Mapping, Sequence
from typing import Any

from .words import brief_area, joined, mm, short_names

__all__ = ["use_answer"]

_ANSWERS = {"yes": "yes", "mostly": "mostly (19 of 20 samples)", "no": "no"}
SIDE = 0.05
"""A place less than this off the robot's middle is on neither side [m]."""
_CANNOT_SEE = (
    "the flange's orientation and another tool's centre point: calibrate that tool by itself",
    "where the robot's base stands in the room, or what a camera sees",
    "loads other than the one carried while recording",
)


def use_answer(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return whether a task with the given tolerance may be done, placement by placement."""
    tolerance = figures["tolerance"]
    names = short_names([row["name"] for row in figures["placements"]])
    rows = [
        {
            "name": name,
            "called": f"{name}{_side(row['position'])}",
            "where": brief_area(row["position"]),
            "answer": _answer(row, tolerance),
        }
        for name, row in zip(names, figures["placements"], strict=True)
    ]
    uncertainty: dict[str, Any] = figures.get("uncertainty") or {}
    return {
        "rows": rows,
        "text": _use_text(rows, tolerance, figures["verdict"]["status"]),
        "meaning": _meaning_text(figures),
        "alone": _alone_text(figures),
        "between": _between_text(figures),
        "cannot_see": list(uncertainty.get("cannot_see") or _CANNOT_SEE),
    }


def _answer(row: Mapping[str, Any], tolerance: float) -> str:
    """Return ``yes``, ``mostly``, ``no``, or ``trained on``, which proves nothing."""
    if row["role"] == "train":
        return "trained on"
    found = row["quantiles"]["calibrated"]
    if abs(row["calibrated"]["distance_error"] or 0.0) > tolerance or found["p95"] > tolerance:
        return "no"
    return "yes" if found["max"] <= tolerance else "mostly"


def _use_text(rows: Sequence[Mapping[str, Any]], tolerance: float, status: str) -> str:
    at = {
        answer: joined([row["called"] for row in rows if row["answer"] == answer])
        for answer in _ANSWERS
    }
    parts = [f"{_ANSWERS[answer]} at {names}" for answer, names in at.items() if names]
    if not parts:
        return "Not known: no placement was held out, and errors on what was fitted prove nothing."
    text = f"For a task that allows an error of {1e3 * tolerance:g} mm: {'; '.join(parts)}."
    if status == "fail":
        text += " But the verdict is FAIL, so mend that first."
    return text


def _side(position: Sequence[float]) -> str:
    """Return on which of the robot's sides a place lies, since names come from either side."""
    if abs(position[1]) < SIDE:
        return ""
    return f" (to the robot's {'left' if position[1] > 0 else 'right'})"


def _meaning_text(figures: Mapping[str, Any]) -> str:
    """Return what error is meant, and below what no calibration brings it."""
    text = (
        "The error is the distance in space of the ball's centre: for a peg, enter half of what "
        "its diameter leaves free. Tilt is not in it."
    )
    repeatability: float | None = figures["limits"]["repeatability"]
    if repeatability is None:
        return text
    return f"{text} The arm itself repeats to {1e3 * repeatability:g} mm; nothing brings it below."


def _alone_text(figures: Mapping[str, Any]) -> str | None:
    """Return what holds for those who load the exported URDF; None where that is all there is."""
    summary = figures["summary"]["test"] or figures["summary"]["train"]
    if "geometric" not in summary:
        return None
    geometric = summary["geometric"]["mean_absolute_error"]
    full = summary["calibrated"]["mean_absolute_error"]
    return (
        f"This is the full model, which corrects the joint positions first. The exported URDF "
        f"alone stands at {mm(geometric, 3)} on average, {geometric / full:.1f} times as much: "
        "to judge that, divide what your task allows by as much before you enter it."
    )


def _between_text(figures: Mapping[str, Any]) -> str:
    """Return what is known of points that were not taught at the place itself."""
    row = next(r for r in figures["verdict"]["limits"] if r["name"] == "between_placements")
    start = (
        "This is about a point taught at the place itself and reached again in another "
        "configuration. A point computed from another place (a drawing, a pallet) also carries "
        "the error of the distance between the two: "
    )
    if row["found"] is not None:
        return f"{start}{mm(row['found'])} on average here."
    text = f"{start}not evaluated, since no such distance is known."
    uncertainty: dict[str, Any] = figures.get("uncertainty") or {}
    expected: dict[str, float] | None = uncertainty.get("distance_deviation")
    if expected is None:
        return text
    return (
        f"{text} The calibration itself expects {mm(expected['median'])} (one standard deviation, "
        "half of the distances in the workspace less)."
    )

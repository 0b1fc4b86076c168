"""The report's answers in plain words: may I use it, what next, is my data all right."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .evidence import Evidence
from .words import area, joined, mm, plural, short_names

__all__ = ["FAR", "HARDLY_MOVED", "STANDS_OUT", "data_answer", "next_answer", "use_answer"]

HARDLY_MOVED = float(np.radians(30))
"""A joint that turns less than this in a placement tells little about itself [rad]."""
FAR = 3.0
"""A sample this many times its placement's mean error from its socket deserves a look."""
STANDS_OUT = 2.5
"""A placement that leaves this many times the best one's error, both fitted alone, is suspect."""
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
            "where": area(row["position"]),
            "answer": _answer(row, tolerance),
        }
        for name, row in zip(names, figures["placements"], strict=True)
    ]
    uncertainty = figures.get("uncertainty") or {}
    return {
        "rows": rows,
        "text": _use_text(rows, tolerance, figures["verdict"]["status"]),
        "between": _between_text(figures),
        "cannot_see": list(uncertainty.get("cannot_see") or _CANNOT_SEE),
    }


def _answer(row: Mapping[str, Any], tolerance: float) -> str:
    """Return ``yes``, ``mostly``, ``no``, or ``trained on``, which proves nothing."""
    if row["role"] == "train":
        return "trained on"
    found = row["quantiles"]["calibrated"]
    if abs(row["calibrated"]["distance_error"]) > tolerance or found["p95"] > tolerance:
        return "no"
    return "yes" if found["max"] <= tolerance else "mostly"


def _use_text(rows: Sequence[Mapping[str, Any]], tolerance: float, status: str) -> str:
    at = {
        answer: joined([row["name"] for row in rows if row["answer"] == answer])
        for answer in ("yes", "mostly", "no")
    }
    parts = [f"{answer} at {names}" for answer, names in at.items() if names]
    if not parts:
        return "Not known: no placement was held out, and errors on what was fitted prove nothing."
    text = f"For a task that allows an error of {1e3 * tolerance:g} mm: {'; '.join(parts)}."
    if status == "fail":
        text += " But the calibration fails its limits, so mend that first."
    return text


def _between_text(figures: Mapping[str, Any]) -> str:
    """Return what is known of points that were not taught at the place itself."""
    row = next(r for r in figures["verdict"]["limits"] if r["name"] == "between_placements")
    start = (
        "This is about a point taught at the place itself and reached again in another "
        "configuration. A point computed from another place (a drawing, a pallet) also carries "
        "the error of the distance between the two: "
    )
    if row["found"] is None:
        return f"{start}not evaluated, since no such distance is known."
    return f"{start}{mm(row['found'])} on average here."


def next_answer(figures: Mapping[str, Any], evidence: Evidence) -> dict[str, Any]:
    """Return which placement to train on and to record next, and which joints to turn more.

    Returns:
        ``text``; ``train_on``, a placement recorded already, or None; ``place``, a point in the
        base frame [m]; ``joints`` that hardly moved.
    """
    positions = np.array([row["position"] for row in figures["placements"]])
    trained = np.array([row["role"] == "train" for row in figures["placements"]])
    names = short_names([row["name"] for row in figures["placements"]])
    place = farthest_place(positions, _turning_range(evidence))
    joints = hardly_moved(figures)
    given = (figures.get("next_placement") or {}).get("text")
    texts = [given] if given else []
    train_on = None
    if not trained.all() and not given:
        distances = np.linalg.norm(positions[:, None] - positions[trained], axis=2).min(axis=1)
        farthest = int(np.argmax(np.where(trained, -1.0, distances)))
        train_on = names[farthest]
        texts.append(
            f"Train on {train_on} too: it is recorded already, and with {distances[farthest]:.2f} "
            "m the farthest from what was trained on; the two most distant placements serve best."
        )
    gap = float(np.linalg.norm(positions - place, axis=1).min())
    held_out = "" if not trained.all() else ", to hold out"
    texts.append(
        f"Record a new one{held_out} about {area(place)} as the robot sees it, {gap:.2f} m from "
        "the nearest so far, or as near to there as your table allows."
    )
    if joints:
        texts.append(
            f"Turn {joined(joints)} more: in some socket that was trained on it hardly moved."
        )
    return {
        "text": " ".join(texts),
        "train_on": train_on,
        "place": place.tolist(),
        "joints": joints,
    }


def _turning_range(evidence: Evidence) -> tuple[float, float]:
    """Return how far the arm turns about its base's vertical [rad]; half a turn each way if it
    is not told."""
    first = evidence.chain.actuated[0]
    return max(first.lower, -np.pi), min(first.upper, np.pi)


def farthest_place(
    positions: NDArray[np.float64], turning: tuple[float, float]
) -> NDArray[np.float64]:
    """Return the point farthest from all recorded placements that the arm reaches as well.

    Candidates are the recorded placements, turned about the base's vertical axis by up to 75
    degrees and within what the first joint can turn: an arm that reaches one reaches them all.

    Args:
        positions: Of the placements, shape (P, 3) [m].
        turning: Range of the first joint [rad].
    """
    middle = positions[:, :2].mean(axis=0)
    ahead = np.arctan2(middle[1], middle[0])
    room = min(np.radians(75), 0.8 * (turning[1] - turning[0]) / 2)
    angles = ahead + np.linspace(-room, room, 41)
    radii = np.hypot(positions[:, 0], positions[:, 1])
    candidates = np.array(
        [[r * np.cos(a), r * np.sin(a), z] for r, z in zip(radii, positions[:, 2]) for a in angles]
    )
    gaps = np.linalg.norm(candidates[:, None] - positions, axis=2).min(axis=1)
    return candidates[int(np.argmax(gaps))]


def hardly_moved(figures: Mapping[str, Any]) -> list[str]:
    """Return the joints that hardly turned in some socket that was trained on."""
    coverage = figures["coverage"]
    return [
        joint["name"]
        for i, joint in enumerate(coverage["joints"])
        if joint["unit"] == "rad"
        and any(
            socket["high"][i] - socket["low"][i] < HARDLY_MOVED
            for socket in coverage["sockets"]
            if socket["role"] == "train"
        )
    ]


def data_answer(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return whether the recordings look sound: the checks, the floors, the farthest samples."""
    worst = worst_samples(figures)
    floors = _floors(figures)
    texts = [_checks_text(figures)]
    if floors:
        texts.append(_floors_text(floors))
    beyond = sum(row["ratio"] > FAR for row in worst)
    if beyond:
        first = worst[0]
        texts.append(
            f"Look at {first['where']}: it is {mm(first['error'])} from its socket, "
            f"{first['ratio']:.1f} times its placement's mean error."
        )
    return {"text": " ".join(texts), "worst": worst[:5], "floors": floors}


def _checks_text(figures: Mapping[str, Any]) -> str:
    checks = figures.get("checks")
    if checks is None:
        return (
            "The recordings were not checked one by one (mukca check does it); what follows is "
            "what the fits show."
        )
    errors = [check for check in checks if check["level"] == "error"]
    warnings = [check for check in checks if check["level"] == "warning"]
    if not errors and not warnings:
        return "Yes: the checks of the recordings found nothing wrong."
    if not errors:
        return f"Yes, but look at {plural(len(warnings), 'warning')} below."
    return f"No: {plural(len(errors), 'error')} below; mend or record anew, then calibrate again."


def _floors(figures: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what each placement leaves when fitted alone, the diagonal of the matrix."""
    matrix = figures["cross_placement"]
    if matrix is None:
        return []
    return [
        {"name": name, "mean_absolute_error": row[i]}
        for i, (name, row) in enumerate(
            zip(short_names(matrix["names"]), matrix["matrix"], strict=True)
        )
        if row is not None
    ]


def _floors_text(floors: Sequence[Mapping[str, Any]]) -> str:
    values = [row["mean_absolute_error"] for row in floors]
    low, high = min(values), max(values)
    text = f"Fitted alone, each placement leaves {mm(low)} to {mm(high)}"
    odd = [row["name"] for row in floors if row["mean_absolute_error"] > STANDS_OUT * low]
    if odd:
        return f"{text}: {joined(odd)} stands out, so record it anew."
    return f"{text}, as alike as placements of one arm should be."


def worst_samples(figures: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the samples by falling calibrated error, with that error [m] and its ratio.

    The ratio is to the mean absolute error of the sample's placement.
    """
    rows: list[dict[str, Any]] = []
    for row in figures["samples"]:
        placement = figures["placements"][row["placement"]]
        error = float(np.linalg.norm(row["calibrated"]))
        mean = placement["calibrated"]["mean_absolute_error"]
        rows.append(
            {
                "where": row["where"] or f"{placement['name']}, sample {row['number']}",
                "name": placement["name"],
                "socket": row["socket"],
                "number": row["number"],
                "weight": row.get("weight"),
                "error": error,
                "ratio": error / mean if mean > 0 else 0.0,
            }
        )
    return sorted(rows, key=lambda row: -row["error"])


"""Question for the sockets' distance, before a session and after it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ...recorder import METADATA, Metadata, Placement, add_reading, read_keys
from ...solver.identification.data import AGREEING
from ..cli import DISTANCES, Terminal


def with_distance(metadata: Metadata, terminal: Terminal) -> Metadata:
    """Return metadata with the distance that the operator types."""
    question = "How far apart are the sockets' centres? In mm, by a caliper; the printed base has"
    distance = _typed_distance(f"{question} 100.", "not yet measured", terminal)
    return (
        metadata
        if distance is None
        else replace(metadata, distance=distance, measured=True)
    )


def with_distance_of_base(
    metadata: Metadata, placements: Sequence[Placement], terminal: Terminal
) -> Metadata:
    """Return metadata with one distance for one base, where an earlier placement has another.

    The operator says whether it is the same base, which has the distance that was measured last.
    """
    measured = [p for p in placements if p.distance and not p.distance_assumed]
    if not measured or metadata.distance is None:
        return metadata
    last, before = measured[-1].name, measured[-1].distance or 0.0
    if abs(before - metadata.distance) <= AGREEING:
        return metadata
    question = (
        f"{last} says {1e3 * before:g} mm, this placement {1e3 * metadata.distance:g} mm. One base "
        "has one distance; of another base, type it again."
    )
    distance = _typed_distance(question, f"{1e3 * before:g}", terminal)
    return replace(metadata, distance=distance or before, measured=True)


def with_second_reading(
    metadata: Metadata, folder: Path, terminal: Terminal
) -> Metadata:
    """Return metadata with a second reading that the operator types, which the recording keeps."""
    if metadata.distance is None or len(read_keys(folder / METADATA).readings) > 1:
        return metadata
    question = "Measure the sockets' distance once more: solve believes two readings that agree."
    distance = _typed_distance(question, "no second reading", terminal)
    if distance is None:
        return metadata
    add_reading(folder, distance)
    return replace(metadata, distance=distance)


def _typed_distance(question: str, advice: str, terminal: Terminal) -> float | None:
    """Return a distance that the operator types [m]; None for an empty answer."""
    while True:
        terminal.say(question)
        try:
            answer = input(f"mm, or Enter for {advice}: ").replace("mm", "").strip()
        except EOFError:
            answer = ""
        if not answer:
            return None
        try:
            number = float(answer.replace(",", "."))
        except ValueError:
            number = math.nan
        metres = number if number < 1 else number / 1e3
        if DISTANCES[0] <= metres <= DISTANCES[1]:
            terminal.say(f"The sockets are {1e3 * metres:g} mm apart.")
            return metres
        terminal.say(f"{answer!r} is no distance in millimetres, for example 100.08")

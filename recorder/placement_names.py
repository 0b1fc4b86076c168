"""Placements among others, and their samples among others: names, copies, and what is far away."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import LENGTH
from .placement import Placement
from .recording_error import RecordingError, listed

NAMED = 2
"""Parts of its path that a placement is called by."""


def placement_name(folder: Path) -> str:
    """Return a placement's name: its folder's name after its parent's."""
    return "/".join(folder.resolve().parts[-NAMED:]).lstrip("/")


def distinctly_named(placements: Sequence[Placement]) -> list[Placement]:
    """Return placements of which no two of different folders have one name.

    Those of one name get the names of more folders above theirs, as far as these differ; those that
    were made in memory get a number.
    """
    folders = defaultdict[str, set[Path]](set)
    for placement in placements:
        if placement.path:
            folders[placement.name].add(placement.path.resolve())
    counts = Counter[str]()
    renamed: list[Placement] = []
    for placement in placements:
        name = placement.name
        path = placement.path and placement.path.resolve()
        if path and len(folders[name]) > 1:
            # The shortest name, of two parts at least, that no other folder has.
            parts = path.parts[1:]
            others = [other.parts[1:] for other in folders[name] - {path}]
            length = NAMED
            while length < len(parts) and parts[-length:] in [
                o[-length:] for o in others
            ]:
                length += 1
            name = "/".join(parts[-length:])
        elif not path:
            counts[name] += 1
            number = counts[name] + bool(folders[name])
            if number > 1:
                name = f"{name} ({number})"
        renamed.append(replace(placement, name=name))
    return renamed


SAME_ROW = 1e-6
"""Samples that differ by less are one that was written twice [rad], [m]."""


def distinct(placement: Placement) -> Placement:
    """Return the placement with samples that are equal once, and a remark on the others.

    Equal are the socket, the joint positions, and what an instrument measured there, the latter
    two to :data:`SAME_ROW`. The first of equal samples is kept.
    """
    points = [sample.point or () for sample in placement.samples]
    turns = [sample.orientation or () for sample in placement.samples]
    rows = np.column_stack(
        [placement.sockets.astype(float), placement.positions, points, turns]
    )
    copies = repeated_rows(rows)
    if not copies:
        return placement
    samples = tuple(s for i, s in enumerate(placement.samples) if i not in copies)
    places = [placement.samples[i].where for i in sorted(copies)]
    names = [Path(place).name for place in places if place]
    lines = f" ({listed(names)})" if len(names) == len(copies) else ""
    remark = (
        f"{placement.where}: {len(copies)} of {len(placement.samples)} samples repeat "
        f"another one and do not count{lines}"
    )
    return replace(placement, samples=samples, remarks=(*placement.remarks, remark))


def repeated_rows(rows: np.ndarray) -> set[int]:
    """Return the rows of numbers, shape (N, k), that equal an earlier one to :data:`SAME_ROW`."""
    weights = np.sqrt(np.arange(2.0, 2.0 + rows.shape[1]))
    key = rows @ weights
    copies: set[int] = set()
    for step in range(1, len(rows)):
        originals = np.array([i for i in range(len(rows)) if i not in copies])
        order = originals[np.argsort(key[originals], kind="stable")]
        first, second = order[:-step], order[step:]
        if not (key[second] - key[first] < SAME_ROW * weights.sum()).any():
            break
        close = np.abs(rows[first] - rows[second]).max(axis=1) < SAME_ROW
        copies |= set(np.maximum(first[close], second[close]).tolist())
    return copies


FARTHEST = 100.0
"""Coordinate beyond which a turn of the frame is no small change to a fit [m]."""
LARGEST_JOINT = 1e4
"""Joint position that no joint has, in whatever unit."""


def require_near(placement: Placement) -> None:
    """Refuse joint positions that no joint has, and places that no arm reaches.

    Raises:
        RecordingError: There is one; the message names its line.
    """
    rows = placement.positions
    what = "a joint"
    expected = "radians are expected"
    is_wrong = np.abs(rows).max(axis=1, initial=0.0) > LARGEST_JOINT
    if placement.kind == "points" and not is_wrong.any():
        rows = measured_points(placement)
        what = "x, y or z"
        expected = "metres are expected, from an origin near the arm"
        offsets = np.abs(rows - np.median(rows, axis=0)).max(axis=1)
        is_wrong = (offsets > LENGTH.largest) | (np.abs(rows).max(axis=1) > FARTHEST)
        advice = "delete such a line"
        if is_wrong.mean() > 0.5:
            advice = placement.advice("a header of x [mm] is read as such")
            advice = f"millimetres? {advice}"
        expected = f"{expected} ({advice})"
    first, *others = np.flatnonzero(is_wrong).tolist() or [-1]
    if first >= 0:
        where = placement.samples[first].where or placement.name
        worst = max(rows[first].tolist(), key=abs)
        words = f"; {len(others)} more such lines" if others else ""
        raise RecordingError(f"{where}: {what} is {worst:.6g}: {expected}{words}")


def measured_points(placement: Placement) -> np.ndarray:
    """Return what an instrument measured, row by row, shape (N, 3) [m]."""
    return np.array([sample.point for sample in placement.samples], dtype=float)

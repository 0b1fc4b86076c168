"""Placements that are recorded already, beside those of a calibration."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ....errors import MukcaError
from ....recorder import RecordingError, find_placements, read_placement
from ....solver.assessment import LEAST_HELD_OUT, Assessment
from ....solver.identification.data import NEAREST, measure
from ....solver.tables import parse_left_out


class UnusedPlacement(NamedTuple):
    """A placement that a calibration did not use, though it lies beside its recordings."""

    folder: str
    gap: float
    """Distance from the nearest place that was trained on [m]."""

    @property
    def name(self) -> str:
        """Name of its folder."""
        return Path(self.folder).name


def unused_placements(result: Assessment) -> list[UnusedPlacement]:
    """Return the unused placements, that farthest from those trained on first.

    Several arms share their recordings' folders, so nothing is looked for there.
    """
    if result.predictions.document.arms is not None:
        return []
    return sorted(_unused(result), key=lambda placement: -placement.gap)


def _unused(result: Assessment) -> Iterator[UnusedPlacement]:
    """Yield the placements of this robot's joints beside the recordings that were not used."""
    predictions = result.predictions
    rows = [row for row in predictions.document.data if row.files]
    used = {Path(row.folder).resolve() for row in rows}
    places = np.array([p.position for p in predictions.of_role("train")])
    for parent in dict.fromkeys(Path(row.folder).parent for row in rows):
        folders: list[Path] = []
        with suppress(RecordingError):  # on another computer, they are not there
            folders = find_placements([parent])
        for folder in folders:
            if folder.resolve() in used:
                continue
            place = _place_of(folder, result)
            if place is None:
                continue
            gap = float(np.linalg.norm(places - place, axis=1).min())
            if gap >= NEAREST:
                yield UnusedPlacement(str(folder), gap)


def _place_of(folder: Path, result: Assessment) -> np.ndarray | None:
    """Return the middle of the sockets of a placement [m]; None where it is of no use.

    That is one of another arm, one that the calibration was to leave out, or with few samples.
    """
    calibration = result.predictions.calibration
    document = result.predictions.document
    try:
        placement = read_placement(folder)
        measured = measure(placement, calibration.robot)
    except MukcaError:
        return None
    left_out = map(parse_left_out, document.settings.get("leave_out") or ())
    if any(item.names(placement) for item in left_out):
        return None
    faulty = any(check.where.startswith(str(folder)) for check in document.checks or ())
    if faulty or not measured.has_distance or min(measured.counts) < LEAST_HELD_OUT:
        return None
    return calibration.ball(measured.positions, measured.efforts).mean(axis=0)

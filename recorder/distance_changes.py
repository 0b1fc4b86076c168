"""Readings of the distance between a placement's sockets, as they come into ``placement.json``."""

from collections.abc import Callable
from pathlib import Path

from .files import locked
from .metadata import (
    METADATA,
    Contents,
    entries_of,
    now,
    read_keys,
    read_metadata,
    write_metadata,
)
from .recording_error import RecordingError
from .samples import SAMPLES


def set_distance(folder: Path, distance: float) -> float | None:
    """Correct the distance between a placement's sockets [m]; return the earlier one, kept too.

    Raises:
        RecordingError: The file cannot be read or written, or a recorder has it open.
    """
    return _rewrite(folder, distance, with_distance)


def add_reading(folder: Path, distance: float) -> float | None:
    """Add a reading of the distance between a placement's sockets [m]; return the one before.

    Raises as :func:`set_distance`.
    """
    return _rewrite(folder, distance, with_reading)


def _rewrite(
    folder: Path,
    distance: float,
    change: Callable[[Contents, float], Contents],
) -> float | None:
    """Write a placement's metadata with its distance changed; return the earlier one.

    Raises:
        RecordingError: The file cannot be read or written, or a recorder has it open.
    """
    file = folder / METADATA
    samples = folder / SAMPLES
    if not samples.exists():  # which the recorder locks
        samples = min(folder.glob("*.csv"), default=None)
    try:
        with locked(samples):
            before = read_keys(file).distance
            write_metadata(folder, change(read_metadata(file), distance))
    except BlockingIOError:
        raise RecordingError(
            f"{folder}: mukca record is writing there; finish it first"
        ) from None
    except OSError as error:
        raise RecordingError(f"{file}: cannot be written: {error.strerror}") from None
    return before


def with_distance(metadata: Contents, distance: float) -> Contents:
    """Return metadata with another distance between the sockets [m], and the earlier one kept."""
    change = {"time": now(), "distance": [metadata.get("distance"), distance]}
    changes = [*entries_of(metadata, "changes"), change]
    return {
        **metadata,
        "distance": distance,
        "distance_measured": True,
        "changes": changes,
    }


def with_reading(metadata: Contents, distance: float) -> Contents:
    """Return metadata with a further reading of that distance [m], the one that counts by now.

    The key ``readings`` has all of them, the first one too where somebody measured it.
    """
    before = metadata.get("distance")
    first = [{"distance": before}] if metadata.get("distance_measured") is True else []
    readings = [
        *(entries_of(metadata, "readings") or first),
        {"time": now(), "distance": distance},
    ]
    changed = metadata if before == distance else with_distance(metadata, distance)
    return {**changed, "readings": readings, "distance_measured": True}

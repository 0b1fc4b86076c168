"""Series of placements, ``front``, ``front-2``, ``front-3``: a folder for each base position."""

import re
from pathlib import Path

from .metadata import METADATA, read_sessions
from .samples import SAMPLES

_NUMBERED = re.compile(r"(.+)-([2-9]|[1-9]\d{1,2})")
"""Name of a later folder: a date has more digits."""


def next_folder(folder: Path) -> Path:
    """Return the folder after all of a series."""
    folder = folder if folder.name.strip(".") else folder.resolve()
    first = _first(folder)
    count = max((1, *_later_folders(first))) + 1
    return folder.with_name(f"{first.name}-{count}")


def newest_folder(folder: Path) -> Path:
    """Return the folder of a series that a recorder opened last, where the base must still be.

    That is the folder itself where nothing was recorded there, or nothing after it.
    """
    first = _first(folder)
    series = {1: first, **_later_folders(first)}
    recorded = {n: f for n, f in series.items() if (f / SAMPLES).exists()}
    if folder not in recorded.values():
        return folder
    return max((_started(file), n, file) for n, file in recorded.items())[-1]


def _first(folder: Path) -> Path:
    """Return the folder with which the series of a folder began."""
    match = _NUMBERED.fullmatch(folder.name)
    first = folder.with_name(match[1]) if match else folder
    return first if first.exists() else folder


def _later_folders(first: Path) -> dict[int, Path]:
    """Return the later folders of a series, by their numbers."""
    folders: dict[int, Path] = {}
    for name in first.parent.glob("*-*"):
        match = _NUMBERED.fullmatch(name.name)
        if match and match[1] == first.name:
            folders[int(match[2])] = name
    return folders


def _started(folder: Path) -> str:
    """Return when the recorder last opened a folder, as UTC in ISO 8601; empty if unknown."""
    sessions = read_sessions(folder / METADATA)
    return str(sessions[-1].get("started", "")) if sessions else ""

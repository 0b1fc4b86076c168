"""Folders of recordings: which are placements, and what in them is not read."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from .files import refused
from .joined_tables import TABLES, tables_at
from .metadata import METADATA, read_sessions
from .points import POINTS, POSES
from .recording_error import RecordingError
from .samples import SAMPLES

FILES = (SAMPLES, POINTS, POSES)
_NAMES = f"{SAMPLES}, or hole_0.csv and hole_1.csv, or {POINTS}, or {POSES}"
_HOLE = re.compile(r"hole_(\d+)\.csv")
_MEANT = re.compile(r"(hole)[ _-]?(\d+)\b.*|(samples|points|poses)\b.*", re.IGNORECASE)
"""Names of files that are probably meant for those that are read."""
_TABLES = (*TABLES, ".xls", ".ods")
"""Endings of tables."""
_NO_TEXT = re.compile(r"\.(xlsx?|ods|gz|zip|jsonl?|np[yz]|parquet|mat|pkl)")
"""Endings of what may hold samples, by the file's name, in a form that is no text."""

MOST_LINES = 3
"""Most lines that tell what is not read of a folder without a placement."""


def find_placements(paths: Iterable[Path]) -> list[Path]:
    """Return the folders of all placements that some paths stand for; refuse other paths.

    A folder of placements stands for all of them, by name.

    Raises:
        RecordingError: A path that does not exist, is no folder, cannot be read, or holds no
            placement.
    """
    folders: list[Path] = []
    for path in paths:
        with refused(f"{path}: cannot be read"):
            folders += _placements_at(path)
    return folders


def _placements_at(path: Path) -> list[Path]:
    """Return the folders of the placements that a path stands for."""
    if path.name in FILES and path.is_file():
        forms = [name for name in FILES if (path.parent / name).exists()]
        return [path.parent] if len(forms) == 1 else [path]  # the one that is named
    if not _HOLE.fullmatch(path.name) and tables_at(path):
        return [path]
    if not path.is_dir():
        raise RecordingError(f"{path}: {_no_folder(path)}")
    folders = [path] if is_placement(path) else placements_in(path)
    if not folders:
        lines = [*_unread_files(path), *unread([path])]
        expected = (
            f"no recording in this folder; expected {_NAMES}, or folders that hold them"
        )
        raise RecordingError("; ".join([f"{path}: {expected}", *lines[:MOST_LINES]]))
    return folders


def _no_folder(path: Path) -> str:
    """Return what to do about a path that is no folder."""
    if path.exists():
        folder = path.absolute().parent
        if is_placement(folder):
            return f"not a folder; name the placement's folder, {folder}"
        return f"not a folder, and no table ({', '.join(TABLES)})"
    if path.suffix == ".csv":
        return "no such file"
    _, _, path_after_name = str(path).partition(":")
    if path_after_name and Path(path_after_name).exists():
        return f"no such folder; of one robot write {path_after_name}"
    return "no such folder; a placement is a folder of recordings"


def placements_in(folder: Path) -> list[Path]:
    """Return the placements' folders inside a folder, by name."""
    return sorted(filter(is_placement, filter(Path.is_dir, folder.iterdir())))


def is_placement(folder: Path) -> bool:
    """Return whether a folder holds a recording."""
    return any((folder / name).exists() for name in FILES) or bool(holes_in(folder))


def holes_in(folder: Path) -> list[tuple[int, Path]]:
    """Return the files ``hole_K.csv`` in a folder, each with its socket K."""
    files = [(_HOLE.fullmatch(child.name), child) for child in folder.iterdir()]
    return sorted((int(match[1]), file) for match, file in files if match)


def unread(paths: Iterable[Path]) -> list[str]:
    """Return what is not read of some paths, and what would be, a line each.

    That is folders beside placements that hold tables, other placements, or nothing; folders in a
    placement that are placements; and files whose names are nearly those that are read.
    """
    lines: list[str] = []
    for path in paths:
        if path.is_dir() and is_placement(path):
            lines += _unread_of_placement(path)
        elif path.is_dir():
            for child in filter(Path.is_dir, sorted(path.iterdir())):
                lines += _unread_beside(child)
    return lines


def _unread_of_placement(folder: Path) -> Iterator[str]:
    """Yield what is not read of a placement."""
    inside = [child.name for child in placements_in(folder)]
    if inside:
        names = ", ".join(inside)
        yield f"{folder}: {names} in it hold recordings, too, and are not read; name them"
    for words in _unread_files(folder, only_meant=True):
        yield f"{folder}: {words}"


def _unread_beside(folder: Path) -> Iterator[str]:
    """Yield what is not read of a folder in a folder of placements."""
    if folder.name.startswith("."):
        return
    if is_placement(folder):
        yield from _unread_of_placement(folder)
    elif all(file.name == METADATA for file in folder.iterdir()):
        yield f"{folder}: an empty folder among the placements is left out"
    elif placements_in(folder):
        yield f"{folder}: its placements lie one folder deeper and are not read; name {folder}"
    else:
        yield from (f"{folder}: {words}" for words in _unread_files(folder))


def _unread_files(folder: Path, *, only_meant: bool = False) -> Iterator[str]:
    """Yield which tables of a folder are not read, and what would be.

    ``only_meant`` passes over those whose names are far from what is read.
    """
    other: list[str] = []
    for file in sorted(folder.iterdir()):
        ending = file.suffix.lower()
        no_text = _NO_TEXT.fullmatch(ending)
        is_read = file.name in FILES or _HOLE.fullmatch(file.name)
        if is_read or not (no_text or ending in TABLES):
            continue
        match = _MEANT.fullmatch(file.name)
        if not match:
            other += [file.name] * (ending in _TABLES and ending != ".txt")
            continue
        meant = f"hole_{int(match[2])}" if match[2] else match[3].lower()
        save = "save it as CSV and " if no_text else ""
        yield f"{file.name} is not read; {save}call it {meant}.csv"
    if other and not only_meant:
        words = f"name {folder / other[0]} itself"
        yield f"{other[0]} is not read as a recording; {words}"


_NUMBERED = re.compile(r"(.+)-([2-9]|[1-9]\d{1,2})")
"""Name of a later folder: a date has more digits."""


def next_folder(folder: Path) -> Path:
    """Return the folder after all of a series."""
    folder = folder if folder.name.strip(".") else folder.resolve()
    series = _series(folder)
    return folder.with_name(f"{series[1].name}-{max(series) + 1}")


def newest_folder(folder: Path) -> Path:
    """Return the folder of a series that a recorder opened last, where the base must still be.

    That is the folder itself where nothing was recorded there, or nothing after it.
    """
    series = _series(folder)
    recorded = {n: f for n, f in series.items() if (f / SAMPLES).exists()}
    if folder not in recorded.values():
        return folder
    started: dict[tuple[str, int], Path] = {}
    for number, file in recorded.items():
        sessions = read_sessions(file / METADATA) or [{}]
        started[str(sessions[-1].get("started", "")), number] = file
    return started[max(started)]


def _series(folder: Path) -> dict[int, Path]:
    """Return the folders of a series by their numbers, from 1."""
    match = _NUMBERED.fullmatch(folder.name)
    first = folder.with_name(match[1]) if match else folder
    first = first if first.exists() else folder
    folders = {1: first}
    for path in first.parent.glob("*-*"):
        match = _NUMBERED.fullmatch(path.name)
        if match and match[1] == first.name:
            folders[int(match[2])] = path
    return folders

"""What was noted while recording: the arm's serial number, the operator, the temperature."""

from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path

from ....errors import read_json

NOTED = {"serial_number": "Serial number", "operator": "Operator", "temperature": "Temperature"}
"""Titles of the notes by their keys in ``placement.json``."""


def session_notes(files: Iterable[str]) -> Mapping[str, str]:
    """Return notes by their titles, from where the recordings of some files still lie."""
    folders = dict.fromkeys(Path(file).parent for file in files)
    notes: dict[str, str] = {}
    for key, title in NOTED.items():
        values = dict.fromkeys(chain.from_iterable(_noted_in(folder, key) for folder in folders))
        if values:
            notes[title] = ", ".join(values)
    return notes


def _noted_in(folder: Path, key: str) -> list[str]:
    try:
        sessions = read_json(folder / "placement.json")["sessions"]
        return [str(session[key]) for session in sessions if key in session]
    except (OSError, ValueError, LookupError, TypeError):
        return []

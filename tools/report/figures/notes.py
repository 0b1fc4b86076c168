"""What was noted while recording: the arm's serial number, the operator, the temperature."""

from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path

from ....recorder import METADATA, read_sessions

NOTED = {
    "serial_number": "Serial number",
    "operator": "Operator",
    "temperature": "Temperature",
}
"""Titles of the notes by their keys in ``placement.json``."""


def session_notes(files: Iterable[str]) -> Mapping[str, str]:
    """Return notes by their titles, from where the recordings of some files still lie."""
    folders = dict.fromkeys(Path(file).parent for file in files)
    sessions = list(
        chain.from_iterable(read_sessions(folder / METADATA) for folder in folders)
    )
    notes: dict[str, str] = {}
    for key, title in NOTED.items():
        values = dict.fromkeys(
            str(session[key]) for session in sessions if key in session
        )
        if values:
            notes[title] = ", ".join(values)
    return notes

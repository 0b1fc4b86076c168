"""What was noted while recording: the arm's serial number, the operator, the temperature."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from ....errors import read_json

NOTED = {"serial_number": "Serial number", "operator": "Operator", "temperature": "Temperature"}
"""Titles of the notes by their keys in ``placement.json``."""


def session_notes(files: Iterable[str]) -> Mapping[str, str]:
    """Return notes by their titles, from where the recordings of some files still lie."""
    values_by_title: dict[str, dict[str, None]] = {}
    for folder in dict.fromkeys(Path(file).parent for file in files):
        try:
            sessions = read_json(folder / "placement.json")["sessions"]
            notes = [
                (NOTED[key], str(session[key]))
                for session in sessions
                for key in NOTED
                if key in session
            ]
        except (OSError, ValueError, LookupError, TypeError):
            continue
        for title, value in notes:
            values_by_title.setdefault(title, {})[value] = None
    return {title: ", ".join(values) for title, values in values_by_title.items()}

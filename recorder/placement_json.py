"""What ``placement.json`` says, which may stand beside the samples of any form."""

import json
import math
import re
from pathlib import Path
from typing import Any, cast

from .csv_files import RecordingError

METADATA = "placement.json"
_WORD = re.compile(r"[\w.-]+")


def read_metadata(file: Path) -> dict[str, Any]:
    """Return what a placement's ``placement.json`` says; nothing where there is no such file.

    Raises:
        RecordingError: The file cannot be read, or holds no JSON object.
    """
    if not file.exists():
        return {}
    try:
        metadata: Any = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RecordingError(f"{file}: cannot be read as JSON: {error}") from None
    if not isinstance(metadata, dict):
        raise RecordingError(f'{file}: expected a JSON object, as in {{"distance": 0.05}}')
    return cast("dict[str, Any]", metadata)


def read_distance(file: Path) -> float | None:
    """Return the distance between the sockets' centres from a ``placement.json`` [m].

    None where the file does not exist, or does not give it.

    Raises:
        RecordingError: The file is not JSON, or the distance is not a positive number.
    """
    distance = read_metadata(file).get("distance")
    if distance is None:
        return None
    if (
        isinstance(distance, bool)
        or not isinstance(distance, int | float)
        or not (0 < distance < math.inf)
    ):
        raise RecordingError(f"{file}: distance {distance!r} is not a positive number of metres")
    return float(distance)


def read_name(file: Path, key: str) -> str | None:
    """Return a name that a ``placement.json`` gives; None where it does not.

    Raises:
        RecordingError: The file is not JSON, or the name is none.
    """
    name = read_metadata(file).get(key)
    if name is None:
        return None
    if not isinstance(name, str) or not _WORD.fullmatch(name):
        raise RecordingError(f"{file}: {key} {name!r} is no name: letters, digits, and . _ -")
    return name

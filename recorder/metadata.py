"""``placement.json``: robot, joints, socket distance and sessions, beside the samples."""

import difflib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, TypeGuard, cast

from .._version import __version__
from ..errors import LENGTH, PAYLOAD, read_json
from .files import replace_files
from .placement import DEFAULT_DISTANCE, SOCKETS
from .recording_error import RecordingError

METADATA = "placement.json"
Contents = dict[str, Any]
"""Contents of such a file."""
KEPT_ALARMS = "kept_alarms"
READINGS_CHANGED = "readings_changed"
NAMES = ("frame", "robot_name", "place", "poses_of")
"""Keys that are names."""
_NAME = re.compile(r"[\w.-]+")
BY_HAND = ("distance", "distance_measured", *NAMES, "payload", "readings")
"""Keys that people write, and may misspell."""
BY_RECORDER = (
    *("robot", "model_sha256", "joints", "units", "sockets", "socket"),
    *("sessions", "changes", READINGS_CHANGED, KEPT_ALARMS),
)


@dataclass(frozen=True)
class PlacementKeys:
    """Those keys of ``placement.json`` that a recording is read by: fields of a Placement."""

    distance: float | None = None
    distance_assumed: bool = False
    frame: str | None = None
    robot_name: str | None = None
    place: str | None = None
    poses_of: str | None = None
    kept_alarms: tuple[str, ...] = ()
    readings: tuple[float, ...] = ()
    payload: float | None = None
    remarks: tuple[str, ...] = ()
    """Keys that are not read, and nearly called like one that is."""


@dataclass(frozen=True)
class Metadata:
    """Contents of ``placement.json`` that one start of the recorder gives."""

    robot: str
    joints: tuple[str, ...]
    """The robot's actuated joints, in chain order."""
    units: tuple[str, ...]
    """``rad`` or ``m`` for each joint."""
    distance: float | None
    """Distance between the centres of sockets 0 and 1 [m]; None where nobody stated it."""
    measured: bool = False
    """True where somebody measured it."""
    sockets: int = SOCKETS
    model_sha256: str = ""
    robot_name: str = ""
    """Name of the robot among several; empty for the only one."""
    readings_changed: bool = False
    """True where joints read otherwise than at the placements before."""
    session: Contents = field(default_factory=Contents)
    """Driver, window and notes of this start alone."""

    def fixed(self) -> Contents:
        """The keys that must be the same each time that the placement is recorded on."""
        keys = {
            "robot": self.robot,
            "joints": list(self.joints),
            "distance": self.distance,
            "sockets": self.sockets,
            "robot_name": self.robot_name or None,
        }
        return {key: value for key, value in keys.items() if value is not None}

    def added_to(self, stored: Contents) -> Contents:
        """Return the file's new contents: the earlier ones, and this start of the recorder."""
        contents = stored | self.fixed()
        if self.measured:
            contents["distance_measured"] = True
        if self.readings_changed:
            contents[READINGS_CHANGED] = True
        session = {"started": now(), "version": __version__, **self.session}
        return contents | {
            "units": list(self.units),
            "model_sha256": stored.get("model_sha256", self.model_sha256),
            "sessions": [*entries_of(stored, "sessions"), session],
        }


def read_metadata(file: Path) -> Contents:
    """Return the keys of a ``placement.json``; none where there is no such file.

    Raises:
        RecordingError: The file cannot be read, or holds no JSON object.
    """
    try:
        metadata: Any = read_json(file) if file.exists() else {}
    except (OSError, ValueError) as error:
        raise RecordingError(f"{file}: cannot be read as JSON: {error}") from None
    if not isinstance(metadata, dict):
        raise RecordingError(
            f'{file}: expected a JSON object, as in {{"distance": 0.05}}'
        )
    return cast("Contents", metadata)


def read_sessions(file: Path) -> list[Contents]:
    """Return what a ``placement.json`` says of each session; nothing of what cannot be read."""
    try:
        rows = entries_of(read_metadata(file), "sessions")
    except RecordingError:
        return []
    return [cast("Contents", row) if isinstance(row, dict) else {} for row in rows]


def read_keys(file: Path) -> PlacementKeys:
    """Return the keys of a ``placement.json`` that a recording is read by; refuse other values.

    Raises:
        RecordingError: The file is no JSON object, the distance or a reading of it is no length,
            the payload is no mass, readings have no distance, or a name has other characters than
            letters, digits, and ``. _ -``.
    """
    metadata = read_metadata(file)
    distance = _length(metadata.get("distance"), file)
    payload: Any = metadata.get("payload")
    is_mass = _is_number(payload) and 0 <= payload <= PAYLOAD.largest
    if not (payload is None or is_mass):
        raise RecordingError(
            f"{file}: payload {payload!r}: expected kilograms, zero or more"
        )
    names = {key: metadata.get(key) for key in NAMES}
    for key, name in names.items():
        if not (name is None or (isinstance(name, str) and _NAME.fullmatch(name))):
            raise RecordingError(
                f"{file}: {key} {name!r} is no name: letters, digits, and . _ -"
            )
    measured = distance is not None and metadata.get("distance_measured") is True
    readings: list[float] = []
    for entry in entries_of(metadata, "readings"):  # a number, or an object that has it
        reading: Any = entry
        if isinstance(reading, dict):
            reading = cast("Contents", reading).get("distance")
        if length := _length(reading, file):
            readings.append(length)
    if readings and distance is None:
        raise RecordingError(
            f"{file}: readings without the distance that they are of; add it, as in "
            f'"distance": {readings[-1]}'
        )
    if distance and measured and not readings:
        readings = [distance]
    return PlacementKeys(
        distance=distance,
        # mukca record once wrote the default like a measured distance.
        distance_assumed=distance == DEFAULT_DISTANCE and not measured,
        **names,
        kept_alarms=tuple(map(str, entries_of(metadata, KEPT_ALARMS))),
        readings=tuple(readings),
        payload=None if payload is None else float(payload),
        remarks=tuple(_misspelt(metadata, file)),
    )


def _length(value: object, file: Path) -> float | None:
    """Return a distance of sockets [m], None where there is none; refuse what is no length."""
    if value is None:
        return None
    if not (_is_number(value) and 0 < value <= LENGTH.largest):
        raise RecordingError(
            f"{file}: distance {value!r}: expected a positive number of metres, as in 0.05"
        )
    return float(value)


def _misspelt(metadata: Contents, file: Path) -> Iterator[str]:
    """Yield a remark on each key that is not read, but nearly called like one that is."""
    keys = {*BY_HAND, *BY_RECORDER}
    for key in metadata:
        near = difflib.get_close_matches(key.lower(), BY_HAND, 1)
        if near and key not in keys:
            yield f"{file}: {key} is not read; did you mean {near[0]}?"


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def with_kept_alarm(metadata: Contents, text: str) -> Contents:
    """Return the contents with what an alarm said, and the operator kept as it was."""
    return {**metadata, KEPT_ALARMS: [*entries_of(metadata, KEPT_ALARMS), text]}


def metadata_file(metadata: Contents) -> dict[str, bytes]:
    """Return the content of ``placement.json`` by its name."""
    return {METADATA: json.dumps(metadata, indent=2).encode() + b"\n"}


def write_metadata(folder: Path, metadata: Contents) -> None:
    """Replace a placement's file in one step."""
    contents = metadata_file(metadata)
    replace_files({folder / name: content for name, content in contents.items()})


def entries_of(metadata: Contents, key: str) -> list[Any]:
    """Return a list of the metadata, which may be written by hand, and hold anything."""
    entries = metadata.get(key)
    return cast("list[Any]", entries) if isinstance(entries, list) else []


def now() -> str:
    """Return the time as it is written, in UTC."""
    return datetime.now(timezone.utc).isoformat(timespec="seconds")

"""``placement.json``: robot, joints, socket distance and sessions, beside the samples."""

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, TypeGuard, cast

from .._version import __version__
from ..errors import PAYLOAD, read_json
from .files import locked, replace_files
from .placement import DEFAULT_DISTANCE, SOCKETS
from .recording_error import RecordingError
from .samples import SAMPLES

METADATA = "placement.json"
Contents = dict[str, Any]
"""Contents of such a file."""
KEPT_ALARMS = "kept_alarms"
READINGS_CHANGED = "readings_changed"
NAMES = ("frame", "robot_name", "place", "poses_of")
"""Keys that are names."""
_NAME = re.compile(r"[\w.-]+")


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
        session = {"started": _now(), "version": __version__, **self.session}
        return contents | {
            "units": list(self.units),
            "model_sha256": stored.get("model_sha256", self.model_sha256),
            "sessions": [*_entries(stored, "sessions"), session],
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
        rows = _entries(read_metadata(file), "sessions")
    except RecordingError:
        return []
    return [cast("Contents", row) if isinstance(row, dict) else {} for row in rows]


def read_keys(file: Path) -> PlacementKeys:
    """Return the keys of a ``placement.json`` that a recording is read by; refuse other values.

    Raises:
        RecordingError: The file is no JSON object, the distance is not a positive number, the
            payload is no mass, readings have no distance, or a name has other characters than
            letters, digits, and ``. _ -``.
    """
    metadata = read_metadata(file)
    distance = metadata.get("distance")
    if not (distance is None or (_is_number(distance) and 0 < distance < math.inf)):
        raise RecordingError(
            f"{file}: distance {distance!r}: expected a positive number of metres"
        )
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
    readings: list[Any] = []
    for entry in _entries(metadata, "readings"):  # a number, or an object that has it
        reading: Any = entry
        if isinstance(reading, dict):
            reading = cast("Contents", reading).get("distance")
        if _is_number(reading) and 0 < reading < math.inf:
            readings.append(reading)
    if readings and distance is None:
        raise RecordingError(
            f"{file}: readings without the distance that they are of; add it, as in "
            f'"distance": {readings[-1]}'
        )
    single: list[Any] = [distance] if measured else []
    return PlacementKeys(
        distance=None if distance is None else float(distance),
        # mukca record once wrote the default like a measured distance.
        distance_assumed=distance == DEFAULT_DISTANCE and not measured,
        **names,
        kept_alarms=tuple(map(str, _entries(metadata, KEPT_ALARMS))),
        readings=tuple(map(float, readings or single)),
        payload=None if payload is None else float(payload),
    )


def _is_number(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def with_kept_alarm(metadata: Contents, text: str) -> Contents:
    """Return the contents with what an alarm said, and the operator kept as it was."""
    return {**metadata, KEPT_ALARMS: [*_entries(metadata, KEPT_ALARMS), text]}


def metadata_file(metadata: Contents) -> dict[str, bytes]:
    """Return the content of ``placement.json`` by its name."""
    return {METADATA: json.dumps(metadata, indent=2).encode() + b"\n"}


def write_metadata(folder: Path, metadata: Contents) -> None:
    """Replace a placement's file in one step."""
    contents = metadata_file(metadata)
    replace_files({folder / name: content for name, content in contents.items()})


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
    change = {"time": _now(), "distance": [metadata.get("distance"), distance]}
    changes = [*_entries(metadata, "changes"), change]
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
        *(_entries(metadata, "readings") or first),
        {"time": _now(), "distance": distance},
    ]
    changed = metadata if before == distance else with_distance(metadata, distance)
    return {**changed, "readings": readings, "distance_measured": True}


def _entries(metadata: Contents, key: str) -> list[Any]:
    entries = metadata.get(key)
    return cast("list[Any]", entries) if isinstance(entries, list) else []


def _now() -> str:
    return datetime.now(timezone.utc).isoformat(timespec="seconds")

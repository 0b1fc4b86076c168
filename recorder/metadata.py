"""What is written once beside the samples, ``placement.json``: robot, joints, socket distance."""

import fcntl
import json
import os
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, cast

from .._version import __version__
from .csv_files import RecordingError
from .placement import SOCKETS
from .placement_json import METADATA, read_distance, read_metadata
from .samples import SAMPLES


@dataclass(frozen=True)
class Metadata:
    """What is written once, beside the samples."""

    robot: str
    joints: tuple[str, ...]
    """The robot's actuated joints, in chain order."""
    units: tuple[str, ...]
    """``rad`` or ``m`` for each joint."""
    distance: float
    """Distance between the centres of sockets 0 and 1 [m]."""
    sockets: int = SOCKETS
    model_sha256: str = ""
    robot_name: str = ""
    """Which of several robots it is; empty for the only one."""
    session: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """What holds only for this start of the recorder: driver, window, notes."""

    def agreeing(self) -> dict[str, Any]:
        """What must be the same each time that the placement is recorded on."""
        return {
            "robot": self.robot,
            "joints": list(self.joints),
            "distance": self.distance,
            "sockets": self.sockets,
            **({"robot_name": self.robot_name} if self.robot_name else {}),
        }


def merged(earlier: dict[str, Any], metadata: Metadata) -> dict[str, Any]:
    """Return what to write: what stood there, and this start of the recorder."""
    session = {
        "started": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "version": __version__,
        **metadata.session,
    }
    before = earlier.get("sessions")
    return {
        **earlier,
        **metadata.agreeing(),
        "units": list(metadata.units),
        "model_sha256": earlier.get("model_sha256", metadata.model_sha256),
        "sessions": [*(before if isinstance(before, list) else []), session],
    }


def write_metadata(file: Path, metadata: dict[str, Any]) -> None:
    """Replace the file in one step: a crash leaves the old one or the new one."""
    temporary = file.with_name(f".{file.name}.tmp")
    with temporary.open("w", encoding="utf-8") as stream:
        json.dump(metadata, stream, indent=2)
        stream.write("\n")
        stream.flush()
        os.fsync(stream.fileno())
    temporary.replace(file)
    sync_folder(file.parent)


def sync_folder(folder: Path) -> None:
    """Return once the names in a folder are on the disk."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def set_distance(folder: Path, distance: float) -> float | None:
    """Correct the distance between a placement's sockets; what it was stays in the file.

    Args:
        folder: The placement's.
        distance: Between the centres of sockets 0 and 1 [m].

    Returns:
        What the file said before [m]; None if nothing.

    Raises:
        RecordingError: The file cannot be read or written, or a recorder has it open.
    """
    file = folder / METADATA
    before = read_distance(file)
    metadata = read_metadata(file)
    changes = metadata.get("changes")
    change = {
        "time": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "distance": [before, distance],
    }
    known = cast("list[Any]", changes) if isinstance(changes, list) else []
    try:
        with _locked(folder / SAMPLES):
            write_metadata(file, {**metadata, "distance": distance, "changes": [*known, change]})
    except BlockingIOError:
        raise RecordingError(f"{folder}: mukca record is writing there; finish it first") from None
    except OSError as error:
        raise RecordingError(f"{file}: cannot be written: {error.strerror}") from None
    return before


@contextmanager
def _locked(samples: Path) -> Generator[None, None, None]:
    """Keep recorders out of a recording meanwhile, where there is one."""
    if not samples.exists():
        yield
        return
    descriptor = os.open(samples, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)

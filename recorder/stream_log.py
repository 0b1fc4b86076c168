"""Log of all joint states of a session in one compact file beside its samples.

A line of JSON holds the format, the joints' names, and the numbers' resolution. Then come blocks of
up to :data:`BLOCK` states, each with its length in four bytes: columns of whole numbers as
differences from state to state, their bytes sorted by weight and packed by zlib. A block that a
crash tore off is not read. The resolution is just below the sensors' noise, which cannot be packed.
"""

import json
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..drivers import JointState
from .csv_files import RecordingError

FORMAT = "mukca-stream-2"
FORMAT_1 = "mukca-stream-1"
"""Files of this format do not give their resolution."""
ENDING = ".stream"
BLOCK = 1000
"""States in a block at most."""
DIGITS = (1e-6, 1e-7, 1e-3)
"""Resolution of a stamp, a position and an effort: [s], [rad] or [m], [N m]."""
DIGITS_1 = (1e-6, 1e-9, 1e-4)
"""Resolutions in files of the older format."""


@dataclass(frozen=True)
class LoggedStates:
    """Contents of a stream log."""

    joints: tuple[str, ...]
    stamps: NDArray[np.float64]
    """The robot's own time, shape (N,) [s]."""
    positions: NDArray[np.float64]
    """Shape (N, joints) [rad], [m] for a prismatic joint."""
    efforts: NDArray[np.float64] | None
    """Shape (N, joints) [N m]; None where a state had none."""
    connections: NDArray[np.int64]
    """The number of the connection that each state came over, shape (N,)."""


class StreamLog:
    """A file of joint states, open for writing.

    Args:
        file: Made here; its folder must exist.
        joints: The model's joints that move, in chain order.

    Raises:
        RecordingError: The file exists, or cannot be written.
    """

    def __init__(self, file: Path, joints: Sequence[str]) -> None:
        self.file = file
        self.trouble: str | None = None
        """Reason why no more is kept; None while all is well."""
        self._rows: list[list[int]] = []
        self._count = len(joints)
        try:
            self._stream = file.open("xb", buffering=0)
            head = json.dumps({"format": FORMAT, "joints": list(joints), "digits": DIGITS})
            self._stream.write(head.encode() + b"\n")
        except OSError as error:
            raise RecordingError(f"{file}: cannot be written: {error.strerror}") from None

    def add(self, state: JointState, connection: int) -> None:
        """Keep a state; one with another number of joints, or with no numbers, is passed over.

        Where the disk is full, :attr:`trouble` says so, and no more is kept: a session goes on.
        """
        second, radian, newton_metre = (1 / digit for digit in DIGITS)
        try:
            row = [round(state.stamp * second), connection, state.effort is not None]
            row += [round(value * radian) for value in state.position]
            efforts = state.effort or (0.0,) * self._count
            row += [round(value * newton_metre) for value in efforts]
        except (ValueError, OverflowError):  # NaN, infinity
            return
        if len(row) != 3 + 2 * self._count or not all(-(1 << 62) < n < 1 << 62 for n in row):
            return
        self._rows.append(row)
        if len(self._rows) >= BLOCK:
            self._write()

    def close(self) -> None:
        """Write what is left; safe to call twice."""
        if not self._stream.closed:
            self._write()
            self._stream.close()

    def _write(self) -> None:
        rows, self._rows = self._rows, []
        if not rows or self.trouble:
            return
        packed = _pack(np.array(rows, dtype=np.int64))
        try:
            self._stream.write(struct.pack("<I", len(packed)) + packed)
        except OSError as error:
            self.trouble = f"{self.file}: the states were not kept to the end: {error.strerror}"


def _pack(rows: NDArray[np.int64]) -> bytes:
    steps = np.diff(rows, axis=0, prepend=0)
    zigzag = (steps << 1) ^ (steps >> 63)  # so that small steps to either side have small numbers
    by_weight = zigzag.T.astype("<i8", order="C").view(np.uint8).reshape(rows.size, 8).T
    return zlib.compress(struct.pack("<I", len(rows)) + by_weight.tobytes(), 6)


def _unpack(packed: bytes, columns: int) -> NDArray[np.int64]:
    data = zlib.decompress(packed)
    (count,) = struct.unpack_from("<I", data)
    by_weight = np.frombuffer(data, np.uint8, offset=4).reshape(8, count * columns)
    zigzag = np.ascontiguousarray(by_weight.T).view("<u8").reshape(columns, count).T
    steps = (zigzag >> np.uint64(1)).astype(np.int64) ^ -(zigzag & np.uint64(1)).astype(np.int64)
    return np.cumsum(steps, axis=0)


def next_log_file(folder: Path) -> Path:
    """Return a name in a placement's folder that no stream has yet."""
    number = 1
    while (folder / f"states_{number}{ENDING}").exists():
        number += 1
    return folder / f"states_{number}{ENDING}"


def read_stream_log(file: Path) -> LoggedStates:
    """Read a file of states.

    Raises:
        RecordingError: It cannot be read, or is no such file.
    """
    try:
        data = file.read_bytes()
    except OSError as error:
        raise RecordingError(f"{file}: cannot be read: {error.strerror}") from None
    try:
        place = data.find(b"\n") + 1
        described = json.loads(data[:place])
        joints = tuple(map(str, described["joints"]))
        given = {FORMAT: described.get("digits"), FORMAT_1: DIGITS_1}[described["format"]]
        stamp, position, effort = map(float, given)
        columns = 3 + 2 * len(joints)
        blocks = [np.empty((0, columns), np.int64)]
        while place + 4 <= len(data):
            (length,) = struct.unpack_from("<I", data, place)
            place += 4 + length
            if place > len(data):
                break  # torn off by a crash
            blocks.append(_unpack(data[place - length : place], columns))
    except (ValueError, KeyError, TypeError, zlib.error, struct.error):
        raise RecordingError(f"{file}: not a whole stream of states ({FORMAT})") from None
    rows = np.concatenate(blocks)
    numbers = rows.astype(np.float64)
    m = len(joints)
    return LoggedStates(
        joints,
        numbers[:, 0] * stamp,
        numbers[:, 3 : 3 + m] * position,
        numbers[:, 3 + m :] * effort if len(rows) and rows[:, 2].all() else None,
        rows[:, 1],
    )

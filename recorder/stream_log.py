"""Log of all joint states of a session in one compact file beside its samples.

A line of JSON holds the format, the joints' names, and the numbers' resolution. Then come blocks of
up to :data:`BLOCK` states, each with its length in four bytes: columns of whole numbers as
differences from state to state, their bytes sorted by weight and packed by zlib.
"""

import json
import os
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import numpy as np

from ..drivers import JointState
from ..errors import read_bytes
from .files import APPEND, append_bytes, refused
from .recording_error import RecordingError

FORMAT = "mukca-stream-2"
FORMAT_1 = "mukca-stream-1"
"""Files of this format do not give their resolution."""
ENDING = ".stream"
BLOCK = 1000
"""States in a block at most."""
LARGEST = 1 << 62
"""No number of a state is as large in its unit of resolution."""
Block = np.ndarray
"""Whole numbers of states, a row for each."""
PACKED = b"\x78\x9c"
"""Beginning of what zlib packed."""
DIGITS = (1e-6, 1e-7, 1e-3)
"""Resolution of a stamp, a position and an effort: [s], [rad] or [m], [N m]."""
DIGITS_1 = (1e-6, 1e-9, 1e-4)
"""Resolutions in files of the older format."""


@dataclass(frozen=True)
class LoggedStates:
    """Contents of a stream log."""

    joints: tuple[str, ...]
    stamps: np.ndarray
    """The robot's own time, shape (N,) [s]."""
    positions: np.ndarray
    """Shape (N, joints) [rad], [m] for a prismatic joint."""
    efforts: np.ndarray | None
    """Shape (N, joints) [N m]; None where a state had none."""
    connections: np.ndarray
    """The number of the connection that each state came over, shape (N,)."""
    remarks: tuple[str, ...] = ()
    """Remarks on states that were lost, a line each."""


class StreamLog:
    """A file of the states of the joints that move, made here, open for writing.

    Raises:
        RecordingError: The file exists, or cannot be written.
    """

    def __init__(
        self,
        file: Path,
        joints: Sequence[str],
    ) -> None:
        self.file = file
        self.trouble: str | None = None
        """Reason why no more is kept; None while all is well."""
        self._rows: list[list[int]] = []
        self._count = len(joints)
        head = json.dumps({"format": FORMAT, "joints": list(joints), "digits": DIGITS})
        with refused(f"{file}: cannot be written"):
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | APPEND
            self._fd = os.open(file, flags, 0o666)
            append_bytes(self._fd, head.encode() + b"\n")

    def add(
        self,
        state: JointState,
        connection: int,
    ) -> None:
        """Keep a state; one with another number of joints, or with no numbers, is passed over."""
        second, radian, newton_metre = [1 / digit for digit in DIGITS]
        try:
            row = [round(state.stamp * second), connection, state.effort is not None]
            row += [round(value * radian) for value in state.position]
            efforts = state.effort or (0.0,) * self._count
            row += [round(value * newton_metre) for value in efforts]
        except (ValueError, OverflowError):  # NaN, infinity
            return
        if len(row) != 3 + 2 * self._count or max(map(abs, row)) >= LARGEST:
            return
        self._rows.append(row)
        if len(self._rows) >= BLOCK:
            self._write()

    def close(self) -> None:
        """Write what is left; safe to call twice."""
        if self._fd >= 0:
            self._write()
            os.close(self._fd)
            self._fd = -1

    def _write(self) -> None:
        rows, self._rows = self._rows, []
        if not rows or self.trouble:
            return
        packed = _pack(np.array(rows, dtype=np.int64))
        try:
            append_bytes(self._fd, struct.pack("<I", len(packed)) + packed, sync=False)
        except OSError as error:
            self.trouble = (
                f"{self.file.name}: no more states are kept: {error.strerror}"
            )


def _pack(rows: Block) -> bytes:
    steps = np.diff(rows, axis=0, prepend=0)
    # So that small steps to either side have small numbers.
    zigzag = (steps << 1) ^ (steps >> 63)
    numbers = zigzag.T.astype("<i8", order="C")
    by_weight = numbers.view(np.uint8).reshape(rows.size, 8).T
    head = struct.pack("<I", len(rows))
    return zlib.compress(head + by_weight.tobytes(), 6)


def _unpack(packed: bytes, columns: int) -> Block:
    unpacker = zlib.decompressobj()
    data = unpacker.decompress(packed, 4 + 8 * BLOCK * columns)
    if not unpacker.eof or unpacker.unused_data:
        raise ValueError("a block of another length")
    (total,) = struct.unpack_from("<I", data)
    by_weight = np.frombuffer(data, np.uint8, offset=4).reshape(8, total * columns)
    zigzag = np.ascontiguousarray(by_weight.T).view("<u8").reshape(columns, total).T
    halves = zigzag // 2
    odd = zigzag % 2
    steps = halves.astype(np.int64) ^ -odd.astype(np.int64)
    return np.cumsum(steps, axis=0)


def next_log_file(folder: Path) -> Path:
    """Return a name in a placement's folder that no stream has yet."""
    names = (folder / f"states_{number}{ENDING}" for number in count(1))
    return next(name for name in names if not name.exists())


def read_stream_log(file: Path) -> LoggedStates:
    """Read a file of states; refuse what is none.

    Raises:
        RecordingError: It cannot be read, or is no such file.
    """
    with refused(f"{file}: cannot be read"):
        data = read_bytes(file)
    head, _, body = data.partition(b"\n")
    try:
        described = json.loads(head)
        joints = tuple(map(str, described["joints"]))
        digits_by_format = {FORMAT: described.get("digits"), FORMAT_1: DIGITS_1}
        stamp, position, effort = map(float, digits_by_format[described["format"]])
    except (ValueError, KeyError, TypeError, AttributeError):
        raise RecordingError(f"{file}: not a stream of states ({FORMAT})") from None
    blocks, gaps = _blocks(body, 3 + 2 * len(joints))
    rows = np.concatenate(blocks)
    numbers = rows.astype(np.float64)
    m = len(joints)
    efforts = None
    if len(rows) and rows[:, 2].all():
        efforts = numbers[:, 3 + m :] * effort
    remarks: list[str] = []
    for gap in gaps:
        before, after = blocks[gap - 1], blocks[gap:]
        first = f"{before[-1, 0] * stamp:.3f} s" if len(before) else "the beginning"
        last = f"{after[0][0, 0] * stamp:.3f} s" if after else "the end"
        remarks.append(
            f"{file}: the states between {first} and {last} are damaged, and left out"
        )
    return LoggedStates(
        joints,
        stamps=numbers[:, 0] * stamp,
        positions=numbers[:, 3 : 3 + m] * position,
        efforts=efforts,
        connections=rows[:, 1],
        remarks=tuple(remarks),
    )


def _blocks(data: bytes, columns: int) -> tuple[list[Block], list[int]]:
    """Return all whole blocks, and before which of them damaged ones are left out."""
    blocks = [np.empty((0, columns), np.int64)]
    gaps: list[int] = []
    place = 0
    while place < len(data):
        (length,) = struct.unpack_from("<I", data.ljust(place + 4, b"\0"), place)
        end = place + 4 + length
        try:
            blocks.append(_unpack(data[place + 4 : end], columns))
            place = end
        except (ValueError, zlib.error, struct.error):
            gaps.append(len(blocks))
            begin = data.find(PACKED, place + 5)  # a block somewhere behind, perhaps
            place = begin - 4 if begin >= 0 else len(data)
    return blocks, list(dict.fromkeys(gaps))

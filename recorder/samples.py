"""The file ``samples.csv``: one line an event, written as bytes and parsed."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

from ..errors import is_number
from .cells import number_of, require_columns, table_bytes
from .recording_error import RecordingError
from .sample import LAST_SOCKET as LAST_SOCKET
from .sample import Sample

SAMPLES = "samples.csv"
CAPTURE, UNDO, REDO, RELABEL = "capture", "undo", "redo", "relabel"
MOST = 10**9
"""Count that nothing exceeds."""
_LEADING = ("event", "sample", "socket", "time", "stamp", "states")
_PER_JOINT = ("position", "spread", "effort")


@dataclass(frozen=True)
class SampleFile:
    """All that a ``samples.csv`` holds."""

    joint_names: tuple[str, ...]
    samples: tuple[Sample, ...]
    """All captures in order, also those that were taken back."""
    withdrawn: tuple[int, ...]
    """Numbers of the samples that were taken back, the last one at the end."""
    torn: bytes
    """Bytes after the last complete line, which a crash tore off."""

    @property
    def live(self) -> tuple[Sample, ...]:
        """The samples that count: all but those that were taken back."""
        return tuple(s for s in self.samples if s.number not in self.withdrawn)


def header_line(joint_names: Sequence[str]) -> bytes:
    """Return the first line of the file."""
    by_joint = [f"{kind}.{name}" for kind, name in product(_PER_JOINT, joint_names)]
    return _line([*_LEADING, *by_joint])


def capture_line(sample: Sample) -> bytes:
    """Return the line that records a capture; every number reads back exactly."""
    s, blanks = sample, [""] * len(sample.position)
    leading = (CAPTURE, s.number, s.socket, s.time, s.stamp, s.states)
    return _line([*leading, *s.position, *(s.spread or blanks), *(s.effort or blanks)])


def mark_line(
    event: str,
    sample: Sample,
    time: float,
) -> bytes:
    """Return the line of an ``undo``, ``redo`` or ``relabel`` of a sample, at a time [s UTC]."""
    blanks = [""] * (2 + len(_PER_JOINT) * len(sample.position))
    return _line([event, sample.number, sample.socket, time, *blanks])


def _line(cells: Sequence[object]) -> bytes:
    text = io.StringIO()
    # csv writes a float as repr() does: the shortest text that reads back to the same number
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue().encode()


def read_samples(file: Path) -> SampleFile:
    """Read a ``samples.csv``; refuse one without a complete header, or with a line of no event.

    Raises:
        RecordingError: It cannot be read, has no complete header, or a complete line that is
            no event; the message names the line.
    """
    try:
        complete, _, torn = table_bytes(file).rpartition(b"\n")
        text = complete.decode("utf-8-sig")
        require_columns(text, file)
        lines = list(csv.reader(io.StringIO(text), strict=True))
    except (UnicodeDecodeError, csv.Error):
        raise RecordingError(
            f"{file}: not a text file of comma-separated values"
        ) from None
    if not lines:
        raise RecordingError(f"{file}: no header line; nothing was recorded")
    header = lines[0]
    positions = [name for name in header if name.startswith("position.")]
    joint_names = tuple(name.removeprefix("position.") for name in positions)
    if not joint_names or _line(header) != header_line(joint_names):
        raise RecordingError(
            f"{file}:1: not the header of a recording; expected the columns "
            f"{', '.join(_LEADING)}, then position., spread. and effort. of every joint; "
            "mukca convert makes a recording of a table of another program"
        )
    samples: list[Sample] = []
    withdrawn: list[int] = []
    for line, cells in enumerate(lines[1:], start=2):
        if not cells:
            continue
        where = f"{file}:{line}"
        if len(cells) != len(header):
            raise RecordingError(
                f"{where}: {len(cells)} columns where the header has {len(header)}"
            )
        row = _Row(where, dict(zip(header, cells, strict=True)), joint_names)
        row.add_to(samples, withdrawn)
    return SampleFile(joint_names, tuple(samples), tuple(withdrawn), torn)


@dataclass(frozen=True)
class _Row:
    """One line's cells by column."""

    where: str
    cells: dict[str, str]
    joint_names: tuple[str, ...]

    def add_to(
        self,
        samples: list[Sample],
        withdrawn: list[int],
    ) -> None:
        """Do to the samples of the lines before what this line says."""
        event, count = self.cells["event"], len(samples)
        if event not in (CAPTURE, UNDO, REDO, RELABEL):
            events = f"{CAPTURE}, {UNDO}, {REDO} and {RELABEL}"
            raise RecordingError(f"{self.where}: event {event!r} is none of {events}")
        number = self.integer("sample")
        if event == CAPTURE:
            if number != count + 1:
                raise RecordingError(
                    f"{self.where}: sample {number} where {count + 1} is next; "
                    "a line is missing or twice there"
                )
            samples.append(self.capture(number))
            return
        fits = event == RELABEL or (number in withdrawn) == (event == REDO)
        if not (fits and 1 <= number <= count):
            raise RecordingError(
                f"{self.where}: {event} of sample {number}, which is not there"
            )
        if event == UNDO:
            withdrawn.append(number)
        elif event == REDO:
            withdrawn.remove(number)
        else:
            socket = self.integer("socket")
            samples[number - 1] = replace(samples[number - 1], socket=socket)

    def capture(self, number: int) -> Sample:
        position, spread, effort = map(self.joints, _PER_JOINT)
        if position is None:
            raise RecordingError(f"{self.where}: a capture without positions")
        time = self.number("time") if self.cells["time"].strip() else None
        stamp = self.number("stamp") if self.cells["stamp"].strip() else None
        states = self.integer("states") if self.cells["states"].strip() else None
        socket = self.integer("socket")
        return Sample(
            position, socket, effort, self.where, number, time, stamp, states, spread
        )

    def number(self, column: str) -> float:
        text = self.cells[column]
        value = number_of(text)
        if value is None or not is_number(value):
            raise RecordingError(
                f"{self.where}: {column} is {text!r}, not a finite number"
            )
        return value

    def integer(self, column: str) -> int:
        value = self.number(column)
        most = LAST_SOCKET if column == "socket" else MOST
        if not 0 <= value <= most or value % 1:
            raise RecordingError(
                f"{self.where}: {column} is {self.cells[column]!r}, not a count"
            )
        return int(value)

    def joints(self, kind: str) -> tuple[float, ...] | None:
        """One kind of number for all joints; None where all their cells are empty."""
        columns = [f"{kind}.{name}" for name in self.joint_names]
        if not any(self.cells[column].strip() for column in columns):
            return None
        return tuple(map(self.number, columns))

"""Placements and their samples, and the files that hold them.

A *placement* is a folder: one position of the socket base, with the samples taken there.
Two forms are read wherever a placement is:

``hole_0.csv``, ``hole_1.csv``, ...
    One file a socket, one configuration a line: joint positions in chain order [rad], [m] for a
    prismatic joint, separated by commas. A header with the joints' names may stand first.

``placement.json``
    Beside either form, optional there: an object whose key ``distance`` is the distance between
    the sockets' centres [m].
"""

import csv
import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import MukcaError

__all__ = [
    "Placement",
    "RecordingError",
    "Sample",
    "find_placements",
    "read_placement",
]

_HOLE = re.compile(r"hole_(\d+)\.csv")
METADATA = "placement.json"


class RecordingError(MukcaError):
    """A recording cannot be read, or does not hold what it must."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One captured configuration."""

    position: tuple[float, ...]
    """Joint positions in chain order [rad], [m] for a prismatic joint."""
    socket: int
    """Number of the socket in which the ball sat."""
    effort: tuple[float, ...] | None = None
    """What each joint exerted on the arm beyond it [N m], where the robot measured it."""
    where: str = ""
    """File and line, for messages."""


@dataclass(frozen=True)
class Placement:
    """All samples taken at one position of the socket base."""

    name: str
    """The folder's name after its parent's, ``panda_3/frontcenter``."""
    samples: tuple[Sample, ...]
    joint_names: tuple[str, ...] | None = None
    """The joints of the columns, where the file names them."""
    distance: float | None = None
    """Distance between the sockets' centres [m], where the metadata give it."""
    files: tuple[Path, ...] = ()
    """The files that it was read from."""

    @cached_property
    def positions(self) -> NDArray[np.float64]:
        """Joint positions of all samples, shape (samples, joints) [rad]."""
        return np.array([sample.position for sample in self.samples], dtype=float)

    @cached_property
    def sockets(self) -> NDArray[np.int64]:
        """The socket of each sample, shape (samples,)."""
        return np.array([sample.socket for sample in self.samples], dtype=np.int64)

    @cached_property
    def efforts(self) -> NDArray[np.float64] | None:
        """Joint efforts of all samples, shape (samples, joints) [N m], or None without them."""
        if any(sample.effort is None for sample in self.samples):
            return None
        return np.array([sample.effort for sample in self.samples], dtype=float)

    @property
    def path(self) -> Path | None:
        """The folder that it was read from."""
        return self.files[0].parent if self.files else None

    def for_joints(self, joint_names: Sequence[str]) -> "Placement":
        """Return the placement with its columns in the order of a chain's actuated joints.

        Columns are matched by name where the file has a header that shares names with the
        chain; without a header, or with one that shares none, they go by order.

        Args:
            joint_names: The chain's actuated joints, in order.

        Raises:
            RecordingError: A wrong number of columns, or a header that names only some joints.
        """
        order = self._order(tuple(joint_names))
        if order is None:
            return self
        picked = tuple(
            replace(
                sample,
                position=tuple(sample.position[i] for i in order),
                effort=None if sample.effort is None else tuple(sample.effort[i] for i in order),
            )
            for sample in self.samples
        )
        return replace(self, samples=picked, joint_names=tuple(joint_names))

    def _order(self, joint_names: tuple[str, ...]) -> list[int] | None:
        where = self.samples[0].where
        columns = self.joint_names
        matched = [] if columns is None else [name for name in joint_names if name in columns]
        if columns is not None and len(matched) == len(joint_names):
            return [columns.index(name) for name in joint_names]
        if matched:
            missing = [name for name in joint_names if name not in matched]
            raise RecordingError(
                f"{self.files[0]}: the header names {len(matched)} of the robot's "
                f"{len(joint_names)} joints; missing: {', '.join(missing)}. Name all of them, "
                "or none (columns then go by order)"
            )
        count = len(self.samples[0].position)
        if count != len(joint_names):
            raise RecordingError(
                f"{where}: {count} joint positions, but the robot's chain has "
                f"{len(joint_names)} actuated joints ({', '.join(joint_names)})"
            )
        return None


def find_placements(paths: Iterable[Path]) -> list[Path]:
    """Return the placement folders that paths stand for; a folder of placements is all of them.

    Raises:
        RecordingError: A path that does not exist, is no folder, or holds no placement.
    """
    found: list[Path] = []
    for path in paths:
        if not path.exists():
            raise RecordingError(f"{path}: no such folder; a placement is a folder of recordings")
        if not path.is_dir():
            raise RecordingError(
                f"{path}: not a folder; name the placement's folder, {path.parent}"
            )
        if is_placement(path):
            found.append(path)
            continue
        inside = sorted(child for child in path.iterdir() if child.is_dir() and is_placement(child))
        if not inside:
            raise RecordingError(
                f"{path}: no recording in this folder; expected hole_0.csv and hole_1.csv, "
                "or folders that hold them"
            )
        found.extend(inside)
    return found


def is_placement(folder: Path) -> bool:
    """Tell whether a folder holds a recording."""
    return any(_HOLE.fullmatch(child.name) for child in folder.iterdir())


def read_placement(folder: Path) -> Placement:
    """Read the placement in a folder.

    Raises:
        RecordingError: A missing, empty or malformed file; the message names file and line.
    """
    holes = sorted(
        (int(match[1]), child)
        for child in folder.iterdir()
        if (match := _HOLE.fullmatch(child.name))
    )
    tables = [(socket, read_table(file)) for socket, file in holes]
    first = tables[0][1]
    for _, table in tables[1:]:
        if table.header != first.header:
            raise RecordingError(f"{table.file}:1: another header than in {first.file.name}")
        if len(table.rows[0]) != len(first.rows[0]):
            raise RecordingError(
                f"{table.file}:{table.lines[0]}: {len(table.rows[0])} columns, "
                f"but {first.file.name} has {len(first.rows[0])}"
            )
    samples = tuple(
        Sample(position=row, socket=socket, where=f"{table.file}:{line}")
        for socket, table in tables
        for line, row in zip(table.lines, table.rows, strict=True)
    )
    return Placement(
        name=placement_name(folder),
        samples=samples,
        joint_names=first.header,
        distance=read_distance(folder / METADATA),
        files=tuple(file for _, file in holes),
    )


def placement_name(folder: Path) -> str:
    """Return the folder's name after its parent's."""
    return "/".join(folder.resolve().parts[-2:]).lstrip("/")


def read_distance(file: Path) -> float | None:
    """Return the socket distance in a placement's metadata [m]; None where there is none.

    Raises:
        RecordingError: The file is not JSON, or the distance is not a positive number.
    """
    if not file.exists():
        return None
    try:
        metadata: Any = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RecordingError(f"{file}: cannot be read as JSON: {error}") from None
    if not isinstance(metadata, dict):
        raise RecordingError(f'{file}: expected a JSON object, as in {{"distance": 0.05}}')
    distance = cast("dict[str, Any]", metadata).get("distance")
    if distance is None:
        return None
    if (
        isinstance(distance, bool)
        or not isinstance(distance, int | float)
        or not (0 < distance < math.inf)
    ):
        raise RecordingError(f"{file}: distance {distance!r} is not a positive number of metres")
    return float(distance)


@dataclass(frozen=True)
class Table:
    """Numbers from a CSV file, with the line each row stands on."""

    file: Path
    header: tuple[str, ...] | None
    lines: tuple[int, ...]
    rows: tuple[tuple[float, ...], ...]


def read_table(file: Path) -> Table:
    """Read a CSV file of finite numbers, with or without one header line.

    Raises:
        RecordingError: Missing, empty, header only, ragged, or a cell that is no finite number.
    """
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream)
            records = [
                (reader.line_num, row) for row in reader if any(cell.strip() for cell in row)
            ]
    except OSError as error:
        raise RecordingError(f"{file}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise RecordingError(f"{file}: not a text file of comma-separated numbers") from None
    if not records:
        raise RecordingError(f"{file}: empty; expected one configuration a line")
    header = _header(records[0][1])
    if header:
        records = records[1:]
    if not records:
        raise RecordingError(f"{file}: only a header; expected one configuration a line below it")
    width = len(header or records[0][1])
    rows = tuple(_numbers(file, line, row, width) for line, row in records)
    return Table(file, header, tuple(line for line, _ in records), rows)


def _header(cells: Sequence[str]) -> tuple[str, ...] | None:
    """Return a line's cells as names if none of them is a number."""
    if any(_is_number(cell) or not cell.strip() for cell in cells):
        return None
    return tuple(cell.strip() for cell in cells)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(file: Path, line: int, cells: Sequence[str], width: int) -> tuple[float, ...]:
    if len(cells) != width:
        raise RecordingError(f"{file}:{line}: {len(cells)} columns where {width} are expected")
    try:
        numbers = tuple(float(cell) for cell in cells)
    except ValueError:
        column = next(i for i, cell in enumerate(cells) if not _is_number(cell))
        raise RecordingError(
            f"{file}:{line}: column {column + 1} is {cells[column]!r}, not a number"
        ) from None
    if not all(map(math.isfinite, numbers)):
        column = next(i for i, number in enumerate(numbers) if not math.isfinite(number))
        raise RecordingError(
            f"{file}:{line}: column {column + 1} is {cells[column].strip()}, not a finite number; "
            "delete the line if the capture failed"
        )
    return numbers

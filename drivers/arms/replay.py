"""Reads the configurations that the simulated arm is to move through, from CSV files.

Drivers may not import the recorder, which knows the recordings' formats. So this takes from any
CSV file the columns ``position.J`` and ``effort.J`` of each joint J, or all columns where the
header names none of those.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import DriverError, Reason

_Rows = list[tuple[float, ...]]


@dataclass(frozen=True)
class Replay:
    """The configurations that an arm is led through."""

    joint_names: tuple[str, ...]
    """Empty where the file has no header."""
    configurations: _Rows
    """Joint positions [rad]."""
    efforts: _Rows | None
    """Joint torques at each configuration [N m]; None where the file has none."""


def read_replay(path: Path) -> Replay:
    """Read a CSV file, or all recordings in a placement's folder one after the other.

    Raises:
        DriverError: BAD_ADDRESS where there is no configuration.
        ValueError: A cell that is no number.
    """
    files = sorted([*path.glob("hole_*.csv"), *path.glob("samples.csv")]) if path.is_dir() else []
    parts = [_read(file) for file in files or [path]]
    configurations = [row for part in parts for row in part.configurations]
    efforts = [row for part in parts for row in part.efforts or ()]
    if not configurations:
        raise DriverError(Reason.BAD_ADDRESS, f"mock: {path}: no configuration to replay")
    complete = len(efforts) == len(configurations)
    return Replay(parts[0].joint_names, configurations, efforts if complete else None)


def number(text: str) -> float | None:
    """Return what a text says, or None if that is no number."""
    try:
        return float(text)
    except ValueError:
        return None


def _read(file: Path) -> Replay:
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            lines = [line for line in csv.reader(stream) if line]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DriverError(Reason.BAD_ADDRESS, f"mock: {file}: cannot be read: {error}") from None
    header = lines.pop(0) if lines and number(lines[0][0]) is None else []
    positions = [i for i, name in enumerate(header) if name.startswith("position.")]
    efforts = [i for i, name in enumerate(header) if name.startswith("effort.")]
    columns = positions or list(range(len(header or (lines[0] if lines else []))))
    names = tuple(header[i].removeprefix("position.") for i in columns if header)
    return Replay(names, _pick(lines, columns), _pick(lines, efforts))


def _pick(lines: Sequence[Sequence[str]], columns: Sequence[int]) -> _Rows:
    """Return the numbers in some columns, of the lines that have all of them."""
    return [
        tuple(float(line[i]) for i in columns)
        for line in lines
        if columns and all(i < len(line) and line[i].strip() for i in columns)
    ]

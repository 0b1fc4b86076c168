"""Plain CSV logs: a column of time, and a column for each joint."""

import re

import numpy as np

from ...recorder import read_table
from .log import ExtractError, Log, Question, check_angles, needed_columns

_TIME = re.compile(
    r"(time|stamp|timestamp|t|sec|secs|seconds|time_?stamp)[ _]*[\[(]?(s|ms|us|ns|sec)?[\])]?", re.I
)
_SECONDS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_DEGREES = re.compile(r"[\[(]deg(rees)?[\])]$|_deg(rees)?$|[\[(]°[\])]$", re.I)
SLOWEST = 0.15
"""Logs with longer steps hold no rest of a third of a second [s]."""


def read(question: Question) -> Log:
    """Return the joint states of a CSV log."""
    table = read_table(question.path, units=True)
    if table.header is None:
        raise ExtractError(f"{question.path}:1: name the columns: time, and the joints")
    rows = np.array(table.rows)
    times = [i for i, name in enumerate(table.header) if _TIME.fullmatch(name)]
    if not times:
        raise ExtractError(
            f"{question.path}:1: no column of time; call it time, or time[ms] and so on; "
            f"columns: {', '.join(table.header)}"
        )
    names = [name for i, name in enumerate(table.header) if i != times[0]]
    columns = needed_columns(names, question)
    below = table.units or ("",) * len(table.header)
    units = [unit.strip("[]() ") for i, unit in enumerate(below) if i != times[0]]
    match = _TIME.fullmatch(table.header[times[0]])
    unit = below[times[0]].strip("[]() ") or (match and match[2]) or "s"
    stamps = rows[:, times[0]] * _SECONDS.get(unit, 1.0)
    positions = np.delete(rows, times[0], axis=1)[:, columns]
    marked = [bool(_DEGREES.search(names[i]) or _DEGREES.search(f"[{units[i]}]")) for i in columns]
    positions = _in_radians(positions, marked, question)
    return _in_order(stamps, positions, question)


def _in_radians(positions: np.ndarray, marked: list[bool], question: Question) -> np.ndarray:
    """Return angles in radians; degrees only where the file or the user says so."""
    if question.units not in (None, "radians", "degrees"):
        raise ExtractError(f"--units {question.units}: for a CSV log, radians or degrees")
    turning = ~np.array(question.prismatic)
    degrees = turning if question.units == "degrees" else np.array(marked) & turning
    if question.units == "radians":
        degrees = np.zeros_like(turning)
    radians = np.where(degrees, np.radians(positions), positions)
    check_angles(radians[:, turning], bool(degrees.any()), question)
    return radians


def _in_order(stamps: np.ndarray, positions: np.ndarray, question: Question) -> Log:
    """Return the states in order of time, each moment once."""
    stamps, first = np.unique(stamps, return_index=True)
    step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else np.inf
    if not 1e-5 < step < SLOWEST:
        raise ExtractError(
            f"{question.path}: {len(stamps)} moments, typically {step:.3g} s apart; 10 a second "
            "and more are needed; if time is not in seconds, name its column time[ms], [us] or [ns]"
        )
    return Log(stamps, positions[first], None, np.zeros(len(stamps), dtype=int))

"""Configuration of a Trossen arm, its position offsets corrected by the zeros estimated.

The controller's motors stand at ``position + position_offset``. A joint whose true angle is its
reading plus z gets there by z less in its offset, which the controller keeps in single precision.
"""

import re
from typing import NamedTuple

import numpy as np

from ...errors import fixed
from .request import Exported, ExportError, Request, losses_without
from .zeros import UNDECIDED, JointZero, estimated_zeros, urdf_without

_SECTION = re.compile(
    r"^joint_characteristics:[ \t]*(#.*)?\n((?:[ \t-].*\n|\n|#.*\n)+)", re.M
)
_OFFSET = re.compile(r"\bposition_offset:[ \t]*([-+.\deE]+)")
LARGEST_SHIFT = 0.2
"""A larger zero is a slip of the arm's assembly, and moves its limits far [rad]."""


class Entry(NamedTuple):
    """One joint's number in the file: its place in the text, and its value [rad]."""

    begin: int
    end: int
    offset: float


def write(request: Request) -> Exported:
    """Return the configuration that ``--like`` names with other offsets, and the URDF for it."""
    zeros = estimated_zeros(request)
    text = _text(request)
    entries = _entries(request, text, zeros)
    edits: list[tuple[Entry, float]] = []
    shifts: list[float] = []
    lines: list[str] = []
    for zero, entry in zip(zeros, entries, strict=True):
        why = "" if zero.decided else UNDECIDED
        if abs(zero.zero) > LARGEST_SHIFT:
            why = "too large for an offset: look at the joint first"
        new = entry.offset if why else float(np.float32(entry.offset - zero.zero))
        edits.append((entry, new))
        shifts.append(entry.offset - new)
        lines.append(
            f"{zero.joint:14} {zero}, {why or 'position_offset ' + fixed(new, 6)}"
        )
    urdf = f"{request.file.stem}.urdf"
    lines += [
        f"Write it while no joint is in position mode: driver.load_configs_from_file("
        f'"{request.file.name}"). The arm then reads other angles: its limits move with them.',
        f"Then load {urdf}, not calibrated.urdf, which holds the old zeros.",
    ]
    files = {
        request.file.name: _edited(text, edits).encode(),
        urdf: urdf_without(request, shifts),
    }
    return Exported(files, losses_without(request), tuple(lines))


def _text(request: Request) -> str:
    """Return the text of ``--like``."""
    like = request.like
    if not like or request.file.resolve() == like.resolve():
        raise ExportError(
            "--to trossen needs --like FILE, what driver.save_configs_to_file wrote of this arm, "
            "and another name for --out"
        )
    return request.like_text()


def _entries(request: Request, text: str, zeros: list[JointZero]) -> list[Entry]:
    """Return the number of each of the arm's joints, which the ends of their names count from 0."""
    section = _SECTION.search(text)
    begin, end = section.span(2) if section else (0, 0)
    places = [
        Entry(match.start(1), match.end(1), float(match[1]))
        for match in _OFFSET.finditer(text, begin, end)
    ]
    suffixes = [re.search(r"joint_(\d+)$", zero.joint) for zero in zeros]
    indices = [int(suffix[1]) for suffix in suffixes if suffix]
    if indices != list(range(len(zeros))):
        raise ExportError(
            f"--to trossen: {request.robot.name} does not have the joints of a "
            "Trossen arm, joint_0, joint_1, ..; --to urdf works for any arm"
        )
    if len(places) <= len(zeros):
        raise ExportError(
            f"--like {request.like}: {len(places)} times position_offset among "
            f"joint_characteristics, not one for each of {len(zeros)} joints and the gripper; "
            "give what driver.save_configs_to_file wrote"
        )
    return places[: len(zeros)]


def _edited(text: str, edits: list[tuple[Entry, float]]) -> str:
    """Return a text with other numbers."""
    for entry, offset in reversed(edits):
        if offset != entry.offset:
            text = f"{text[: entry.begin]}{offset!r}{text[entry.end :]}"
    return text

"""Recordings of a fleet: a folder an arm, and in it a folder a date."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...recorder import is_placement
from ...solver.calibration import SolveOptions, UsageError

MODEL = "robot.urdf"
"""An arm's own model, where its folder has one."""


@dataclass(frozen=True)
class ArmFolder:
    """One arm's recordings, and how to calibrate by them."""

    folder: Path
    """Holds placements, or folders of placements, one a date."""
    out: Path
    """Place of its results."""
    robot: Mapping[str, Any]
    """Arguments of :func:`mukca.load_robot`."""
    settings: SolveOptions


def find_arms(folder: Path) -> list[Path]:
    """Return the folders of all arms, by name.

    Raises:
        UsageError: No such folder, or none in it holds a recording.
    """
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder; a fleet is a folder with one folder an arm")
    if is_placement(folder) or any(is_placement(child) for child in _inside(folder)):
        raise UsageError(
            f"{folder}: holds the placements of one arm; a fleet is a folder with one folder an "
            "arm, as in fleet/arm-7/2026-06-01/front. For one arm there is mukca solve"
        )
    arms = [child for child in _inside(folder) if find_sessions(child)]
    if not arms:
        raise UsageError(f"{folder}: no arm's folder in it holds a recording")
    return arms


def find_sessions(arm: Path) -> dict[str, Sequence[Path]]:
    """Return the placements of one arm, session by session in the order of their names."""
    own = [child for child in _inside(arm) if is_placement(child)]
    sessions: dict[str, Sequence[Path]] = {"": own} if own else {}
    for child in _inside(arm):
        placements = [inner for inner in _inside(child) if is_placement(inner)]
        if placements and not is_placement(child):
            sessions[child.name] = placements
    return sessions


def _inside(folder: Path) -> list[Path]:
    return sorted(child for child in folder.iterdir() if child.is_dir())

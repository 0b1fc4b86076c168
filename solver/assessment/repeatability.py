"""Repeatability: how exactly an arm comes back, by the data sheets of the shipped arms."""

import json
import re
from dataclasses import dataclass
from importlib.resources import files as resources
from pathlib import Path

from ..identification.robot import Robot, shipped_robots
from ..results import Model


@dataclass(frozen=True)
class Arm:
    """An arm's repeatability: the error with which it comes back to where it was."""

    repeatability: float
    """[m]."""
    source: str


_SHIPPED = (
    resources("mukca.solver.identification.robot") / "shipped" / "repeatability.json"
)
ARMS: dict[str, Arm] = {}
"""The shipped robots of which a figure is known."""
for _row in json.loads(_SHIPPED.read_bytes()):
    ARMS.update(
        dict.fromkeys(_row["arms"], Arm(float(_row["repeatability"]), _row["source"]))
    )
RESOLUTION = 1e-4
"""The smallest error that a ball in a printed socket can show, however good the arm is [m]."""


def known_arm(model: Robot | Model) -> str | None:
    """Return the shipped robot that a model's names stand for, if exactly one of ARMS does."""
    for name in (model.name, Path(model.source).stem):
        letters = _plain(name)
        # no longer number either: a ur30 is no ur3
        matches = [
            r for r in shipped_robots() if re.search(f"{_plain(r)}(?![0-9])", letters)
        ]
        longest = [
            r
            for r in matches
            if not any(r != match and r in match for match in matches)
        ]
        if len(longest) == 1:
            return longest[0] if longest[0] in ARMS else None
    return None


def repeatability_of(robot: Robot, repeatability: float | None) -> float | None:
    """Return the repeatability of a robot [m], as given [mm] or known of it; None for neither."""
    if repeatability is not None:
        return repeatability / 1e3
    name = known_arm(robot)
    return None if name is None else ARMS[name].repeatability


def _plain(name: str) -> str:
    return "".join(filter(str.isalnum, name.lower()))

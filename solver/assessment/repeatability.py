"""How well each arm comes back to where it was, as far as somebody says so."""

import re
from dataclasses import dataclass

from ..robot import shipped_robots


@dataclass(frozen=True)
class Arm:
    """How well an arm comes back to where it was."""

    repeatability: float
    """[m]."""
    source: str


ARMS: dict[str, Arm] = {
    "panda": Arm(1e-4, "Franka Emika's data sheet, ISO 9283"),
    "fr3": Arm(1e-4, "Franka Robotics' data sheet, ISO 9283"),
    "iiwa14": Arm(1.5e-4, "KUKA's data sheet of the LBR iiwa 14 R820, ISO 9283"),
    "gen3_lite": Arm(
        1e-3,
        "no maker's figure: the least that placements recorded with such an arm left when fitted "
        "alone, its gears having some 3 mrad of backlash",
    ),
    "ur3e": Arm(3e-5, "Universal Robots' data sheet, ISO 9283"),
    "ur5e": Arm(3e-5, "Universal Robots' data sheet, ISO 9283"),
    "ur10e": Arm(5e-5, "Universal Robots' data sheet, ISO 9283"),
    **dict.fromkeys(("ur3", "ur5", "ur10"), Arm(1e-4, "Universal Robots' data sheet, CB3 series")),
    **dict.fromkeys(("xarm6", "xarm7"), Arm(1e-4, "UFACTORY's user manual")),
    **dict.fromkeys(("vx300s", "wx250s"), Arm(1e-3, "Trossen Robotics' specifications")),
}
"""The shipped robots of which a figure is known."""

RESOLUTION = 1e-4
"""The smallest error that a ball in a printed socket can show, however good the arm is [m]."""


def known_arm(names: list[str]) -> str | None:
    """Return the shipped robot that a model's names stand for, if exactly one of ARMS does.

    Args:
        names: What the model and its file are called.
    """
    for name in names:
        plain = _plain(name)
        inside = [robot for robot in shipped_robots() if _is_named(_plain(robot), plain)]
        whole = [robot for robot in inside if not any(robot != b and robot in b for b in inside)]
        if len(whole) == 1:
            return whole[0] if whole[0] in ARMS else None
    return None


def _is_named(robot: str, name: str) -> bool:
    """Tell whether a name holds a robot's, and no longer number: a ur30 is no ur3."""
    return re.search(f"{robot}(?![0-9])", name) is not None


def _plain(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())

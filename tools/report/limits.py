"""The limits of the verdict: sensible for each arm, and where they come from."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["ARMS", "LIMITED", "Arm", "Limit", "Limits", "known_arm", "limits_for"]


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
}
"""The shipped robots."""

RESOLUTION = 1e-4
"""What a ball in a printed socket resolves, however well the arm repeats [m]."""
LIMITED = {
    "mean_absolute_error": (3, "--limit-mae-mm"),
    "distance_error": (1, "--limit-distance-mm"),
    "between_placements": (3, "--limit-between-mm"),
}
"""What is limited: to how many times the repeatability, and the option that says otherwise.

Errors of a calibrated arm stay within some three times its repeatability. A socket's centre is
the mean of many samples, so the distance of two is known better.
"""


@dataclass(frozen=True)
class Limit:
    """The largest value that passes."""

    value: float | None
    """[m]; None where nothing says what is good for this arm."""
    source: str
    """Where it comes from, or what is needed to have it."""


@dataclass(frozen=True)
class Limits:
    """What a calibration is held against."""

    repeatability: float | None
    """Of the arm [m], where it is known."""
    repeatability_source: str
    mean_absolute_error: Limit
    distance_error: Limit
    between_placements: Limit


def known_arm(names: list[str]) -> str | None:
    """Return the shipped robot that a model's names stand for, if exactly one does.

    Args:
        names: What the model and its file are called.
    """
    for name in map(_plain, names):
        inside = [arm for arm in ARMS if _plain(arm) in name]
        if len(inside) == 1:
            return inside[0]
    return None


def _plain(name: str) -> str:
    return "".join(letter for letter in name.lower() if letter.isalnum())


def limits_for(
    model: Mapping[str, Any], repeatability: float | None, given: Mapping[str, float | None]
) -> Limits:
    """Return the limits for an arm.

    Args:
        model: The document's ``model``.
        repeatability: As the user says [m]; None for the table's.
        given: Limits as the user says [m], by name of the field; None or missing for the arm's.
    """
    found = known_arm([str(model["name"]), Path(str(model["source"])).stem])
    if repeatability is not None:
        arm = Arm(repeatability, "given by --repeatability-mm")
    else:
        arm = ARMS[found] if found else None
    source = f"{found}: {arm.source}" if arm and repeatability is None else arm and arm.source
    return Limits(
        None if arm is None else arm.repeatability,
        source or "no repeatability is known for this arm",
        **{
            name: _limit(arm, margin, given.get(name), option)
            for name, (margin, option) in LIMITED.items()
        },
    )


def _limit(arm: Arm | None, margin: int, given: float | None, option: str) -> Limit:
    if given is not None:
        return Limit(given, f"given by {option}")
    if arm is None:
        return Limit(None, f"give --repeatability-mm (your arm's data sheet), or {option}")
    times = f"{margin} times the" if margin > 1 else "the"
    if arm.repeatability < RESOLUTION:
        words = f"{times} {1e3 * RESOLUTION:g} mm that a printed socket resolves"
    else:
        words = f"{times} arm's repeatability of {1e3 * arm.repeatability:g} mm"
    return Limit(margin * max(arm.repeatability, RESOLUTION), words)

"""Advice on placements: which two to train on, and where to record the next one."""

from itertools import combinations

import numpy as np

from ...errors import fixed
from ..identification.robot import Robot
from .configurations import FEWEST
from .inspection import Inspection, Survey

POINTS_HINT = "Measured points need no socket: spread the next ones over the workspace."
AS_FAR = 0.9
"""Share of the largest distance from which a place is as far: one that is 15 degrees on is not."""
ASIDE = 0.1
"""Sine of the direction from which a place is beside the robot."""


def next_placement(
    robot: Robot,
    survey: Survey,
) -> str:
    """Return in words which two placements to train on (paper, Fig. 6), and the next place."""
    mistaken = any(diagnostic.level == "error" for diagnostic in survey.shared)
    wrong = [one.measured.name for one in survey.placements if not one.sound]
    if mistaken and not wrong:
        return "Correct the errors above first."
    words = (
        [f"Correct the errors above in {' and '.join(wrong)} first."] if wrong else []
    )
    if mistaken:  # what all have may be of that alone
        return words[0]
    seated = [one for one in survey.placements if one.measured.kind == "sockets"]
    good = [one for one in seated if one.sound]
    if not seated:
        words.append(POINTS_HINT)
    if not good:
        return " ".join(words)
    rich = [one for one in good if _is_rich(one)]
    if len(rich) > 1:
        first, second = max(combinations(rich, 2), key=_distance)
        best = f"{first.measured.name} and {second.measured.name}"
        words.append(f"To solve with two of them only, take {best}, the most distant.")
    centres = np.array([one.centre for one in good])
    words.append(_next_place(robot, centres))
    return " ".join(words)


def _is_rich(inspection: Inspection) -> bool:
    """Tell whether enough samples in two sockets are there to train on the placement alone."""
    counts = sorted(inspection.measured.counts)
    return len(counts) > 1 and counts[-2] >= FEWEST


def _distance(pair: tuple[Inspection, Inspection]) -> float:
    """Return how far apart two placements are [m]."""
    first, second = pair
    return float(np.linalg.norm(first.centre - second.centre))


def _next_place(
    robot: Robot,
    centres: np.ndarray,
) -> str:
    """Return in words where to record beside placements at centres of shape (P, 3) [m]."""
    place = farthest_place(centres)
    x, y, z = place.tolist()
    pairs = zip("xyz", (x, y, z), strict=True)
    xyz = ", ".join(f"{axis} {fixed(value, 2, '+')}" for axis, value in pairs)
    distances = np.linalg.norm(centres - place, axis=1)
    aside = y / float(np.hypot(x, y))
    side = "in front"
    if aside > ASIDE:
        side = "left"
    elif aside < -ASIDE:
        side = "right"
    return (
        f"If you record another placement, put the socket base near {xyz} m in the frame of "
        f"{robot.base} ({side} of the robot), {distances.min():.2f} m from the nearest so far, or "
        "as far that way as the arm reaches."
    )


def farthest_place(centres: np.ndarray) -> np.ndarray:
    """Return a place in front or beside, farthest from centres of shape (P, 3), shape (3,) [m]."""
    radius = np.linalg.norm(centres[:, :2], axis=1).mean()
    height = centres[:, 2].mean()
    angles = np.deg2rad(np.arange(90, -91, -15))
    x = radius * np.cos(angles)
    y = radius * np.sin(angles)
    ring = np.column_stack([x, y, np.full(len(angles), height)])
    distances = np.linalg.norm(ring[:, None] - centres, axis=2)
    gaps = distances.min(axis=1)
    # a base before the robot has two: the left one, whoever measured where it stands
    return ring[int(np.argmax(gaps > AS_FAR * gaps.max()))]

"""Advice on placements: which to train on, and a place for the next one."""

import numpy as np

from ..robot import Robot
from .inspection import Survey


def next_placement(robot: Robot, survey: Survey) -> str:
    """Return in words which placements to train on, and a place for the next one.

    The two most distant placements serve best (paper, Fig. 6), if nothing is wrong with them.
    """
    mistaken = any(diagnostic.level == "error" for diagnostic in survey.shared)
    names = [one.measured.name for one in survey.placements]
    sound = np.array([one.sound and not mistaken for one in survey.placements])
    centres = np.array([one.centre for one in survey.placements])[sound]
    wrong = [name for name, good in zip(names, sound, strict=True) if not good]
    words = [f"First mend {' and '.join(wrong)}: see the errors."] if wrong else []
    if not sound.any():
        return " ".join(words)
    if len(centres) > 1:
        apart = np.linalg.norm(centres[:, None] - centres, axis=2)
        pair = np.unravel_index(int(np.argmax(apart)), apart.shape)
        good = [name for name, fine in zip(names, sound.tolist(), strict=True) if fine]
        best = " and ".join(good[int(i)] for i in pair)
        words.append(f"To train on two, {best} serve best: they are the most distant.")
    place = farthest_place(centres)
    x, y, z = place.tolist()
    gap = float(np.linalg.norm(centres - place, axis=1).min())
    side = "left" if y > 0.1 * np.hypot(x, y) else "right" if y < -0.1 * np.hypot(x, y) else "front"
    words.append(
        f"Next, record a placement near x {x:+.2f}, y {y:+.2f}, z {z:+.2f} m in the frame of "
        f"{robot.base} (to its {side}), {gap:.2f} m from the nearest so far, or as far that "
        "way as the arm reaches."
    )
    return " ".join(words)


def farthest_place(centres: np.ndarray) -> np.ndarray:
    """Return a place for a new placement, farthest from those recorded, shape (3,) [m].

    Candidates stand as far from the base axis and as high as those recorded, on all sides of
    the robot but its back.

    Args:
        centres: Of the placements recorded, in the base frame, shape (P, 3) [m].
    """
    radius = float(np.linalg.norm(centres[:, :2], axis=1).mean())
    height = float(centres[:, 2].mean())
    angles = np.deg2rad(np.arange(-90, 91, 15))
    ring = np.stack(
        [radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), height)], axis=1
    )
    gaps = np.linalg.norm(ring[:, None] - centres, axis=2).min(axis=1)
    return ring[int(np.argmax(gaps))]

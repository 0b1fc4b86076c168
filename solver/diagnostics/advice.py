"""Which placements to train on, and where to record the next one."""

from collections.abc import Sequence

import numpy as np

from ..robot import Robot


def place_advice(
    robot: Robot, names: Sequence[str], centres: np.ndarray, sound: Sequence[bool]
) -> str:
    """Return which placements to train on, and where to record the next one.

    The two most distant placements serve best (paper, Fig. 6), if nothing is wrong with them.

    Args:
        robot: The robot.
        names: Of the placements.
        centres: Of their sockets in the base frame, shape (P, 3) [m].
        sound: Which of them have no error.
    """
    wrong = [name for name, good in zip(names, sound, strict=True) if not good]
    good = np.flatnonzero(sound)
    words = [f"First mend {' and '.join(wrong)}: see the errors."] if wrong else []
    if len(good) == 0:
        return " ".join(words)
    if len(good) > 1:
        apart = np.linalg.norm(centres[good][:, None] - centres[good], axis=2)
        i, j = np.unravel_index(int(np.argmax(apart)), apart.shape)
        best = f"{names[int(good[i])]} and {names[int(good[j])]}"
        words.append(f"To train on two, {best} serve best: they are the most distant.")
    x, y, z = place = farthest_place(centres[good])
    gap = float(np.linalg.norm(centres[good] - place, axis=1).min())
    side = "left" if y > 0.1 * np.hypot(x, y) else "right" if y < -0.1 * np.hypot(x, y) else "front"
    words.append(
        f"Next, record a placement near x {x:+.2f}, y {y:+.2f}, z {z:+.2f} m in the frame of "
        f"{robot.base} (to its {side}), {gap:.2f} m from the nearest so far, or as far that "
        "way as the arm reaches."
    )
    return " ".join(words)


def farthest_place(centres: np.ndarray) -> np.ndarray:
    """Return where a new placement would be farthest from those recorded, shape (3,) [m].

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

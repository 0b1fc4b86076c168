"""Joint positions and efforts that people hand over, as checked rows of numbers."""

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MukcaError
from ..robot import Robot


class JointsError(MukcaError):
    """Joint positions or efforts that are not those of the robot."""


def joint_rows(
    robot: Robot, values: ArrayLike, what: str, *, stacked: bool = False
) -> np.ndarray:
    """Return a number for each joint as rows, shape (N, m).

    They have shape (m,) or (N, m), or if they may be ``stacked``, (..., m).

    Raises:
        JointsError: Another number of joints than the robot's, or what is no finite number.
    """
    names = robot.joint_names
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise JointsError(f"{what}: {values!r:.60} are no numbers") from None
    if array.shape[-1:] != (len(names),) or (array.ndim > 2 and not stacked):
        raise JointsError(
            f"{what} of shape {np.shape(values)}: {robot.name} has {len(names)} joints, "
            f"so shape ({len(names)},) or (N, {len(names)}) is needed; in order: "
            f"{', '.join(names)}"
        )
    rows = array.reshape(-1, len(names))
    if not np.isfinite(rows).all():
        row, column = np.argwhere(~np.isfinite(rows))[0].tolist()
        raise JointsError(
            f"{what}: row {row}, {names[column]!r} is {rows[row, column]}"
        )
    return rows

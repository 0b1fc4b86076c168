"""Joint positions and efforts that people hand over, as checked rows of numbers."""

import numpy as np
from numpy.typing import ArrayLike

from ...errors import JOINT_POSITION, MukcaError
from ..identification.robot import Robot


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
    for row, column in np.argwhere(~np.isfinite(rows))[:1].tolist():
        raise JointsError(
            f"{what}: row {row}, {names[column]!r} is {rows[row, column]}"
        )
    return rows


def position_rows(
    robot: Robot, q: ArrayLike, what: str, *, stacked: bool
) -> np.ndarray:
    """Return :func:`joint_rows` of joint positions, none of which is too large for one.

    Raises:
        JointsError: As there, or a number that is no position.
    """
    rows = joint_rows(robot, q, what, stacked=stacked)
    too_large = np.argwhere(abs(rows) > JOINT_POSITION.largest)
    for row, joint in too_large[:1].tolist():
        name, position = robot.joint_names[int(joint)], float(rows[row, joint])
        doubt = JOINT_POSITION.doubt([position])
        raise JointsError(f"{what}: row {row}, {name!r} is {doubt}")
    return rows


def effort_rows(robot: Robot, effort: ArrayLike, count: int) -> np.ndarray:
    """Return :func:`joint_rows` of joint efforts, one for each row of joint positions.

    Raises:
        JointsError: As there, or another number of rows.
    """
    rows = joint_rows(robot, effort, "joint efforts")
    if len(rows) != count:
        raise JointsError(
            f"{len(rows)} rows of joint efforts for {count} of joint positions; "
            "give one effort for each position"
        )
    return rows


def rows_for_poses(robot: Robot, q: ArrayLike, count: int, what: str) -> np.ndarray:
    """Return one row of joint positions for each pose, those for all of them repeated.

    Raises:
        JointsError: As of :func:`position_rows`, or another number of rows.
    """
    rows = position_rows(robot, q, what, stacked=True)
    if len(rows) == count:
        return rows
    if len(rows) != 1:
        raise JointsError(
            f"{what} of shape {np.shape(q)} for {count} poses; give them once, or for each pose"
        )
    return np.repeat(rows, count, axis=0)

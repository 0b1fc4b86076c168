"""The look at a placement's numbers before anything is fitted to them.

Places that no arm reaches are refused. Rows in which nothing was read are left out, each told by
its line: all joints exactly 0, a place of exactly 0, or numbers of the row before though the arm
moved.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ....errors import LENGTH
from ....recorder import Placement
from ..robot import BallModel, Robot
from .measurements import MeasurementError

LEAST_JOINTS = 3
"""Fewer joints than this may all stand at exactly 0."""
STOOD = 5e-3
"""A ball that moved by less may be measured at the same place again [m]."""
LISTED = 8
"""Rows that are told one by one."""
FARTHEST = 100.0
"""Coordinate beyond which a turn of the frame is no small change to a fit [m]."""


def without_lost_rows(placement: Placement, robot: Robot) -> Placement:
    """Return a placement without rows in which nothing was read, and a remark on each of them.

    One that has no other rows is left as it is, to be refused.

    Args:
        placement: The recording, its joints in the robot's order.
        robot: The robot.
    """
    reasons = dict(sorted(_lost_rows(placement, robot)))
    samples = [s for row, s in enumerate(placement.samples) if row not in reasons]
    if not reasons or not samples:
        return placement
    told = [
        f"{placement.samples[row].where or placement.name}: {reason}; left out"
        for row, reason in reasons.items()
    ]
    if len(told) > LISTED:
        told[LISTED:] = [f"{told[LISTED]}, one of {len(told)} such rows"]
    remarks = (*placement.remarks, *told)
    return replace(placement, samples=tuple(samples), remarks=remarks)


def require_near(placement: Placement) -> None:
    """Refuse measured places that are farther from the others than an arm reaches, or far away.

    Raises:
        MeasurementError: There is one; the message names its line.
    """
    if placement.kind == "sockets":
        return
    points = _points(placement)
    offsets = np.abs(points - np.median(points, axis=0)).max(axis=1)
    sizes = np.abs(points).max(axis=1)
    far = np.flatnonzero((offsets > LENGTH.largest) | (sizes > FARTHEST)).tolist()
    if not far:
        return
    first, *others = far
    words = f"; {len(others)} more such lines" if others else ""
    where = placement.samples[first].where or placement.name
    worst = max(points[first].tolist(), key=abs)
    advice = placement.suggestion or "a header of x [mm] is read as such"
    raise MeasurementError(
        f"{where}: x, y or z is {worst:.6g}: metres are expected, from an origin near the arm"
        f"{words} (are these millimetres? {advice})"
    )


def _lost_rows(placement: Placement, robot: Robot) -> Iterator[tuple[int, str]]:
    """Yield the rows in which nothing was read, and why."""
    q = placement.positions
    zero = ~q.any(axis=1) & (q.shape[1] >= LEAST_JOINTS)
    for row in np.flatnonzero(zero).tolist():
        yield row, "all joints read exactly 0: the controller was not up"
    if placement.kind == "sockets":
        return
    points = _points(placement)
    nothing = ~zero & ~points.any(axis=1)
    for row in np.flatnonzero(nothing).tolist():
        yield row, "x, y and z are exactly 0: nothing was measured"
    balls = BallModel(robot, []).points(np.zeros(0), q)
    travels = np.linalg.norm(np.diff(balls, axis=0), axis=1)
    shifts = np.linalg.norm(np.diff(points, axis=0), axis=1)
    stale = (shifts == 0) & (travels > STOOD)
    stuck = ~np.diff(q, axis=0).any(axis=1) & (shifts > STOOD)
    for rows, what, other, moves in (
        (stale, "x, y and z", "the arm", travels),
        (stuck, "all joints", "the place", shifts),
    ):
        for row in np.flatnonzero(rows & ~(zero | nothing)[1:]).tolist():
            moved = f"{other} moved by {1e3 * moves[row]:.0f} mm"
            yield row + 1, f"{what} repeat the row before, though {moved}"


def _points(placement: Placement) -> np.ndarray:
    """Return what was measured, row by row, shape (N, 3) [m]."""
    return np.array([sample.point for sample in placement.samples], dtype=float)

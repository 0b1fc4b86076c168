"""What is otherwise throughout one placement: where its ball sits, a joint's zero, or a drift.

It has unknowns of its own beside the arm's, as a place that moves has; see :mod:`.movement`.
"""

from dataclasses import dataclass

import numpy as np

from ..data import BALL, DRIFT, Apart, Measurement, Observations, RobotRecordings
from ..robot import BallModel, Robot
from .movement import SIZE, Movement
from .prior_group import PriorGroup

WIDTHS = {BALL: 5e-3, DRIFT: SIZE}
"""Usual sizes of a difference of the ball's place, and of a drift [m]."""
ZERO = 0.03
"""The same of a joint's zero [rad]."""


def width_of(difference: Apart) -> float:
    """Return the usual size of a difference [m], [rad]."""
    return WIDTHS.get(difference.part, ZERO)


def shifts_by(
    robot: Robot,
    q: np.ndarray,
    order: np.ndarray,
    difference: Apart,
) -> np.ndarray:
    """Return by how much balls are predicted off for each unknown of a difference, (N, 3, k).

    Of the ball it is -R, the rotation of its link. Of a zero that reads o too much it is
    (Phi(q) - Phi(q - o)) / o, exact at the size ``o`` that was seen. A drift goes by the ``order``
    of recording, shape (N,), since files of sockets have no times.
    """
    if difference.part == DRIFT:
        course = order / max(order.max(), 1) - 0.5
        return course[:, None, None] * np.eye(3)
    model = BallModel(robot, [])
    nominal = np.zeros(0)
    if difference.part == BALL:
        return -model.rotations(nominal, q).points
    joint = robot.joint_names.index(difference.part)
    size = difference.size or 1e-6
    true = q.copy()
    true[:, joint] -= size
    balls = model.points(nominal, q)
    shift = balls - model.points(nominal, true)
    return shift[:, :, None] / size


@dataclass(frozen=True, kw_only=True)
class Difference(Movement):
    """A difference as the objective has it: a place that is elsewhere in every sample."""

    robot: Robot
    apart: Apart

    @property
    def size(self) -> int:
        """Number of its unknowns."""
        return 3 if self.apart.part in WIDTHS else 1

    def slopes(self, data: Observations) -> np.ndarray:
        """Return the derivatives of places by the unknowns for all samples, shape (N, 3, size)."""
        rows = data.rows_of(self.placement)
        slopes = np.zeros((len(rows), 3, self.size))
        if rows.any():
            order = data.index[rows, 0]
            slopes[rows] = shifts_by(self.robot, data.q[rows], order, self.apart)
        return slopes

    def prior(self, begin: int) -> PriorGroup:
        """Return the prior of its unknowns, from some index on."""
        unit = "m" if self.apart.part in WIDTHS else "rad"
        name = f"{self.apart.part} of {self.placement}"
        members = np.arange(begin, begin + self.size)
        width = width_of(self.apart)
        return PriorGroup(
            name,
            unit,
            members,
            width,
            learned=False,
        )


def differences_of(recordings: RobotRecordings) -> list[Movement]:
    """Return all that is otherwise in single placements of a robot."""
    differences: list[Movement] = []
    for measured in recordings.measurements:
        for apart in measured.apart:
            difference = Difference(
                placement=measured.name,
                kind="difference",
                robot=recordings.robot,
                apart=apart,
            )
            differences.append(difference)
    return differences


def set_apart(robot: Robot, measured: Measurement, balls: np.ndarray) -> np.ndarray:
    """Return by how much a placement's balls are predicted off, shape (N, 3) [m].

    A drift is as large as it was seen to be. What else is otherwise in a placement in sockets
    follows from its own samples, about the places of these.
    """
    moved = np.zeros_like(balls)
    shifts: list[np.ndarray] = []
    for difference in measured.apart:
        slopes = shifts_by(robot, measured.positions, measured.order, difference)
        if difference.part == DRIFT:
            moved += slopes @ difference.shift
        elif measured.kind == "sockets":
            shifts.append(slopes)
    if not shifts:
        return moved
    slopes = np.concatenate(shifts, axis=2)
    offsets = balls - moved
    centred = slopes.copy()
    for rows in measured.slices:
        centred[rows] -= slopes[rows].mean(axis=0)
        offsets[rows] -= offsets[rows].mean(axis=0)
    flat = centred.reshape(-1, slopes.shape[2])
    flat_offsets = offsets.ravel()
    sizes = np.linalg.lstsq(flat, flat_offsets, rcond=1e-6)[0]
    return moved + slopes @ sizes

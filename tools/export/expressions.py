"""The full model of a calibrated robot as CasADi expressions, to make code of it.

Nothing is written here a second time: the corrections of the joints are those of the model's
``Deflection.true_positions``, traced with symbols for numbers, and the kinematics those of
:func:`mukca.solver.robot.kinematics.link_frames`.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ...solver.results import CalibratedRobot
from ...solver.robot import Joint, link_frames, moments_function


@dataclass(frozen=True)
class FullModel:
    """A robot's model as expressions of its joint positions; each is a column of CasADi's SX."""

    q: Any
    """Joint positions as the encoders read them, shape (m,) [rad]."""
    gravity: Any
    """The torques by which the joints hold the arm, shape (m,) [N m]."""
    corrected: Any
    """True positions of the joints, shape (m,) [rad]; their tilts follow where there are any."""
    joints: tuple[Joint, ...]
    """The chain, from the base to the ball."""
    origins: Any
    """The calibrated origins of its joints, one after the other."""
    frames: tuple[tuple[Any, Any], ...]
    """Rotation and position of each joint's child link in the base frame."""

    @property
    def true_positions(self) -> Any:
        """True positions of the joints, shape (m,) [rad]."""
        return self.corrected[: self.q.numel()]

    @property
    def ball(self) -> Any:
        """The ball's centre in the base frame, shape (3,) [m]."""
        return ca.densify(self.frames[-1][1])

    def pose(self, joint: int) -> Any:
        """Return the pose of a joint's child link in the base frame, shape (4, 4)."""
        R, p = self.frames[joint]
        return ca.densify(ca.vertcat(ca.horzcat(R, p), ca.DM([[0, 0, 0, 1]])))

    def jacobian(self, joint: int) -> Any:
        """Return the geometric Jacobian of a joint's child link, shape (6, m).

        It carries the speeds of the joints, as their encoders read them, to the speed of the
        link's origin [m/s], upper rows, and to its angular velocity [rad/s], lower rows; both in
        the base frame.
        """
        t = ca.SX.sym("t", self.corrected.numel())
        R, p = link_frames(self.joints, self.origins, t)[joint]
        slopes = ca.jacobian(ca.vec(R), t)
        columns: list[Any] = []
        for i in range(t.numel()):
            W = ca.reshape(slopes[:, i], 3, 3) @ R.T  # dR/dt R^T, the angular velocity's matrix
            columns.append(ca.vertcat(W[2, 1], W[0, 2], W[1, 0]))
        by_corrected = ca.vertcat(ca.jacobian(p, t), ca.horzcat(*columns))
        by_corrected = ca.substitute(by_corrected, t, self.corrected)
        return ca.densify(by_corrected @ ca.jacobian(self.corrected, self.q))


def full_model(calibrated: CalibratedRobot) -> FullModel:
    """Return the full model of a calibrated robot, all its corrections included."""
    robot, load = calibrated.robot, calibrated.load
    m = len(robot.actuated)
    q = ca.SX.sym("q", m)
    moments = moments_function(robot, load.gravity, load.payload)(q)
    true = q
    if calibrated.deflection.extensions:
        row = calibrated.deflection.true_positions(_row(q), _row(moments))
        true = ca.vertcat(*row[0])
    origins = ca.DM(calibrated.model.origins(calibrated.values).ravel())
    frames = link_frames(robot.joints, origins, true)
    return FullModel(q, moments[:m], true, robot.joints, origins, tuple(frames))


def _row(column: Any) -> np.ndarray:
    """Return a column of symbols as an array of one row, on which NumPy computes as on numbers."""
    row = np.empty((1, column.numel()), dtype=object)
    for i in range(column.numel()):
        row[0, i] = column[i]
    return row

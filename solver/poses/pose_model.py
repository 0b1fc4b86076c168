"""The poses of a robot's links, derivatives and inverse kinematics as expressions.

The kinematics are those of :func:`.frames_and_motions`, at joint positions that a calibration
corrects; the library computes with these CasADi expressions, and exports make code of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca
import numpy as np

from ..identification.robot import (
    ModelError,
    Motion,
    Robot,
    find_chain,
    frames_and_motions,
    link_poses,
    require_link,
    written_frames,
)

Goal = Literal["pose", "point"]
"""Part of the target's pose that counts: all, or its origin."""
MAX_STEP = 0.5
"""Largest step of a joint [rad, m]."""
MAX_PULL = 0.3
"""Largest part of it that the preferred posture asks for [rad, m]."""
DAMPING, LEAST_DAMPING = 0.1, 1e-12
"""l as a share of |e|^2; the least one keeps the matrix invertible at singular configurations."""


@dataclass(frozen=True)
class PoseModel:
    """A robot's model as expressions of its joint positions; each is a column of CasADi's SX."""

    q: Any
    """Joint positions as the encoders read them, shape (m,) [rad]."""
    corrected: Any
    """True positions of the joints, shape (m,) [rad]; their tilts follow where there are any."""
    frames: Sequence[tuple[Any, Any]]
    """Rotation and position of each joint's child link in the base frame."""
    motions: Sequence[Motion]
    """By each number of ``corrected``."""

    @classmethod
    def of(
        cls,
        robot: Robot,
        origins: np.ndarray | None = None,
        correct: Callable[[Any], Any] | None = None,
    ) -> "PoseModel":
        """Return the model of a robot; None for the origins of its URDF, and for a rigid one.

        Origins have shape (joints, 6). ``correct`` makes the true positions of joints that read q,
        and their tilts where there are any.
        """
        q = ca.SX.sym("q", len(robot.actuated))
        corrected = q if correct is None else correct(q)
        arm = robot if origins is None else robot.with_origins(origins)
        links, motions = frames_and_motions(
            arm.joints, written_frames(arm.joints), corrected
        )
        return cls(q, corrected, links, motions)

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
        upper = ca.horzcat(*self.frames[joint])
        last_row = ca.DM([[0, 0, 0, 1]])
        return ca.densify(ca.vertcat(upper, last_row))

    def jacobian(
        self,
        joint: int,
        point: Any = None,
    ) -> Any:
        """Return the geometric Jacobian of a joint's child link, shape (6, m).

        It carries the speeds of the joints, as their encoders read them, to the speed of the
        link's origin, or of another point on it [m/s], upper rows, and to its angular velocity
        [rad/s], lower rows; both in the base frame.
        """
        if point is None:
            _, point = self.frames[joint]
        corrected_by_q = ca.jacobian(self.corrected, self.q)
        return ca.densify(self.by_corrected(joint, point) @ corrected_by_q)

    def by_corrected(
        self,
        joint: int,
        point: Any,
    ) -> Any:
        """Return the same by the corrected positions and tilts, shape (6, m) or (6, 3 m).

        Its first m columns are nearly those of :meth:`jacobian`, since joints are corrected by
        milliradians, and take a tenth of the work.
        """
        columns = [ca.DM.zeros(6)] * len(self.motions)
        for k, motion in enumerate(self.motions):
            if motion.joint <= joint:
                columns[k] = ca.vertcat(motion.shift(point), motion.turn)
        return ca.horzcat(*columns)


def pose_on_flange(
    robot: Robot,
    link: str,
    origins: np.ndarray,
) -> np.ndarray:
    """Return the pose of a link that stands still on the flange, in its frame, shape (4, 4).

    The link may be that of the ball, too; origins are those of the chain's joints, shape (joints,
    6).

    Raises:
        ModelError: No such link, or one that moves against the flange.
    """
    require_link(robot.text, link)
    arm = robot.with_origins(origins)
    flange = _pose_in_last_link(arm, robot.ball_joint.parent, link)
    return np.linalg.inv(flange) @ _pose_in_last_link(arm, link, link)


def _pose_in_last_link(
    arm: Robot,
    name: str,
    link: str,
) -> np.ndarray:
    """Return the pose of a link in the last one that a joint moves, shape (4, 4).

    Joints of the chain have their calibrated origins. ``link`` is the one that was asked for.
    """
    try:
        joints = find_chain(arm.text, arm.actuated[-1].child, name)
    except ModelError:
        joints = arm.actuated
    if any(joint.actuated for joint in joints):
        raise ModelError(
            f"{arm.source}: link {link!r} does not stand still on "
            f"{arm.ball_joint.parent!r}; give the tool's pose there, shape (4, 4)"
        )
    calibrated = {joint.name: joint for joint in arm.joints}
    fixed = [calibrated.get(joint.name, joint) for joint in joints]
    poses = link_poses(fixed, np.zeros((1, 0)))
    last_row = np.eye(4)[3:]
    return np.vstack([poses[0, -1], last_row])


@dataclass(frozen=True)
class NewtonStep:
    """Expressions of one step, and their symbols; poses are rows of [R | p], 12 numbers."""

    symbols: dict[str, Any]
    """``tool`` on the link and ``target``, shape (12,); positions ``q`` and the posture ``prefer``
    to stay near, shape (m,) [rad]."""
    left: Any
    """Distance [m] and angle [rad] that are left at q, shape (2,)."""
    error: Any
    """The same as a shift and a rotation vector, shape (6,), or (3,) of a point."""
    jacobian: Any
    """Its Jacobian J, shape (6, m) or (3, m)."""
    change: Any
    """The step, shape (m,) [rad], which may be too long or leave the limits."""


def newton_step(
    model: PoseModel,
    joint: int,
    goal: Goal,
) -> NewtonStep:
    """Return one step toward a pose of a tool on a joint's child link: damped, and near a posture.

    With the error e of the pose, as a shift and a rotation vector, its Jacobian J by the joint
    positions, and d = prefer - q, the step is the s that minimises

        |J s - e|^2 / l + |s - d|^2    with lower <= q + s <= upper and l = |e|^2 / 10

    (Levenberg-Marquardt): s = d + J^T (J J^T + l I)^-1 (e - J d), here without limits. What the
    pose leaves free moves to the preferred posture; where a joint comes to its limit, the others
    make up for it, see :func:`limited_step`. J leaves out that corrections of joints change with q,
    which costs a thousandth of the error each round.
    """
    m = model.q.numel()
    tool = ca.SX.sym("tool", 12)
    target = ca.SX.sym("target", 12)
    prefer = ca.SX.sym("prefer", m)
    R, p = model.frames[joint]
    R_tool, p_tool = _parts(tool)
    R_target, p_target = _parts(target)
    point = p + R @ p_tool
    slopes = model.by_corrected(joint, point)[:, :m]
    shift = p_target - point
    e = shift
    angle = ca.SX(0)
    if goal == "pose":
        turn, angle = _turn(R @ R_tool, R_target)
        e = ca.vertcat(shift, turn)
    J = slopes[: e.numel(), :]
    pull = _pull(model.q, prefer, e)
    distance = ca.norm_2(shift)
    return NewtonStep(
        symbols={"tool": tool, "q": model.q, "target": target, "prefer": prefer},
        left=ca.vertcat(distance, angle),
        error=e,
        jacobian=J,
        change=_damped(J, J, e, pull),
    )


def limited_step(
    step: NewtonStep,
    lower: Any,
    upper: Any,
) -> Any:
    """Return the step within limits, shape (m,) [rad].

    A joint that passes its limit goes to it and stays there, and the others make up for it.
    """
    q = step.symbols["q"]
    J = step.jacobian
    e = step.error
    change = step.change
    floor = ca.fmax(lower - q, -MAX_STEP)
    ceiling = ca.fmin(upper - q, MAX_STEP)
    pull = _pull(q, step.symbols["prefer"], e)
    inside = ca.fmax(ca.fmin(change, ceiling), floor)
    unbound = inside == change
    mask = ca.repmat(unbound.T, e.numel(), 1)
    change = _damped(J * mask, J, e, unbound * pull + (1 - unbound) * inside)
    return ca.fmax(ca.fmin(change, ceiling), floor)


def _pull(
    q: Any,
    prefer: Any,
    e: Any,
) -> Any:
    """Return the step that a preferred posture asks for, where there are joints to spare."""
    if q.numel() <= e.numel():
        return ca.SX.zeros(q.numel())
    return ca.fmax(ca.fmin(prefer - q, MAX_PULL), -MAX_PULL)


def _damped(
    freed: Any,
    J: Any,
    e: Any,
    moves: Any,
) -> Any:
    """Return a step: some moves, and the damped one of free joints for what these leave."""
    damping = DAMPING * ca.dot(e, e) + LEAST_DAMPING
    identity = ca.SX.eye(e.numel())
    factors = ca.ldl(freed @ freed.T + damping * identity, False)
    return moves + freed.T @ ca.ldl_solve(e - J @ moves, *factors)


def _parts(pose: Any) -> tuple[Any, Any]:
    """Return the rotation and the translation of a pose written as the rows of [R | p]."""
    matrix = ca.reshape(pose, 4, 3).T
    return matrix[:, :3], matrix[:, 3]


def _turn(
    R: Any,
    target: Any,
) -> tuple[Any, Any]:
    """Return the rotation vector from one rotation to another, and its length [rad]."""
    E = target @ R.T
    sines = ca.inv_skew(E)  # of its antisymmetric part
    sine = ca.sqrt(
        ca.dot(sines, sines) + 1e-32
    )  # of a turn of pi the axis is lost, not the angle
    angle = ca.atan2(sine, (ca.trace(E) - 1) / 2)
    return sines * (angle / sine), angle

"""The poses of a robot's links, derivatives, inverse kinematics and weight as expressions.

The kinematics are those of :func:`.frames_and_motions`, at joint positions that a calibration
corrects; the library computes with these CasADi expressions, and exports make code of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import casadi as ca
import numpy as np

from .bodies import Body
from .chain import Joint, find_chain, require_link
from .kinematics import (
    Motion,
    frames_and_motions,
    link_poses,
    written_frames,
)
from .row_function import RowFunction
from .urdf import Robot
from .urdf_text import ModelError

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Acceleration in the base frame of an arm that stands upright [m/s^2]."""
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
        true = q if correct is None else correct(q)
        joints = robot.joints if origins is None else robot.with_origins(origins).joints
        frames, _, motions = frames_and_motions(joints, written_frames(joints), true)
        return cls(q, true, frames, motions)

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
        return ca.densify(ca.vertcat(upper, ca.DM([[0, 0, 0, 1]])))

    def jacobian(self, joint: int, point: Any = None) -> Any:
        """Return the geometric Jacobian of a joint's child link, shape (6, m).

        It carries the speeds of the joints, as their encoders read them, to the speed of the
        link's origin, or of another point on it [m/s], upper rows, and to its angular velocity
        [rad/s], lower rows; both in the base frame.
        """
        by_corrected = self.by_corrected(
            joint, self.frames[joint][1] if point is None else point
        )
        return ca.densify(by_corrected @ ca.jacobian(self.corrected, self.q))

    def by_corrected(self, joint: int, point: Any) -> Any:
        """Return the same by the corrected positions and tilts, shape (6, m) or (6, 3 m).

        Its first m columns are nearly those of :meth:`jacobian`, since joints are corrected by
        milliradians, and take a tenth of the work.
        """
        columns = [ca.DM.zeros(6)] * len(self.motions)
        for k, motion in enumerate(self.motions):
            if motion.joint <= joint:
                columns[k] = ca.vertcat(motion.shift(point), motion.turn)
        return ca.horzcat(*columns)


def pose_on_flange(robot: Robot, link: str, origins: np.ndarray) -> np.ndarray:
    """Return the pose of a link that stands still on the flange, in its frame, shape (4, 4).

    The link may be that of the ball, too; origins are those of the chain's joints, shape (joints,
    6).

    Raises:
        ModelError: No such link, or one that moves against the flange.
    """
    require_link(robot.text, link)
    calibrated = {joint.name: joint for joint in robot.with_origins(origins).joints}

    def in_last_that_moves(name: str) -> np.ndarray:
        try:
            joints = find_chain(robot.text, robot.actuated[-1].child, name)
        except ModelError:
            joints = robot.actuated
        if any(joint.actuated for joint in joints):
            raise ModelError(
                f"{robot.source}: link {link!r} does not stand still on "
                f"{robot.ball_joint.parent!r}; give the tool's pose there, shape (4, 4)"
            )
        fixed = [calibrated.get(joint.name, joint) for joint in joints]
        pose = link_poses(fixed, np.zeros((1, 0)))[0, -1]
        return np.vstack([pose, np.eye(4)[3:]])

    return np.linalg.inv(
        in_last_that_moves(robot.ball_joint.parent)
    ) @ in_last_that_moves(link)


def gravity_moments(
    robot: Robot,
    positions: np.ndarray,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    payload: float = 0.0,
) -> np.ndarray:
    """Return the moments by which each joint holds the arm against gravity, about its three axes.

    They are slopes of the potential energy of the URDF's masses and of a payload [kg] at the ball,
    by the nominal model at joint positions of shape (N, m), with gravity in the base frame [m/s^2].

    Returns:
        Moments [N m] ([N] along a prismatic joint), shape (N, 3 m): about the joints' own axes,
        then about the first of each one's :attr:`.Joint.tilt_axes`, then about the second.
    """
    function = _moments(robot.joints, robot.bodies, payload)
    return function(positions, np.array(gravity))[0]


def moments_function(
    robot: Robot, gravity: Sequence[float] = STANDARD_GRAVITY, payload: float = 0.0
) -> Any:
    """Return :func:`gravity_moments` as a CasADi function of one configuration."""
    of_both = _moments(robot.joints, robot.bodies, payload).function
    q = ca.SX.sym("q", of_both.numel_in(1))
    moments = of_both(ca.DM(list(gravity)), q).T
    return ca.Function("moments", [q], [moments], {"cse": True})


@lru_cache(maxsize=16)
def _moments(
    joints: tuple[Joint, ...], bodies: tuple[Body, ...], payload: float
) -> RowFunction:
    m = sum(joint.actuated for joint in joints)
    q = ca.SX.sym("q", m)
    tilts = ca.SX.sym("tilts", 2 * m)
    gravity = ca.SX.sym("gravity", 3)
    frames, _, _ = frames_and_motions(
        joints, written_frames(joints), ca.vertcat(q, tilts)
    )
    energy: Any = -payload * ca.dot(gravity, frames[-1][1])
    for body in bodies:
        R, p = frames[body.joint]
        energy -= body.mass * ca.dot(gravity, p + R @ ca.DM(body.centre))
    # Virtual work: a moment is the slope of the energy, here of an arm that does not tilt.
    slopes = ca.densify(ca.gradient(ca.SX(energy), ca.vertcat(q, tilts)))
    upright = ca.substitute(slopes, tilts, ca.DM.zeros(2 * m))
    return RowFunction("moments", [gravity, q], [upright])


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


def newton_step(model: PoseModel, joint: int, goal: Goal) -> NewtonStep:
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
    change = _damped(J, J, e, _pull(model.q, prefer, e))
    symbols = {"tool": tool, "q": model.q, "target": target, "prefer": prefer}
    return NewtonStep(symbols, ca.vertcat(ca.norm_2(shift), angle), e, J, change)


def limited_step(step: NewtonStep, lower: Any, upper: Any) -> Any:
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
    freed = J * ca.repmat(unbound.T, e.numel(), 1)
    change = _damped(freed, J, e, unbound * pull + (1 - unbound) * inside)
    return ca.fmax(ca.fmin(change, ceiling), floor)


def _pull(q: Any, prefer: Any, e: Any) -> Any:
    """Return the step that a preferred posture asks for, where there are joints to spare."""
    if q.numel() <= e.numel():
        return ca.SX.zeros(q.numel())
    return ca.fmax(ca.fmin(prefer - q, MAX_PULL), -MAX_PULL)


def _damped(freed: Any, J: Any, e: Any, moves: Any) -> Any:
    """Return a step: some moves, and the damped one of free joints for what these leave."""
    damping = (DAMPING * ca.dot(e, e) + LEAST_DAMPING) * ca.SX.eye(e.numel())
    factors = ca.ldl(freed @ freed.T + damping, False)
    return moves + freed.T @ ca.ldl_solve(e - J @ moves, *factors)


def _parts(pose: Any) -> tuple[Any, Any]:
    """Return the rotation and the translation of a pose written as the rows of [R | p]."""
    matrix = ca.reshape(pose, 4, 3).T
    return matrix[:, :3], matrix[:, 3]


def _turn(R: Any, target: Any) -> tuple[Any, Any]:
    """Return the rotation vector from one rotation to another, and its length [rad]."""
    E = target @ R.T
    sines = ca.inv_skew(E)  # of its antisymmetric part
    # Of a turn of pi the axis is lost, not the angle.
    sine = ca.sqrt(ca.dot(sines, sines) + 1e-32)
    angle = ca.atan2(sine, (ca.trace(E) - 1) / 2)
    return sines * (angle / sine), angle

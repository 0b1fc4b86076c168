"""One step of the inverse kinematics as an expression: damped, within limits, near a posture.

With the error e of the pose, as a shift and a rotation vector, its Jacobian J by the joint
positions, and d = prefer - q, the step is the s that minimises

    |J s - e|^2 / l + |s - d|^2    with lower <= q + s <= upper and l = |e|^2 / 10

(Levenberg-Marquardt): s = d + J^T (J J^T + l I)^-1 (e - J d). What the pose leaves free moves to
the preferred posture; where a joint comes to its limit, the others make up for it. J leaves out
that corrections of joints change with q, which costs a thousandth of the error each round.
"""

from dataclasses import dataclass
from typing import Any, Literal

import casadi as ca

from .pose_model import PoseModel

Goal = Literal["pose", "point"]
"""What of the target's pose counts: all, or its origin."""
MAX_STEP = 0.5
"""Largest step of a joint [rad, m]."""
MAX_PULL = 0.3
"""Largest part of it that the preferred posture asks for [rad, m]."""
DAMPING, LEAST_DAMPING = 0.1, 1e-12
"""l as a share of |e|^2; the least one keeps the matrix invertible at singular configurations."""


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
    """Return a step of a tool on a joint's child link toward a pose or point, without limits."""
    m = model.q.numel()
    tool, target, prefer = (ca.SX.sym(*of) for of in (("tool", 12), ("target", 12), ("prefer", m)))
    R, p = model.frames[joint]
    (R_tool, p_tool), (R_target, p_target) = _parts(tool), _parts(target)
    point = p + R @ p_tool
    slopes = model.by_corrected(joint, point)[:, :m]
    shift = p_target - point
    e, angle = shift, ca.SX(0)
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
    q, J, e, change = step.symbols["q"], step.jacobian, step.error, step.change
    least, most = ca.fmax(lower - q, -MAX_STEP), ca.fmin(upper - q, MAX_STEP)
    pull = _pull(q, step.symbols["prefer"], e)
    inside = ca.fmax(ca.fmin(change, most), least)
    free = inside == change
    freed = J * ca.repmat(free.T, e.numel(), 1)
    change = _damped(freed, J, e, free * pull + (1 - free) * inside)
    return ca.fmax(ca.fmin(change, most), least)


def _pull(q: Any, prefer: Any, e: Any) -> Any:
    """Return the step that a preferred posture asks for, where there are joints to spare."""
    m = q.numel()
    return ca.fmax(ca.fmin(prefer - q, MAX_PULL), -MAX_PULL) if m > e.numel() else ca.SX.zeros(m)


def _damped(freed: Any, J: Any, e: Any, moves: Any) -> Any:
    """Return a step: some moves, and the damped one of free joints for what these leave."""
    damping = (DAMPING * ca.dot(e, e) + LEAST_DAMPING) * ca.SX.eye(e.numel())
    return moves + freed.T @ _solved(freed @ freed.T + damping, e - J @ moves)


def _parts(pose: Any) -> tuple[Any, Any]:
    """Return the rotation and the translation of a pose written as the rows of [R | p]."""
    matrix = ca.reshape(pose, 4, 3).T
    return matrix[:, :3], matrix[:, 3]


def _turn(R: Any, target: Any) -> tuple[Any, Any]:
    """Return the rotation vector from one rotation to another, and its length [rad]."""
    E = target @ R.T
    sines = ca.vertcat(E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]) / 2
    sine = ca.sqrt(ca.dot(sines, sines) + 1e-32)  # of a turn of pi the axis is lost, not the angle
    angle = ca.atan2(sine, (ca.trace(E) - 1) / 2)
    return sines * (angle / sine), angle


def _solved(A: Any, b: Any) -> Any:
    """Return A^-1 b for a symmetric positive definite A (Cholesky)."""
    n = b.numel()
    L = ca.SX.zeros(n, n)
    for i in range(n):
        for j in range(i + 1):
            rest = A[i, j] - sum(L[i, k] * L[j, k] for k in range(j))
            L[i, j] = ca.sqrt(rest) if i == j else rest / L[j, j]
    y: list[Any] = []
    for i in range(n):
        y.append((b[i] - sum(L[i, k] * y[k] for k in range(i))) / L[i, i])
    for i in reversed(range(n)):
        y[i] = (y[i] - sum(L[k, i] * y[k] for k in range(i + 1, n))) / L[i, i]
    return ca.vertcat(*y)

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
FREED = 3
"""Times that joints are taken to their limits, and the others make up for it."""


@dataclass(frozen=True)
class NewtonStep:
    """Expressions of one step, and their symbols; poses are rows of [R | p], 12 numbers."""

    symbols: dict[str, Any]
    """``tool`` on the link and ``target``, shape (12,); limits ``lower`` and ``upper``, positions
    ``q`` and the posture ``prefer`` to stay near, shape (m,) [rad]."""
    left: Any
    """Distance [m] and angle [rad] that are left at q, shape (2,)."""
    change: Any
    """The step, shape (m,) [rad]."""


def newton_step(model: PoseModel, joint: int, goal: Goal, *, limited: bool = True) -> NewtonStep:
    """Return one step toward a pose of a tool on a joint's child link.

    Args:
        model: The robot's.
        joint: Index of the chain's joint.
        goal: What of the pose counts.
        limited: Without, the step may be too long or leave the limits: for a third of the work.
    """
    m = model.q.numel()
    tool, target = ca.SX.sym("tool", 12), ca.SX.sym("target", 12)
    lower, upper, prefer = (ca.SX.sym(name, m) for name in ("lower", "upper", "prefer"))
    R, p = model.frames[joint]
    (R_tool, p_tool), (R_target, p_target) = _parts(tool), _parts(target)
    point = p + R @ p_tool
    slopes = model.by_corrected(joint, point)[:, :m]
    shift = p_target - point
    e, angle = shift, ca.SX(0)
    if goal == "pose":
        turn, angle = _turn(R @ R_tool, R_target)
        e = ca.vertcat(shift, turn)
    rows = e.numel()
    J = slopes[:rows, :]
    pull = ca.fmax(ca.fmin(prefer - model.q, MAX_PULL), -MAX_PULL) if m > rows else ca.SX.zeros(m)
    damping = (DAMPING * ca.dot(e, e) + LEAST_DAMPING) * ca.SX.eye(rows)
    least = ca.fmax(lower - model.q, -MAX_STEP)
    most = ca.fmin(upper - model.q, MAX_STEP)
    free, fixed = ca.SX.ones(m), ca.SX.zeros(m)
    change = fixed
    for _ in range(FREED if limited else 1):
        moves = fixed + free * pull
        freed = J * ca.repmat(free.T, rows, 1)
        change = moves + freed.T @ _solved(freed @ freed.T + damping, e - J @ moves)
        if limited:
            inside = ca.fmax(ca.fmin(change, most), least)
            passes = free * (inside != change)
            fixed, free, change = fixed + passes * inside, free * (1 - passes), inside
    left = ca.vertcat(ca.norm_2(shift), angle)
    symbols = {"tool": tool, "lower": lower, "upper": upper}
    return NewtonStep(symbols | {"q": model.q, "target": target, "prefer": prefer}, left, change)


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

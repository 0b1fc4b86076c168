"""Configurations that hold one pose of the tool: the null space of a redundant arm."""

import numpy as np
import pinocchio as pin

from ...solver.robot import SimulationError
from .controller import ArmModel, Pose, pose_error

MARGIN = 0.1
"""Least distance of joints from their limits [rad]."""
STEP = 0.02
"""Between neighbours on a self-motion, as the norm of the change of all joints [rad]."""


def pose_above(point: np.ndarray) -> Pose:
    """Return the pose of a tool that points straight down, its tip at a point."""
    return pin.SE3(np.diag([1.0, -1.0, -1.0]), np.asarray(point, dtype=float))


def reach(model: ArmModel, q: np.ndarray, pose: Pose) -> np.ndarray:
    """Return the configuration nearest to q, by Newton steps, that puts the tool at a pose."""
    for _ in range(60):
        now, J = model.linearise(q)
        error = pose_error(pose, now)
        if np.linalg.norm(error) < 1e-11:
            return q
        dq = J.T @ np.linalg.solve(J @ J.T + 1e-9 * np.eye(6), error)
        q = q + dq * min(1.0, 0.3 / max(float(np.abs(dq).max()), 1e-12))
    where = [round(float(x), 3) for x in pose.translation]
    raise SimulationError(f"the arm cannot reach {where} from where it is")


def self_motion(model: ArmModel, q: np.ndarray, pose: Pose) -> np.ndarray:
    """Return evenly spaced configurations that hold a pose like q, over the elbow's range."""
    return np.array([*_walk(model, q, pose, -1.0)[::-1], q, *_walk(model, q, pose, +1.0)])


def _walk(model: ArmModel, q: np.ndarray, pose: Pose, sense: float) -> list[np.ndarray]:
    """Return the steps along the null vector of J until a joint is near its limit."""
    lower = np.asarray(model.model.lowerPositionLimit) + MARGIN
    upper = np.asarray(model.model.upperPositionLimit) - MARGIN
    walked: list[np.ndarray] = []
    before = sense * _null_vector(model, q)
    for _ in range(2000):
        along = _null_vector(model, q)
        before = along if along @ before > 0 else -along
        try:
            q = reach(model, q + STEP * before, pose)
        except SimulationError:
            break
        if np.any(q < lower) or np.any(q > upper):
            break
        walked.append(q)
    return walked


def _null_vector(model: ArmModel, q: np.ndarray) -> np.ndarray:
    """Return the unit joint velocity that leaves the tool where it is, shape (m,)."""
    vector = np.linalg.svd(model.linearise(q)[1])[2][-1]
    return vector * np.sign(vector[np.argmax(np.abs(vector))])


def stratified(count: int, generator: np.random.Generator) -> np.ndarray:
    """Return numbers in [0, 1), one drawn from each of ``count`` equal parts, shuffled."""
    return generator.permutation((np.arange(count) + generator.uniform(0, 1, count)) / count)


def elbow_angle(model: ArmModel, q: np.ndarray) -> float:
    """Return the turn of a 7-joint arm's elbow about the line shoulder-wrist, 0 where up [rad]."""
    pin.forwardKinematics(model.model, model.data, q)
    shoulder, elbow, wrist = (model.data.oMi[i].translation for i in (2, 4, 6))
    line = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    up = np.array([0.0, 0.0, 1.0]) - line * line[2]
    side = np.cross(line, up)
    return float(np.arctan2((elbow - shoulder) @ side, (elbow - shoulder) @ up))

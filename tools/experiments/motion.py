"""Motions of the tool, phase after phase, and what was measured in them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .controller import ImpedanceController, Pose
from .scene import TIME_STEP, Scene


@dataclass(frozen=True)
class Phase:
    """A stretch of a motion."""

    name: str
    duration: float
    """[s]."""
    goal: Callable[[float], Pose]
    """x_goal at a fraction of the duration, 0 to 1."""
    compensate: bool = False
    """True while the offset compensator is on."""


def shifted(pose: Pose, offset: np.ndarray) -> Pose:
    """Return a pose moved by an offset, shape (3,) [m]."""
    return pin.SE3(pose.rotation, pose.translation + offset)


def smooth(fraction: float) -> float:
    """Return how far a motion of minimum jerk has come after a fraction of its time."""
    return fraction**3 * (10 - 15 * fraction + 6 * fraction**2)


def move(name: str, duration: float, start: Pose, end: Pose) -> Phase:
    """Return a phase along a straight line, at rest at both ends (minimum jerk)."""
    turn = pin.log3(end.rotation @ start.rotation.T)
    way = end.translation - start.translation

    def goal(fraction: float) -> Pose:
        s = smooth(fraction)
        return pin.SE3(pin.exp3(s * turn) @ start.rotation, start.translation + s * way)

    return Phase(name, duration, goal)


def hold(name: str, duration: float, pose: Pose, *, compensate: bool = False) -> Phase:
    """Return a phase that stays at a pose."""
    return Phase(name, duration, lambda _: pose, compensate)


RECORD_EVERY = 5
"""Control steps from one row of a log to the next."""
ROWS_PER_SECOND = round(1 / (RECORD_EVERY * TIME_STEP))


@dataclass(frozen=True)
class Log:
    """A motion as it went, 200 rows a second."""

    phase: tuple[str, ...]
    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    tip: np.ndarray
    """True position of the tip, shape (N, 3) [m]."""
    force: np.ndarray
    """Contact force on the tool, shape (N, 3) [N]."""
    offset: np.ndarray
    """The compensator's force and torque at the tool, shape (N, 6) [N, N m]."""

    def during(self, *names: str) -> np.ndarray:
        """Return the rows of phases."""
        return np.array([i for i, phase in enumerate(self.phase) if phase in names])

    def forces(self, *names: str) -> np.ndarray:
        """Return the contact force's magnitude in phases, row by row, shape (N,) [N]."""
        return np.linalg.norm(self.force[self.during(*names)], axis=1)


def run(scene: Scene, controller: ImpedanceController, phases: Sequence[Phase]) -> Log:
    """Move the arm through phases, and record it; the last row of each phase is kept."""
    names: list[str] = []
    rows: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []
    q, dq = scene.data.qpos, scene.data.qvel
    for phase in phases:
        count = round(phase.duration / TIME_STEP)
        for step in range(1, count + 1):
            goal = phase.goal(step / count)
            torque = controller.torque(goal, q, dq, TIME_STEP, compensate=phase.compensate)
            scene.step(torque)
            if (count - step) % RECORD_EVERY == 0:
                names.append(phase.name)
                rows.append((q.copy(), scene.tip, scene.contact_force(), controller.offset))
    q_rows, tips, forces, offsets = (np.array(column) for column in zip(*rows, strict=True))
    return Log(tuple(names), q_rows, tips, forces, offsets)

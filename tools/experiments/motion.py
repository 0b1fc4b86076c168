"""Motions of the tool, phase after phase, and what was measured; the arm at its table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import pinocchio as pin

from ...solver.identification.robot import Robot
from ...solver.poses import SimulationError
from .controller import WINDOW, ArmModel, ImpedanceController, Pose, pose_error
from .results import Insertion, Motion, Retracing
from .scene import TIME_STEP, Scene, urdf_of


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


def move(
    name: str,
    duration: float,
    start: Pose,
    end: Pose,
) -> Phase:
    """Return a phase along a straight line, at rest at both ends (minimum jerk)."""
    turn = pin.log3(end.rotation @ start.rotation.T)
    way = end.translation - start.translation

    def goal(fraction: float) -> Pose:
        s = smooth(fraction)
        return pin.SE3(pin.exp3(s * turn) @ start.rotation, start.translation + s * way)

    return Phase(name, duration, goal)


def hold(
    name: str,
    duration: float,
    pose: Pose,
    *,
    compensate: bool = False,
) -> Phase:
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
        return np.flatnonzero(np.isin(self.phase, names))

    def forces(self, *names: str) -> np.ndarray:
        """Return the contact force's magnitude in phases, row by row, shape (N,) [N]."""
        return np.linalg.norm(self.force[self.during(*names)], axis=1)


def run(
    scene: Scene,
    controller: ImpedanceController,
    phases: Sequence[Phase],
) -> Log:
    """Move the arm through phases, and record it; the last row of each phase is kept."""
    names: list[str] = []
    rows: list[tuple[np.ndarray, ...]] = []
    q = scene.data.qpos
    dq = scene.data.qvel
    for phase in phases:
        count = round(phase.duration / TIME_STEP)
        for step in range(1, count + 1):
            goal = phase.goal(step / count)
            torque = controller.torque(
                goal,
                q,
                dq,
                TIME_STEP,
                compensate=phase.compensate,
            )
            scene.step(torque)
            if (count - step) % RECORD_EVERY == 0:
                names.append(phase.name)
                force = scene.contact_force()
                rows.append((q.copy(), scene.tip, force, controller.offset))
    return Log(tuple(names), *map(np.array, zip(*rows, strict=True)))


MARGIN = 0.1
"""Least distance of joints from their limits [rad]."""
STEP = 0.02
"""Between neighbours on a self-motion, as the norm of the change of all joints [rad]."""
MOST_STEPS = 60
"""Newton steps to a pose."""
LARGEST_STEP = 0.3
"""Change of a joint in one of them, at most [rad]."""
REACHED = 1e-11
"""Norm of the error at which a pose is reached [m, rad]."""


def pose_above(point: np.ndarray) -> Pose:
    """Return the pose of a tool that points straight down, its tip at a point."""
    return pin.SE3(np.diag([1.0, -1.0, -1.0]), np.asarray(point, dtype=float))


def reach(
    model: ArmModel,
    q: np.ndarray,
    pose: Pose,
) -> np.ndarray:
    """Return the configuration nearest to q, by Newton steps, that puts the tool at a pose."""
    for _ in range(MOST_STEPS):
        now, J = model.linearise(q)
        error = pose_error(pose, now)
        if np.linalg.norm(error) < REACHED:
            return q
        damped = J @ J.T + 1e-9 * np.eye(6)
        dq = J.T @ np.linalg.solve(damped, error)
        largest = max(float(np.abs(dq).max()), 1e-12)
        q = q + dq * min(1.0, LARGEST_STEP / largest)
    where = [round(float(x), 3) for x in pose.translation]
    raise SimulationError(f"the arm cannot reach {where} from where it is")


def _walk(
    model: ArmModel,
    q: np.ndarray,
    pose: Pose,
    sense: float,
) -> list[np.ndarray]:
    """Return the steps of a self-motion, along the null vector of J, until a limit is near."""
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
    _, J = model.linearise(q)
    *_, Vt = np.linalg.svd(J)
    vector = Vt[-1]
    largest = vector[np.argmax(np.abs(vector))]
    return vector * np.sign(largest)


def stratified(count: int, generator: np.random.Generator) -> np.ndarray:
    """Return numbers in [0, 1), one drawn from each of ``count`` equal parts, shuffled."""
    numbers = np.arange(count) + generator.uniform(0, 1, count)
    return generator.permutation(numbers / count)


def elbow_angle(model: ArmModel, q: np.ndarray) -> float:
    """Return the turn of a 7-joint arm's elbow about the line shoulder-wrist, 0 where up [rad]."""
    pin.forwardKinematics(model.model, model.data, q)
    shoulder, elbow, wrist = [model.data.oMi[k].translation for k in (2, 4, 6)]
    line = unit(wrist - shoulder)
    up = np.array([0.0, 0.0, 1.0]) - line * line[2]
    arm = elbow - shoulder
    return float(np.arctan2(arm @ np.cross(line, up), arm @ up))


def unit(vector: np.ndarray) -> np.ndarray:
    """Return the unit vector of a direction."""
    return vector / np.linalg.norm(vector)


READY = np.radians([0, -45, 0, -135, 0, 90, 45])
"""A Panda's usual posture, elbow up."""
START_ASIDE = 0.02
"""Largest distance of a start to each side of the first goal [m]; as far and more above."""
Result = TypeVar("Result", Insertion, Retracing)


@dataclass(frozen=True)
class Trial(Generic[Result]):
    """One trial: the motion, and what came of it."""

    log: Log
    result: Result


class Cell:
    """A true arm, the model that its controller is given, and the table; hole in metres."""

    def __init__(self, arm: Robot, urdf: bytes, hole: float | None = None) -> None:
        # The arm's true kinematics: what hands feel and eyes see. The controller never does.
        self.truth = ArmModel(urdf_of(arm), arm.joint_names, arm.tip)
        self.model = ArmModel(urdf, arm.joint_names, arm.tip)
        self.scene = Scene(arm, hole)

    def guide(self, point: np.ndarray) -> np.ndarray:
        """Return the configuration, tool upright and elbow up, that puts the true tip there."""
        return reach(self.truth, READY, pose_above(point))

    def start(
        self,
        point: np.ndarray,
        fraction: float,
        generator: np.random.Generator,
    ) -> np.ndarray:
        """Return a configuration near and above a point, from 0 to 1 of the elbow's range."""
        middle = self.guide(point)
        on, back = [
            _walk(self.truth, middle, pose_above(point), s) for s in (1.0, -1.0)
        ]
        postures = [*back[::-1], middle, *on]  # evenly spaced, over the elbow's range
        posture = postures[int(fraction * len(postures))]
        direction = generator.uniform([-1, -1, 0.5], [1, 1, 1.5])
        start = pose_above(point + START_ASIDE * direction)
        return reach(self.truth, posture, start)

    def perform(
        self,
        start: np.ndarray,
        goal: Pose,
        then: Sequence[Phase],
        touching: Sequence[str],
    ) -> tuple[Log, Motion]:
        """Go to a goal, compensated there, and on; return the log and what was measured."""
        self.scene.reset(start)
        approach = move("approach", 3.0, self.model.pose(start), goal)
        compensation = hold("compensate", WINDOW, goal, compensate=True)
        controller = ImpedanceController(self.model)
        log = run(self.scene, controller, [approach, compensation, *then])
        forces = log.forces(*touching)
        motion = Motion(
            elbow=elbow_angle(self.truth, start),
            force=float(forces.mean()),
            peak_force=float(forces.max()),
        )
        return log, motion

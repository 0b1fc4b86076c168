"""From poses to joint positions on every shipped arm: how many are reached, and what a pose costs.

    python benchmarks/command.py [--robots panda ur5e] [--poses 1000]

Arms are simulated with elasticity and transmission error. Each pose is that of random joint
positions within the limits, so it can be reached; the start is off by up to so much in each joint,
or the middle of the ranges. A solution counts where the pose is right to 1e-9 m and rad: from that
start alone, and with new starts. Rounds are the 99th percentile where the Jacobian's smallest
singular value is above 0.01. `command` has these new starts: the second number of each pair is its
own. Times are CPU times of a batch from that start alone, a pose, the least of three, and in units
of Pinocchio's computeJointJacobians of the rigid chain, measured in between. Beside it stand, where
they are installed, Pinocchio's own inverse kinematics (the damped loop of its documentation) and
that of the Robotics Toolbox (ik_LM, written in C), pose by pose on the rigid chain, from 0.1 rad.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time

import numpy as np
from worlds import realistic_flaws

from mukca.solver.calibration import FullModel
from mukca.solver.identification.data import Pose, kabsch_rotation
from mukca.solver.identification.robot import (
    Origin,
    load_robot,
    shipped_robots,
    workspace,
)
from mukca.solver.poses import PoseSolver
from mukca.tools.simulation import perturb, truth_of

STARTS = (0.02, 0.1, 0.5, None)
"""How far a start is off in each joint [rad]; None for the middle of the ranges."""


def simulated(name: str) -> FullModel:
    robot, generator = load_robot(name), np.random.default_rng(0)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    return FullModel(truth_of(robot, arm, realistic_flaws(robot, generator).deflection))


def starts(model: FullModel, q: np.ndarray, off: float | None) -> np.ndarray:
    robot, generator = model.robot, np.random.default_rng(1)
    if off is not None:
        return np.clip(
            q + generator.uniform(-off, off, q.shape), robot.lower, robot.upper
        )
    middle = (np.maximum(robot.lower, -np.pi) + np.minimum(robot.upper, np.pi)) / 2
    return np.tile(middle, (len(q), 1))


def right(model: FullModel, found: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return which joint positions put the flange at its pose, within the limits."""
    inside = np.all((found >= model.robot.lower) & (found <= model.robot.upper), axis=1)
    off = np.zeros(len(found))
    off[inside] = np.abs(model.flange(found[inside]) - poses[inside]).max(axis=(1, 2))
    return inside & (off < 1e-9)


def measure(model: FullModel, q: np.ndarray) -> list[str]:
    poses = model.flange(q)
    targets = poses[:, :3].reshape(-1, 12)
    regular = np.linalg.svd(model.jacobian(q), compute_uv=False)[:, -1] > 0.01
    solver: PoseSolver = model.calibrated.solver("pose")
    for off in STARTS:
        # What it computes with is made now.
        solver.solve(targets, starts(model, q, off))
    words: list[str] = []
    for off in STARTS:
        near = starts(model, q, off)
        alone = solver.solve(targets, near)
        spent, unit = 1.0, 1.0
        for _ in range(3):
            begin = time.process_time()
            solver.solve(targets, near)
            spent = min(spent, (time.process_time() - begin) / len(q))
            unit = min(unit, jacobian_time(model, q))
        searched = solver.search(targets, near)
        reached = right(model, alone.positions, poses)
        rounds = np.percentile(alone.rounds[reached & regular], 99)
        found = right(model, searched.positions, poses).sum()
        words.append(
            f"{reached.sum():5d} {found:5d} {rounds:4.0f} {1e6 * spent:5.0f} {spent / unit:4.0f}"
        )
    return words


def jacobian_time(model: FullModel, q: np.ndarray) -> float:
    """Return the time of Pinocchio's Jacobians of one pose [s]; not a number without it."""
    try:
        import pinocchio as pin
    except ImportError:
        return np.nan
    arm = pin.buildModelFromXML(model.calibrated.urdf().decode())
    data = arm.createData()
    rows = [pin.neutral(arm) for _ in q] if arm.nq != q.shape[1] else list(q)
    begin = time.process_time()
    for row in rows:
        pin.computeJointJacobians(arm, data, row)
    return (time.process_time() - begin) / len(q)


def pinocchio(model: FullModel, q: np.ndarray) -> str:
    """Return how its own inverse kinematics does from 0.1 rad, and its time."""
    try:
        import pinocchio as pin
    except ImportError:
        return "  (pinocchio is not installed)"
    arm = pin.buildModelFromXML(model.calibrated.urdf().decode())
    data, flange = arm.createData(), model.robot.ball_joint.parent
    if arm.nq != q.shape[1]:
        return "  (pinocchio: joints without end, or beside the chain)"
    frame, reached = arm.getFrameId(flange), 0
    begin = time.process_time()
    for row, start in zip(q, starts(model, q, 0.1), strict=True):
        pin.framesForwardKinematics(arm, data, row)
        goal, now = data.oMf[frame].copy(), start.copy()
        for _ in range(100):
            pin.framesForwardKinematics(arm, data, now)
            error = pin.log(data.oMf[frame].actInv(goal)).vector
            if np.abs(error).max() < 1e-9:
                inside = (now >= arm.lowerPositionLimit) & (
                    now <= arm.upperPositionLimit
                )
                reached += bool(inside.all())
                break
            J = pin.computeFrameJacobian(arm, data, now, frame)
            now = now + J.T @ np.linalg.solve(J @ J.T + 1e-12 * np.eye(6), error)
    spent = (time.process_time() - begin) / len(q)
    return f" {reached:5d} {1e6 * spent:6.0f}"


def toolbox(model: FullModel, q: np.ndarray) -> str:
    """Return how Peter Corke's robotics toolbox, whose solver is C, does from 0.1 rad."""
    try:
        from roboticstoolbox import ET, ETS
    except ImportError:
        return "  (roboticstoolbox is not installed)"
    ets = ETS()
    joints = model.robot.joints[:-1]
    for joint, origin in zip(joints, model.calibrated.origins[:-1], strict=True):
        ets *= ET.SE3(Pose.of(Origin.of(origin)).matrix)
        if joint.actuated:
            to_z = np.eye(4)
            to_z[:3, :3] = kabsch_rotation(
                np.eye(3)[2:], np.array([joint.axis]), np.ones(1)
            )
            moves = ET.tz() if joint.type == "prismatic" else ET.Rz()
            ets *= ET.SE3(to_z) * moves * ET.SE3(to_z.T)
    ets.qlim = np.array([model.robot.lower, model.robot.upper]).clip(-10, 10)
    poses, reached = [ets.fkine(row).A for row in q], 0
    begin = time.process_time()
    for pose, start in zip(poses, starts(model, q, 0.1), strict=True):
        found = ets.ik_LM(
            pose, q0=start, ilimit=100, slimit=1, tol=1e-18, joint_limits=True
        )
        reached += bool(found.success)
    spent = (time.process_time() - begin) / len(q)
    return f" {reached:5d} {1e6 * spent:6.0f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", nargs="+", default=list(shipped_robots()))
    parser.add_argument("--poses", type=int, default=1000)
    arguments = parser.parse_args()
    heads = " |".join(
        f"{'middle' if off is None else f'{off} rad':>11s} {'+new':>4s} rds    us / J"
        for off in STARTS
    )
    print(f"{'':10s}{heads} | pinocchio's us | toolbox's us")
    for name in arguments.robots:
        model = simulated(name)
        q = workspace(model.robot, arguments.poses, 1)
        q = np.clip(q, model.robot.lower, model.robot.upper)
        parts = [*measure(model, q), pinocchio(model, q), toolbox(model, q)]
        print(f"{name:10s}{' | '.join(parts)}", flush=True)


if __name__ == "__main__":
    main()

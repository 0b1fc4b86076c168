"""Frames on simulated arms whose truth is known: exactness, intervals, and two arms face to face.

    python benchmarks/frames.py [--draws 50]

1. Without noise, every shipped robot: the ball in an instrument's frame, in a table's, in an
   anchored base, and one tool seen from another's, by errors in mm.
2. With 0.1 mm of noise: how often stated intervals hold the truth (68.3 and 95.0 %).
3. Two Pandas 1.2 m apart, 12 + 12 samples at shared placements: error of tool against tool.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mukca.solver.auto.arms import Arms
from mukca.solver.auto.between import between
from mukca.solver.auto.estimation import estimate_all
from mukca.solver.auto.extended_model import extend
from mukca.solver.auto.posterior import World
from mukca.solver.data.frames import IDENTITY, Pose, turn
from mukca.solver.data.known import SocketAt
from mukca.solver.data.measurements import measure
from mukca.solver.data.observe import Recorded, observe_all
from mukca.solver.robot.kinematics import BallModel, workspace
from mukca.solver.robot.parameters import choose_parameters
from mukca.solver.robot.urdf import Robot, load_robot, shipped_robots
from mukca.tools.simulated_arms import Base, perturb, reachable_bases, record
from mukca.tools.simulated_worlds import (
    measured_points,
    random_pose,
    recorded_by_both,
    sockets_seen,
)

FACING = Pose(turn(np.array([0.0, 0.0, np.pi])), np.array([1.2, 0.0, 0.0]))
PLACES = ((0.6, 0.0, 0.15), (0.55, 0.35, 0.3), (0.65, -0.35, 0.1))


def fit(arms: Sequence[Recorded], at: Sequence[SocketAt] = (), deviation: float = 3e-5) -> World:
    """Return the geometry of all arms, and the frames."""
    scene = observe_all(arms, sockets_at=at, deviation=deviation)
    models = [extend(arm.robot, choose_parameters(arm.robot)) for arm in arms]
    return estimate_all(Arms(tuple(models)), scene, joint_noise=False)


def balls(arm: Robot, q: np.ndarray) -> np.ndarray:
    return BallModel(arm, []).points(np.empty(0), q)


def in_frame(found: World, frame: Pose, arm: Robot, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of the ball's place in a frame over the workspace, and stated deviations."""
    q = workspace(arm, 40, 7)
    one = found.arms[0]
    points, J, _ = one.model.linearise(one.x, q, np.tile(0 * q, 3))
    slopes = np.zeros((len(q), 3, len(found.covariance)))
    slopes[:, :, found.own[0]] = J
    seen = points
    if name in found.frames:
        pose = found.frames[name]
        seen = pose.inverse().apply(points)
        begin = found.own[-1].stop + 6 * list(found.frames).index(name)
        slopes[:, :, begin : begin + 6] = -pose.slopes(seen)
        slopes = pose.rotation.T @ slopes
    variance = np.einsum("nij,jk,nik->ni", slopes, found.covariance, slopes)
    return seen - frame.inverse().apply(balls(arm, q)), np.sqrt(variance)


def one_arm(robot: Robot, use: str, seed: int, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Return errors and stated deviations of one use by one arm."""
    generator = np.random.default_rng(seed)
    arm = perturb(robot, generator, 2e-3, 5e-3)
    frame = IDENTITY if use == "base" else random_pose(generator, 0.5)
    if use == "instrument":
        points = measured_points(arm, frame, generator, noise=noise)
        found = fit([Recorded(robot, [measure(points, robot)])])
        return in_frame(found, frame, arm, use)
    bases = reachable_bases(arm, generator, 3)
    placements = [record(arm, b, generator, samples=12, noise=noise) for b in bases]
    measured = [measure(replace(p, distance=None), robot) for p in placements]
    deviation = max(noise / 2, 1e-7)
    at = sockets_seen(bases, frame, generator, noise=noise / 2, deviation=deviation, name=use)
    return in_frame(fit([Recorded(robot, measured)], at), frame, arm, use)


def two_arms(
    robots: Sequence[Robot], seed: int, noise: float, count: int, samples: int = 12
) -> tuple[float, float]:
    """Return the error of one tool seen from the other where they truly meet, and that stated."""
    generator = np.random.default_rng(seed)
    arms = [perturb(robot, generator, 2e-3, 5e-3) for robot in robots]
    bases = [
        Base(f"p{i}", np.array(place), np.array([np.cos(i), np.sin(i), 0.0]))
        for i, place in enumerate(PLACES[:count])
    ]
    poses = (IDENTITY, FACING)
    recorded = recorded_by_both(arms, poses, bases, generator, samples=samples, noise=noise)
    held = recorded_by_both(
        arms, poses, [_between(bases, generator) for _ in range(6)], generator, samples=4
    )
    found = fit(
        [
            Recorded(robot, [measure(p, robot) for p in own], name=name)
            for robot, own, name in zip(robots, recorded, "AB", strict=True)
        ],
        deviation=3e-5 if noise else 1e-7,
    )
    one = between(found, 1)
    off: list[np.ndarray] = []
    for a, b in zip(*held, strict=True):
        q = [p.positions for p in (a, b)]
        seen = [arm.predict(at, np.tile(0 * at, 3)) for arm, at in zip(found.arms, q, strict=True)]
        off.append(np.linalg.norm(one.pose.apply(seen[1]) - seen[0], axis=1))
    assert one.tools is not None
    return float(np.concatenate(off).mean()), one.tools


def _between(bases: Sequence[Base], generator: np.random.Generator) -> Base:
    """Return a base somewhere in the region of others."""
    centres = np.array([base.centre for base in bases])
    low, high = centres.min(axis=0), centres.max(axis=0)
    return replace(bases[0], name="held", centre=generator.uniform(low, high))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=50)
    draws = parser.parse_args().draws
    uses = ("instrument", "table", "base")
    print("exact: largest error in mm")
    for name in shipped_robots():
        robot = load_robot(name)
        try:
            errors = [np.abs(one_arm(robot, use, 1, 0.0)[0]).max() for use in uses]
        except Exception as error:  # a robot too short for the bases
            print(f"  {name:10s} {error}")
            continue
        words = "  ".join(f"{u} {1e3 * e:.1e}" for u, e in zip(uses, errors, strict=True))
        print(f"  {name:10s} {words}", flush=True)
    panda = load_robot("panda")
    print(f"  two arms: {1e3 * two_arms([panda, panda], 1, 0.0, 3)[0]:.1e}")
    for use in uses:
        z = [np.divide(*one_arm(panda, use, seed, 1e-4)).ravel() for seed in range(draws)]
        z = np.abs(np.concatenate(z))
        print(
            f"{use}: {draws} draws, within 1 sigma {100 * np.mean(z < 1):.1f} % (68.3), within "
            f"1.96 sigma {100 * np.mean(z < 1.96):.1f} % (95.0)",
            flush=True,
        )
    for count, samples in ((3, 12), (2, 12), (3, 30), (2, 30)):
        rows = [two_arms([panda, panda], s, 1e-4, count, samples) for s in range(draws // 5)]
        found, stated = 1e3 * np.mean(rows, axis=0)
        print(
            f"two Pandas, {count} placements of {samples} + {samples}: tool to tool "
            f"{found:.3f} mm on average, stated {stated:.3f} mm (rms)",
            flush=True,
        )


if __name__ == "__main__":
    main()

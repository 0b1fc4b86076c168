"""How calibrated.urdf alone does against the paper's geometry, near what was recorded and anywhere.

    python benchmarks/exported.py [--arms 40] [--seed 9000] [--rigid] [--step 0.25]

Simulated arms bend and turn unevenly as real ones do (unless --rigid). Each is trained on 10 + 10
and 30 + 30 configurations at one place, and 30 + 30 at three, and measured at three others. Poses
are random, unless --step says how far a timid hand moves each joint from one to the next; real
hands move them by some 0.8 rad. The error of a ratio is that of the samples held out: they are few,
too. Distances are those between random configurations, their median error by the paper's geometry,
by the URDF and by the full model.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from functools import partial

import numpy as np
from worlds import realistic_flaws

from mukca.solver.calibration import SolveOptions, fit_robots
from mukca.solver.identification.data import (
    STANDARD_LOAD,
    Measurement,
    measure,
)
from mukca.solver.identification.robot import BallModel, Robot, load_robot, workspace
from mukca.solver.poses import InverseKinematics
from mukca.solver.poses.inverse_kinematics import MAX_TILT
from mukca.solver.results import Measurements
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

ROBOTS = ("panda", "iiwa14", "ur5e", "gen3", "xarm7")
TRAINED = {"10 + 10": (10, 1), "30 + 30": (30, 1), "three times 30 + 30": (30, 3)}
Row = tuple[float, ...]
"""The paper's error [mm], the URDF's over that, and its standard error; then the errors of
distances by the paper's geometry, the URDF and the full model [mm]."""


class Timid(InverseKinematics):
    """A hand that moves the arm little from pose to pose."""

    def __init__(self, arm: Robot, step: float) -> None:
        super().__init__(arm)
        self.step = step

    def reach(
        self, points: np.ndarray, generator: np.random.Generator, rounds: int = 40
    ) -> np.ndarray:
        """Return poses as :meth:`InverseKinematics.reach` does, each near the one before."""
        led: list[np.ndarray] = []
        for point in points:
            near = self._near(led[-1], point, generator) if led else None
            led.append(
                super().reach(point[None], generator, rounds)[0]
                if near is None
                else near
            )
        return np.array(led)

    def _near(
        self, q: np.ndarray, point: np.ndarray, generator: np.random.Generator
    ) -> np.ndarray | None:
        """Return a pose some steps away; None if there is none, and the hand lets go."""
        for _ in range(6):
            start = q + generator.normal(0, self.step, (8, len(q)))
            start = start.clip(self.lower + 1e-3, self.upper - 1e-3)
            necks = self.ball_and_neck(start)[0][:, 3:]
            upright = necks[:, 2] < -np.cos(0.95 * MAX_TILT)
            targets = np.concatenate([np.tile(point, (8, 1)), necks], axis=1)[upright]
            found, arrived = self._follow(start[upright], targets)
            arrived &= np.abs(found - q).max(axis=1) < 4 * self.step
            if arrived.any():
                return found[arrived][0]
        return None


def distances(ball: np.ndarray, held_out: Measurement) -> np.ndarray:
    """Return how far each ball is from its socket's mean, shape (N,) [m]."""
    apart = [ball[rows] - ball[rows].mean(axis=0) for rows in held_out.slices]
    return np.linalg.norm(np.concatenate(apart), axis=1)


def draw(rigid: bool, step: float | None, seed: int) -> dict[str, Row]:
    """Return how one arm comes out, by what it was trained on."""
    robot, generator = (
        load_robot(ROBOTS[seed % len(ROBOTS)]),
        np.random.default_rng(seed),
    )
    arm = perturb(robot, generator, 2e-3, 5e-3)
    how = Imperfection(1e-4) if rigid else realistic_flaws(robot, generator)
    bases = reachable_bases(arm, generator, 6)
    guide = Timid(arm, step) if step else InverseKinematics(arm)

    def at(some: slice, samples: int) -> list[Measurement]:
        recorded = (
            record(arm, base, generator, samples=samples, imperfection=how, guide=guide)
            for base in bases[some]
        )
        return [measure(placement, robot) for placement in recorded]

    test, q = at(slice(3, 6), 30), workspace(robot, 800, seed=1)
    true_positions = how.deflection.true_positions(STANDARD_LOAD.at(robot, q))
    true = lengths(BallModel(arm, []).points(np.empty(0), true_positions))
    rows: dict[str, Row] = {}
    for name, (samples, places) in TRAINED.items():
        train = at(slice(places), samples)
        recordings = [Measurements(robot, train)]
        by = [SolveOptions(type_prior=("none",)), SolveOptions(method="paper")]
        fits = [fit_robots(recordings, options)[0].calibrated for options in by]
        urdf, paper = (
            np.concatenate(
                [distances(one.geometric_ball(m.positions), m) for m in test]
            )
            for one in fits
        )
        spread = float((urdf - paper).std() / len(paper) ** 0.5 / paper.mean())
        near = 1e3 * float(paper.mean()), float(urdf.mean() / paper.mean()), spread
        auto, by_paper = fits
        balls = (by_paper.ball(q), auto.geometric_ball(q), auto.ball(q))
        rows[name] = (
            *near,
            *(1e3 * float(np.median(abs(lengths(b) - true))) for b in balls),
        )
    return rows


def lengths(balls: np.ndarray) -> np.ndarray:
    """Return the distances between balls 0 and 1, 2 and 3, ..., shape (N / 2,) [m]."""
    return np.linalg.norm(balls[1::2] - balls[::2], axis=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=40)
    parser.add_argument("--seed", type=int, default=9000, help="of the first arm")
    parser.add_argument("--step", type=float, help="of a timid hand, per joint [rad]")
    parser.add_argument(
        "--rigid", action="store_true", help="arms that neither bend nor wobble"
    )
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    work = partial(draw, arguments.rigid, arguments.step)
    seeds = range(arguments.seed, arguments.seed + arguments.arms)
    draws = list(read_options(arguments).workers.map(work, seeds))
    print(
        f"{'trained on':24s}{'paper':>9s}  URDF/paper: mean median  worst  >1.001  >1.01   by 2 s"
        "  distances: paper  URDF  full"
    )
    for name in TRAINED:
        paper, ratio, spread, *anywhere = np.array([row[name] for row in draws]).T
        worse = [
            np.sum(ratio > 1.001),
            np.sum(ratio > 1.01),
            np.sum(ratio > 1 + 2 * spread),
        ]
        print(
            f"{name:24s}{paper.mean():9.3f}{ratio.mean():17.3f}{np.median(ratio):7.3f}"
            f"{ratio.max():7.3f}{worse[0]:8d}{worse[1]:7d}{worse[2]:9d}"
            + "".join(f"{one.mean():9.3f}" for one in anywhere)
        )


if __name__ == "__main__":
    main()

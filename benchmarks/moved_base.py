"""How much of the accuracy is left where the base moves while it is recorded, and who is told.

    python benchmarks/moved_base.py [--seeds 3] [--robots panda ...] [--faults none step:0.5 ...]
                                    [--order 0 1 0 1] [--distance 0.05]

A session is a simulated arm with realistic flaws, and 12 + 12 samples in the order 0 1 0 1 by
sixes. The base makes one step at a change of socket (`step:MM`), drifts evenly (`drift:MM`), or
goes to and fro slowly (`slow:MM`), by so much. Errors are means of the true errors of
distances between random poses of the workspace, their median over all arms [mm]; `told` counts the
arms of which a check or a note says that the base moved or drifted, `fitted` those whose fit holds
the movement.
"""

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from dataclasses import dataclass

import numpy as np
from worlds import realistic_flaws

import mukca
from mukca.recorder import Placement, Sample
from mukca.solver.identification.robot import workspace
from mukca.solver.results import CalibratedRobot
from mukca.tools.simulation import Session, lead, perturb, reachable_bases, with_faults

ROBOTS = ("panda", "ur5e", "iiwa14", "xarm7")
FAULTS = ("none", "step:0.5", "step:5", "drift:0.5", "slow:0.5")
EACH, PAUSE = 6, 30.0


@dataclass(frozen=True)
class Movement:
    """A base that moves while it is recorded."""

    kind: str
    size: float
    """[m]."""

    def shift(self, session: Session) -> np.ndarray:
        """Return by how much it moves the ball of each sample, shape (N, 3) [m]."""
        n = len(session.sockets)
        t, g = np.arange(n) / (n - 1), session.generator
        changes = np.flatnonzero(np.diff(session.sockets)) + 1
        course = {
            "none": 0 * t,
            "step": (np.arange(n) >= g.choice(changes)).astype(float),
            "drift": t,
            "slow": 0.5 * np.sin(2 * np.pi * (1.2 * t + g.uniform())),
        }[self.kind]
        away = g.normal(size=3)
        return np.outer(course, self.size * away / np.linalg.norm(away))


def one(
    name: str, seed: int, movement: Movement, arguments: argparse.Namespace
) -> tuple:
    """Return the error [mm], and whether the movement was told and is in the fit."""
    robot, generator = mukca.load_robot(name), np.random.default_rng([seed, 5])
    arm = perturb(robot, generator, 2e-3, 5e-3)
    how = realistic_flaws(robot, generator)
    base = reachable_bases(arm, generator, 1, arguments.distance)[0]
    sockets = np.repeat(arguments.order, EACH)
    read = lead(arm, np.array(base.sockets)[sockets], generator, how)
    read = with_faults(
        Session(arm, read, sockets, np.array(base.sockets), generator), [movement]
    )
    samples = tuple(
        Sample(tuple(q), k, number=i + 1, time=1e9 + PAUSE * i)
        for i, (q, k) in enumerate(zip(read.tolist(), sockets.tolist(), strict=True))
    )
    here = Placement("here", samples, robot.joint_names, arguments.distance)
    found = mukca.calibrate(robot, [here])
    truth = CalibratedRobot(arm, (), np.zeros(0), how.deflection)
    q = workspace(robot, 400)
    balls = [one.ball(q) for one in (truth, found.calibrated)]
    true, said = (np.linalg.norm(p[1::2] - p[::2], axis=1) for p in balls)
    codes = {d.code for d in found.document.checks or ()}
    error = 1e3 * float(np.mean(np.abs(said - true)))
    return error, bool(codes & {"moved", "drift", "movement"}), "movement" in codes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--robots", nargs="+", default=ROBOTS)
    parser.add_argument("--faults", nargs="+", default=FAULTS)
    parser.add_argument("--order", nargs="+", type=int, default=[0, 1, 0, 1])
    parser.add_argument("--distance", type=float, default=0.05)
    arguments = parser.parse_args()
    print(
        "| movement | error [mm] | quartiles | told | fitted |\n|---|---|---|---|---|"
    )
    for text in arguments.faults:
        kind, _, size = text.partition(":")
        movement = Movement(kind, 1e-3 * float(size or 0))
        rows = [
            one(name, seed, movement, arguments)
            for name in arguments.robots
            for seed in range(arguments.seeds)
        ]
        errors, told, fitted = zip(*rows, strict=True)
        low, middle, high = np.percentile(errors, [25, 50, 75])
        counts = f"{sum(told)} of {len(told)} | {sum(fitted)} of {len(fitted)}"
        print(
            f"| {text} | {middle:.2f} | {low:.2f} to {high:.2f} | {counts} |",
            flush=True,
        )


if __name__ == "__main__":
    main()

"""What fits with a held chain decide and state, on simulated arms: one row for each promise.

    python benchmarks/doubts.py [--robots panda ur5e so101] [--draws 5] [--rows moved]

Ten arms of five makers' types by default. Each is calibrated at two bases and tested at a third.
Then zeros of joints change, by random poses, 6 in each of two sockets; a tip is found by 8 touches,
a camera by 15 views. First and last joints are left out: their zeros are the base's and the
flange's own. How large a change shows depends on the arm: a small one with a noisy seat tells a
zero to milliradians. So zeros are off by so many milliradians, and by so many of the standard
deviations that the samples leave of each zero that they tell, 0.5 mrad at least. Of each row, so
many of so many. Errors of tips and cameras are the largest, in standard deviations as stated.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from partial import board, few, matrix
from worlds import TRANSLATION, TURN, realistic_flaws

import mukca
from mukca.solver.calibration import FullModel
from mukca.solver.identification.robot import Origin, turn
from mukca.solver.partial import CameraPose, Tool
from mukca.solver.results import CalibratedRobot
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

ARMS = [
    "panda",
    "fr3",
    "ur5e",
    "ur10e",
    "iiwa14",
    "iiwa7",
    "gen3",
    "gen3_lite",
    "xarm7",
    "lite6",
]
SIZES = (0.0, 5e-4, 1e-3, 2e-3)
"""Changes of a zero [rad]."""
BY_DEVIATIONS = (3.0, 5.0)
"""Changes of a zero by its standard deviation; smaller ones than 0.5 mrad may be wander."""
LOST = 5e-3
"""A zero that is lost before touches and views [rad]."""
BOARDS = (0.9, 0.97, 0.995, 1.005, 1.03, 1.1)
"""Sizes of a board by what is said of it; from 1 % on it is to be told."""
TIP = np.array([0.03, -0.02, 0.15])
CAMERA = matrix(turn(np.array([0.1, -0.2, 0.4])), np.array([0.05, -0.02, 0.06]))
Found = Tool | CameraPose
BOARD = matrix(np.eye(3), np.array([0.6, 0.0, -0.2]))


def lists() -> dict[str, list[Any]]:
    """Return empty lists by name."""
    return defaultdict(list)


@dataclass
class Tally:
    """Counts of each row, and its largest error."""

    counts: dict[str, list[bool]] = field(default_factory=lists)
    errors: dict[str, list[float]] = field(default_factory=lists)

    def add(self, other: "Tally") -> None:
        """Add what another one counted."""
        for name, told in other.counts.items():
            self.counts[name] += told
        for name, errors in other.errors.items():
            self.errors[name] += errors

    def lines(self) -> list[str]:
        """Return the rows of the table."""
        counts = [
            f"| {name} | {sum(told)} of {len(told)} | {100 * sum(told) / len(told):.0f} % |"
            for name, told in self.counts.items()
        ]
        return counts + [
            f"| {name} | {max(errors):.2f} | |" for name, errors in self.errors.items()
        ]


@dataclass(frozen=True)
class Simulated:
    """A simulated arm and its calibration."""

    arm: mukca.Robot
    how: Imperfection
    calibration: mukca.Calibration
    generator: np.random.Generator

    @property
    def inner(self) -> range:
        """Joints but the first and last."""
        return range(1, len(self.arm.joint_names) - 1)

    def samples(
        self, arm: mukca.Robot, count: int, how: Imperfection
    ) -> mukca.Placement:
        """Return samples at another base."""
        (base,) = reachable_bases(arm, self.generator, 1)
        return record(arm, base, self.generator, samples=count, imperfection=how)


def simulated(name: str, draw: int) -> Simulated:
    """Return an arm that bends and winds, calibrated."""
    robot, generator = mukca.load_robot(name), np.random.default_rng([7, draw])
    arm, how = (
        perturb(robot, generator, TRANSLATION, TURN),
        realistic_flaws(robot, generator),
    )
    bases = reachable_bases(arm, generator, 3)
    first, second, third = (
        record(arm, base, generator, imperfection=how) for base in bases
    )
    return Simulated(
        arm, how, mukca.calibrate(robot, [first, second], [third]), generator
    )


def moved(one: Simulated, tally: Tally) -> None:
    """Validate with a zero that changed: status 1 is right, but of none."""
    since = few(one.samples(one.arm, 30, one.how), 6, one.generator)

    def noticed(j: int, size: float) -> bool:
        names = one.arm.joint_names
        q = since.positions - size * np.eye(len(names))[j]
        placement = mukca.Placement.of_arrays(
            "since", q, since.sockets, names, distance=0.05
        )
        return mukca.what_changed(one.calibration, placement).verdict.exit_status == 1

    for size in SIZES:
        for j in one.inner if size else (0,):
            row = f"zero off by {1e3 * size:g} mrad, status 1"
            tally.counts[row].append(noticed(j, size))
    zeros = mukca.rezero(one.calibration, since).joints
    for factor in BY_DEVIATIONS:
        for j in one.inner:
            if zeros[j].told:
                row = f"zero off by {factor:g} of its deviations, status 1"
                size = max(factor * zeros[j].standard_deviation, SIZES[1])
                tally.counts[row].append(noticed(j, size))


def tips(one: Simulated, tally: Tally) -> None:
    """Find a tip with a zero that changed, and with a touch that is off."""
    ball = one.arm.ball_joint
    carried = replace(ball, origin=Origin.of([*TIP, *ball.origin.rpy]))
    arm = replace(one.arm, joints=(*one.arm.joints[:-1], carried))
    touched = one.samples(arm, 8, replace(one.how, noise=1e-4)).positions[:8]
    names, none = one.arm.joint_names, np.zeros(8, int)

    def found(q: np.ndarray) -> Found:
        return mukca.tool(
            one.calibration, mukca.Placement.of_arrays("t", q, none, names)
        )

    sound = found(touched)
    tally.counts["tip, nothing changed, status 3"].append(bool(sound.untold))
    for j in one.inner:
        lost = found(touched - LOST * np.eye(len(names))[j])
        tally.counts["tip, zero off by 5 mrad, told"].append(bool(lost.untold))
        tally.errors["tip, its shift by what is stated"].append(shift(lost, sound))
    for j in (one.inner[0], one.inner[-1]):
        q = touched.copy()
        q[3, j] += 0.06
        tally.counts["touch that is off, named alone"].append(
            [line.split(":")[0] for line in found(q).outliers] == ["touch 3"]
        )


def cameras(one: Simulated, tally: Tally) -> None:
    """Find a camera with a zero that changed, with boards of other sizes, by translations alone."""
    generator, names = one.generator, one.arm.joint_names
    near = one.samples(one.arm, 30, one.how)
    q = few(near, 8, generator).positions[:15]
    q = q + generator.normal(0, 0.15, q.shape)
    truth = FullModel(CalibratedRobot(one.arm, (), np.zeros(0), one.how.deflection))
    seen = np.linalg.inv(truth.flange(q) @ CAMERA) @ BOARD
    for B in seen:
        B[:3, :3] = turn(generator.normal(0, 1e-3, 3)) @ B[:3, :3]
        B[:3, 3] += generator.normal(0, 3e-4, 3)
    sound = mukca.handeye(one.calibration, board(q, list(seen)), "on-arm")
    tally.counts["camera, nothing changed, status 3"].append(bool(sound.untold))
    for j in one.inner:
        lost = q - LOST * np.eye(len(names))[j]
        result = mukca.handeye(one.calibration, board(lost, list(seen)), "on-arm")
        tally.counts["camera, zero off by 5 mrad, told"].append(bool(result.untold))
        tally.errors["camera, its shift by what is stated"].append(shift(result, sound))
    for size in BOARDS:
        scaled = seen.copy()
        scaled[:, :3, 3] *= size
        result = mukca.handeye(one.calibration, board(q, list(scaled)), "on-arm")
        told = any("if the board" in line for line in result.untold)
        wrong = abs(size - 1) > 0.01
        tally.counts[f"board {'' if wrong else 'not '}over 1 % wrong, told"].append(
            told
        )
        off = np.linalg.norm(np.array(result.frame.xyz) - sound.frame.xyz)
        tally.errors["camera, its shift by a wrong board [mm]"].append(1e3 * float(off))
    readings(one, q, seen, tally)
    translations(one, truth, tally)


def translations(one: Simulated, truth: FullModel, tally: Tally) -> None:
    """Find a camera by views between which the flange never turns: refused, or of status 3."""
    postures = one.samples(one.arm, 30, one.how).positions
    steps = one.generator.uniform(-0.04, 0.04, (15, 3))
    for start in postures:
        poses = np.tile(truth.flange(start), (15, 1, 1))
        poses[:, :3, 3] += steps
        try:
            q = truth.command(poses, near=start)
        except mukca.MukcaError:
            continue  # out of reach without a turn
        break
    else:
        return  # an arm of five joints has no such views
    seen = np.linalg.inv(truth.flange(q) @ CAMERA) @ BOARD
    seen[:, :3, 3] += one.generator.normal(0, 3e-4, (15, 3))
    try:
        told = bool(
            mukca.handeye(one.calibration, board(q, list(seen)), "on-arm").untold
        )
    except mukca.MukcaError:
        told = True
    tally.counts["camera by translations alone, no number"].append(told)


def readings(one: Simulated, q: np.ndarray, seen: np.ndarray, tally: Tally) -> None:
    """Write turns in other ways than the columns say, and count those that are named."""
    rows = board(q, list(seen))
    others = {
        "w first": [
            s.orientation[3:] + s.orientation[:3] for s in rows.samples if s.orientation
        ],
        "transposed": [
            (-s.orientation[0], -s.orientation[1], -s.orientation[2], s.orientation[3])
            for s in rows.samples
            if s.orientation
        ],
    }
    for word, turns in others.items():
        pairs = zip(rows.samples, turns, strict=True)
        wrong = replace(
            rows, samples=tuple(replace(s, orientation=r) for s, r in pairs)
        )
        named = ""
        try:
            mukca.handeye(one.calibration, wrong, "on-arm")
        except mukca.MukcaError as error:
            named = str(error)
        tally.counts["turns read otherwise, named"].append(word in named)


def shift(found: Found, sound: Found) -> float:
    """Return how far a place moved, in deviations that are stated, rms of its axes."""
    off = np.array(found.frame.xyz) - sound.frame.xyz
    return (
        float(off @ np.linalg.solve(np.array(found.frame.covariance), off) / 3) ** 0.5
    )


def tally_of(rows: Sequence[str], job: tuple[str, int]) -> Tally:
    """Return what one draw of an arm counts."""
    one, tally = simulated(*job), Tally()
    for row in rows:
        {"moved": moved, "tips": tips, "cameras": cameras}[row](one, tally)
    return tally


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", nargs="+", default=ARMS)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--rows", nargs="+", default=["moved", "tips", "cameras"])
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    draws = range(arguments.first, arguments.first + arguments.draws)
    jobs = [(name, draw) for draw in draws for name in arguments.robots]
    tally = Tally()
    work = partial(tally_of, arguments.rows)
    for part in read_options(arguments).workers.map(work, jobs):
        tally.add(part)
    print(f"| {', '.join(arguments.robots)}: {len(draws)} draws of each | | |")
    print("|---|---|---|")
    for line in tally.lines():
        print(line)


if __name__ == "__main__":
    main()

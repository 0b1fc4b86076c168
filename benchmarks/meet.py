"""Two simulated Pandas that meet by `command`: how far apart their balls truly are, and as stated.

    python benchmarks/meet.py [--draws 100] [--placements 3]

Each draw makes two arms that differ from their model, lets both record the same bases, or an
instrument measure both in one frame, and calibrates them together. The left one is then commanded
to where the right one's ball is, in the frame of that ball, at places that both know. The stated
error of tool against tool is a root mean square over such places, of all three axes; 95 of 100
meetings are to be within 1.61 of them, the 95th percentile of a length whose three coordinates are
alike, or 1.96 where it has one only.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from dataclasses import replace
from functools import partial

import numpy as np
from worlds import measured_points, recorded_by_both

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.data import IDENTITY, Pose
from mukca.solver.identification.robot import BallModel, Robot, turn
from mukca.solver.poses import InverseKinematics
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.parallel import Workers
from mukca.tools.simulation import Base, perturb

NAMES = ("left", "right")
POSES = (IDENTITY, Pose(turn(np.array([0.0, 0.0, np.pi])), np.array([1.2, 0.0, 0.0])))
PLACES = ((0.6, 0.0, 0.15), (0.55, 0.35, 0.3), (0.65, -0.35, 0.1), (0.58, 0.15, 0.2))
NOISE = 1e-4
MEETINGS = 4
"""Places where the arms of one draw meet."""


def recordings(
    arms: list[Robot], generator: np.random.Generator, count: int, instrument: bool
) -> dict[str, list[Placement]]:
    if instrument:
        tracker = Pose(turn(generator.uniform(-2, 2, 3)), np.array([0.5, 2.0, 0.3]))
        frames = [
            Pose(
                p.rotation.T @ tracker.rotation,
                p.inverse().apply(tracker.translation[None])[0],
            )
            for p in POSES
        ]
        rows = [
            [
                replace(
                    measured_points(arm, frame, generator, noise=NOISE), frame="tracker"
                )
            ]
            for arm, frame in zip(arms, frames, strict=True)
        ]
        return dict(zip(NAMES, rows, strict=True))
    bases = [
        Base(f"p{i}", np.array(place), np.array([np.cos(i), np.sin(i), 0.0]))
        for i, place in enumerate(PLACES[:count])
    ]
    return dict(
        zip(
            NAMES,
            recorded_by_both(arms, POSES, bases, generator, noise=NOISE),
            strict=True,
        )
    )


def meet(count: int, instrument: bool, seed: int) -> tuple[np.ndarray, float]:
    """Return distances between the true balls where they meet, and the stated error [m]."""
    panda, generator = mukca.load_robot("panda"), np.random.default_rng(seed)
    arms = [perturb(panda, generator, 2e-3, 5e-3) for _ in NAMES]
    rigid = ("compliance", "tilt", "transmission", "joint-noise")
    found = mukca.calibrate(
        dict.fromkeys(NAMES, panda),
        recordings(arms, generator, count, instrument),
        without=rigid,
    )
    stated = found.document.between["left_to_right"].tool_deviation
    shares = generator.dirichlet(np.ones(3), MEETINGS)
    places = shares @ np.array(PLACES[:3])
    near, at = (
        InverseKinematics(arm).reach(pose.inverse().apply(places), generator)
        for arm, pose in zip(arms, POSES, strict=True)
    )
    q = np.array(
        [
            found["left"].command(
                np.zeros(3), start, tool=panda.tip, frame=f"right/{panda.tip}", at=there
            )
            for start, there in zip(near, at, strict=True)
        ]
    )
    balls = [
        pose.apply(BallModel(arm, []).points(np.empty(0), rows))
        for arm, pose, rows in zip(arms, POSES, (q, at), strict=True)
    ]
    return np.linalg.norm(
        balls[0] - balls[1], axis=1
    ), np.nan if stated is None else stated


def report(words: str, found: list[tuple[np.ndarray, float]]) -> None:
    off, stated = (
        np.array([one for one, _ in found]),
        np.array([said for _, said in found]),
    )
    ratio = off / stated[:, None]
    print(
        f"{words}: {len(found)} draws, {off.size} meetings, {1e3 * np.mean(off):.3f} mm apart on "
        f"average, {1e3 * np.mean(off**2) ** 0.5:.3f} rms, stated {1e3 * stated.mean():.3f}; "
        f"within 1.61 of the stated {100 * np.mean(ratio < 1.614):.1f} %, within 1.96 "
        f"{100 * np.mean(ratio < 1.96):.1f} %",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--placements", type=int, default=3)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    workers: Workers = read_options(arguments).workers
    for instrument, words in (
        (False, f"{arguments.placements} bases"),
        (True, "an instrument"),
    ):
        job = partial(meet, arguments.placements, instrument)
        report(words, workers.map(job, range(arguments.draws)))


if __name__ == "__main__":
    main()

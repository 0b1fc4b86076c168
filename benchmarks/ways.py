"""Error at commanded points by each way to use a calibration, on every shipped arm.

    python benchmarks/ways.py [--robots panda ur5e] [--points 60] [--draws 3]

Simulated arms bend and turn unevenly as real ones do. Each is calibrated by two recordings, and the
ball is then commanded to points of the workspace: by the nominal URDF, by calibrated.urdf alone, by
calibrated.urdf at virtual joint positions, and by `command`. Where the base stands is not measured,
so a shift and turn of all points is taken off. Mean distances in mm over several such arms, since
one draw says little of a geometry that only two placements tell; points that a way does not reach
are left out for it.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import argparse

import numpy as np

import mukca
from mukca.solver.calibration import FullModel
from mukca.solver.identification.data import kabsch
from mukca.solver.identification.robot import shipped_robots, workspace

WAYS = ("nominal", "calibrated.urdf", "virtual joints", "command")


def commanded(model: FullModel, points: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Return joint positions, not a number where a point is not reached."""
    rows: list[np.ndarray] = []
    for point, start in zip(points, near, strict=True):
        try:
            rows.append(model.command(point, start, tool=model.robot.tip))
        except mukca.MukcaError:
            rows.append(np.full(near.shape[1], np.nan))
    return np.array(rows)


def readings(calibration: FullModel, virtual: np.ndarray) -> np.ndarray:
    """Return what the encoders read at virtual joint positions: their inverse, round by round."""
    q = virtual.copy()
    for row in q:
        wanted = row.copy()
        try:
            for _ in range(6):
                row += wanted - calibration.virtual_positions(row)
        except mukca.MukcaError:
            row[:] = np.nan
    return q


def errors(name: str, count: int, seed: int) -> list[float]:
    robot = mukca.load_robot(name)
    flaws = {"compliance": 5e-5, "tilt": 3e-5, "transmission": 2e-4}
    truth, placements = mukca.simulate_recordings(robot, 2, seed=seed, **flaws)
    found = mukca.calibrate(robot, placements)
    near = workspace(robot, count, seed)
    points = found.ball(near)
    by_urdf = commanded(found.geometric, points, near)
    ways = (
        commanded(found.nominal, points, near),
        by_urdf,
        readings(found, by_urdf),
        commanded(found, points, near),
    )
    means: list[float] = []
    for q in ways:
        some = np.isfinite(q).all(axis=1)
        if some.sum() < 4:
            means.append(np.nan)
            continue
        true = truth.ball(q[some])
        off = kabsch(true, points[some]).apply(true) - points[some]
        means.append(1e3 * float(np.linalg.norm(off, axis=1).mean()))
    return means


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", nargs="+", default=list(shipped_robots()))
    parser.add_argument("--points", type=int, default=60)
    parser.add_argument("--draws", type=int, default=3)
    arguments = parser.parse_args()
    print(f"{'':10s}" + "".join(f"{way:>17s}" for way in WAYS) + "   mm")
    for name in arguments.robots:
        seeds = range(1, 1 + arguments.draws)
        means = np.mean(
            [errors(name, arguments.points, seed) for seed in seeds], axis=0
        )
        print(f"{name:10s}" + "".join(f"{mean:17.3f}" for mean in means), flush=True)


if __name__ == "__main__":
    main()

"""A real arm against an instrument: held-out points of a UR5 under a laser tracker.

    python benchmarks/instrument.py POINTS --robot ur5.urdf --flange tool0 --ball 0 0 0.031

The points are split ten times at random: the default method, with its default settings, is fitted
to 120 of them, and judged on the other 80, as `mukca solve` does. The data are those of Paul Jacobi
(serial_robots_datasets on GitHub); published for them are 2.566 mm nominal, and 0.155 mm after a
kinematic calibration and a neural network, which were measured on the arm again.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import argparse
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.data import Measurement, measure
from mukca.solver.identification.robot import Robot
from mukca.solver.studies import HeldOut, misfit, within
from mukca.tools.cli import WorkerOptions, add_options, read_options

CHI_SQUARES = (3.506, 7.815)
"""What 68 % and 95 % of the squares of three numbers stay below."""


def split(points: Placement, trained: int, seed: int) -> tuple[Placement, Placement]:
    """Return a random part of the points, and the rest, each in the order measured."""
    order = np.random.default_rng(seed).permutation(len(points.samples))
    parts = (("train", order[:trained]), ("test", order[trained:]))
    train, test = (
        replace(
            points,
            name=name,
            files=(),
            samples=tuple(points.samples[i] for i in sorted(rows.tolist())),
        )
        for name, rows in parts
    )
    return train, test


def held_out(robot: Robot, points: Placement, trained: int, seed: int) -> list[float]:
    """Return mean errors of held-out points in mm, by solve and by validate."""
    train, test = split(points, trained, seed)
    calibration = mukca.calibrate(robot, train, test=test)
    summary = calibration.errors.summary.test
    again = calibration.validate(test).summary.test
    assert summary is not None and again is not None
    models = (
        summary.nominal,
        summary.ball_refitted,
        summary.loaded,
        summary.calibrated,
    )
    figures = [np.nan if m is None else m.mean_absolute_error for m in models]
    lengths = [
        1e3 * figure for figure in (*figures, again.calibrated.mean_absolute_error)
    ]
    return [*lengths, *shares_within(calibration, measure(test, robot, sockets=1))]


def shares_within(calibration: mukca.Calibration, measured: Measurement) -> list[float]:
    """Return the shares of points within the stated 68 % and 95 %, the frame refitted there.

    What is stated has the misfit of every other point, and is judged at the points between.
    """
    posterior, load = calibration.posterior, calibration.load
    samples = load.samples(calibration.robot, measured)
    parts = slice(0, None, 2), slice(1, None, 2)
    halves = [HeldOut(samples.only(part), measured.points[part]) for part in parts]
    factors = [misfit([(posterior, half)]) for half in halves]
    shares = [
        within(posterior, half, factor, CHI_SQUARES)
        for half, factor in zip(halves, factors[::-1], strict=True)
    ]
    return (100 * np.mean(shares, axis=0)).tolist()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("points", type=Path, help="folder with points.csv")
    parser.add_argument("--robot", required=True, help="URDF of the arm")
    parser.add_argument("--flange", help="the link that carries the reflector")
    parser.add_argument(
        "--ball", nargs=3, type=float, help="the reflector in that link [m]"
    )
    parser.add_argument("--splits", type=int, default=10)
    parser.add_argument(
        "--train", type=int, default=120, help="points to fit (default: 120)"
    )
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    robot = mukca.load_robot(
        arguments.robot, flange=arguments.flange, ball=arguments.ball
    )
    (points,) = mukca.read_placements(arguments.points)
    begin = time.perf_counter()
    work = partial(held_out, robot, points, arguments.train)
    rows = read_options(arguments).workers.map(work, range(arguments.splits))
    print(
        "mean held-out error in mm: nominal, ball refitted, URDF alone, calibrated, by validate;"
    )
    print("points within the stated 68 % and 95 %, in %")
    for seed, row in enumerate(rows):
        print(f"split {seed}: " + "  ".join(f"{value:.4f}" for value in row))
    print("mean:    " + "  ".join(f"{value:.4f}" for value in np.mean(rows, axis=0)))
    print(f"{arguments.splits} splits in {time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()

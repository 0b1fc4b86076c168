"""Joint error curves against the method without them, in the same run.

    python benchmarks/joint_curves.py points FOLDER --robot ur10 [--train 300 100] [--folds 5]
    python benchmarks/joint_curves.py sockets --robot ur10 --amplitude 3e-4 --placements 1 2 4
    python benchmarks/joint_curves.py none [--arms 20]
    python benchmarks/joint_curves.py growth --samples 200 1000 3000 12000
    python benchmarks/joint_curves.py cost FOLDER --robot ur10 [--samples 200]

`points` splits points or poses of an instrument: at random into a part to fit and the rest, or into
folds. `sockets` simulates arms with curves, 30 + 30 samples at each placement, and judges them at
three others; `none` simulates arms without curves, two placements each, and counts how often curves
are kept. `growth` times points of a simulated UR10. `cost` takes the processor's time of both by
turns on one thread, for so many points. Errors are means over held-out samples in mm.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import argparse
import re
import resource
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import mukca
from mukca.recorder import Placement, Sample
from mukca.solver.identification.robot import Robot, workspace

WITHOUT = ("curves",)


def parts_of(points: Placement, rows: np.ndarray) -> tuple[Placement, Placement]:
    """Return some of the points, and the rest."""
    chosen = set(rows.tolist())
    kept = [s for i, s in enumerate(points.samples) if i in chosen]
    rest = [s for i, s in enumerate(points.samples) if i not in chosen]
    train, test = (
        replace(points, name=name, files=(), samples=tuple(samples))
        for name, samples in (("train", kept), ("test", rest))
    )
    return train, test


def held_out(
    robot: Robot, train: object, test: object, **options: object
) -> tuple[float, str]:
    """Return the mean held-out error in mm, and the note on curves, after that in mrad of poses."""
    found = mukca.calibrate(robot, train, test=test, **options)
    assert found.errors.summary.test is not None
    metrics = found.errors.summary.test.calibrated
    turned = metrics.orientation_error
    angle = "" if turned is None else f"{1e3 * turned:.3f} mrad; "
    return 1e3 * metrics.mean_absolute_error, f"{angle}{_note(found)}"


def _note(found: mukca.Calibration) -> str:
    return next((n for n in found.document.choices or () if n.startswith("curves")), "")


def splits(
    count: int, arguments: argparse.Namespace
) -> Iterator[tuple[str, np.ndarray]]:
    order = np.random.default_rng(0).permutation(count)
    for k in range(arguments.folds):
        yield f"fold {k}", np.setdiff1d(order, order[k :: arguments.folds])
    for train in arguments.train:
        for seed in range(arguments.splits):
            drawn = np.random.default_rng(seed).permutation(count)[
                : -min(100, count // 5)
            ]
            yield f"{train} of {count}, draw {seed}", drawn[:train]


def points(robot: Robot, arguments: argparse.Namespace) -> None:
    (measured,) = mukca.read_placements(arguments.folder)
    for name, rows in splits(len(measured.samples), arguments):
        train, test = parts_of(measured, rows)
        plain, before = held_out(robot, train, test, without=WITHOUT)
        error, note = held_out(robot, train, test)
        words = f"without {plain:.4f} ({before}), with curves {error:.4f} ({note})"
        print(f"{name}: {words}", flush=True)


def sockets(robot: Robot, arguments: argparse.Namespace) -> None:
    for amplitude in arguments.amplitude:
        for count in arguments.placements:
            rows: list[tuple[float, float]] = []
            for seed in range(arguments.first, arguments.first + arguments.arms):
                _, data = mukca.simulate_recordings(
                    robot, count + 3, seed=seed, curves=amplitude, compliance=3e-5
                )
                train, test = data[:count], data[count:]
                plain, _ = held_out(robot, train, test, without=WITHOUT)
                rows.append((plain, held_out(robot, train, test)[0]))
            plain, error = np.mean(rows, axis=0)
            print(
                f"{1e3 * amplitude:.1f} mrad, {count} placements: without {plain:.3f}, with "
                f"{error:.3f}: {error / plain:.2f}; worst {max(b / a for a, b in rows):.2f}",
                flush=True,
            )


def none(arguments: argparse.Namespace) -> None:
    names, kept, most = ("panda", "ur5e", "iiwa14", "ur10"), 0, -np.inf
    for seed in range(arguments.arms):
        robot = mukca.load_robot(names[seed % len(names)])
        flaws = {"compliance": 5e-5, "tilt": 3e-5, "transmission": 1e-4}
        _, data = mukca.simulate_recordings(robot, 2 + seed % 3, seed=seed, **flaws)
        note = _note(mukca.calibrate(robot, data))
        gain = re.search(r"log evidence ([+-][0-9.]+)", note)
        most, kept = (
            max(most, float(gain[1]) if gain else most),
            kept + ("kept" in note),
        )
    print(
        f"{arguments.arms} arms without curves: kept {kept} times; evidence at most {most:+.1f}"
    )


def growth(robot: Robot, arguments: argparse.Namespace) -> None:
    truth, _ = mukca.simulate_recordings(robot, 1, seed=0, curves=3e-4)
    for count in arguments.samples:
        q = workspace(robot, count + 200, seed=1)
        balls = truth.ball(q) + np.random.default_rng(1).normal(0, 3e-5, (len(q), 3))
        rows = [
            Sample(tuple(a), socket=0, point=tuple(b))
            for a, b in zip(q.tolist(), balls.tolist(), strict=True)
        ]
        train, test = (
            Placement(name, tuple(own), robot.joint_names, frame="instrument")
            for name, own in (("train", rows[:count]), ("test", rows[count:]))
        )
        for options in ({"without": WITHOUT}, {}):
            begin = time.perf_counter()
            error, note = held_out(robot, train, test, **options)
            seconds = time.perf_counter() - begin
            most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
            words = f"{seconds:.1f} s, {error:.4f} mm, {most:.2f} GB so far"
            print(
                f"{count} points, {'without' if options else 'with curves'}: {words} {note}",
                flush=True,
            )


def cost(robot: Robot, arguments: argparse.Namespace) -> None:
    (measured,) = mukca.read_placements(arguments.folder)
    for count in arguments.samples:
        train, _ = parts_of(
            measured,
            np.random.default_rng(0).permutation(len(measured.samples))[:count],
        )
        seconds: list[list[float]] = []
        for _ in range(8):
            seconds.append([])
            for options in ({"without": WITHOUT}, {}):
                begin = time.process_time()
                mukca.calibrate(robot, train, **options)
                seconds[-1].append(time.process_time() - begin)
        each = np.array(seconds[1:])  # the first compiles
        least, ratios = each.min(axis=0), each[:, 1] / each[:, 0]
        print(
            f"{count} points: without {least[0]:.2f} s, with curves {least[1]:.2f} s: "
            f"{least[1] / least[0]:.2f} times; of pairs {np.median(ratios):.2f} times",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("points", "sockets", "none", "growth", "cost"))
    parser.add_argument("folder", type=Path, nargs="?", help="with points.csv")
    parser.add_argument("--robot", default="ur10")
    parser.add_argument("--flange")
    parser.add_argument("--ball", nargs=3, type=float)
    parser.add_argument("--train", nargs="*", type=int, default=[])
    parser.add_argument("--splits", type=int, default=3)
    parser.add_argument("--folds", type=int, default=0)
    parser.add_argument("--amplitude", nargs="+", type=float, default=[3e-4])
    parser.add_argument("--placements", nargs="+", type=int, default=[1, 2, 4])
    parser.add_argument("--arms", type=int, default=10)
    parser.add_argument(
        "--first", type=int, default=0, help="seed of sockets and route"
    )
    parser.add_argument("--samples", nargs="+", type=int, default=[200])
    arguments = parser.parse_args()
    robot = mukca.load_robot(
        arguments.robot, flange=arguments.flange, ball=arguments.ball
    )
    if arguments.what == "none":
        none(arguments)
    else:
        what = {"points": points, "sockets": sockets, "growth": growth, "cost": cost}
        what[arguments.what](robot, arguments)


if __name__ == "__main__":
    main()

"""What calibration beyond the paper costs, and what known distances or a longer base bring.

    python benchmarks/auto.py [PLACEMENTS --robot R] [--arms 20]

Without placements, simulated ones of the demo arm are used. Costs are in units of one evaluation
of the model's own residuals and Jacobian, measured in the same run.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from mukca.recorder import Placement, find_placements, read_placement
from mukca.solver.curves import with_joint_curves
from mukca.solver.identification import JOINT_NOISE, FitOptions, fit
from mukca.solver.identification.data import (
    STANDARD_LOAD,
    KnownDistance,
    Measurement,
    RobotRecordings,
    measure,
    observe,
    places_of,
)
from mukca.solver.identification.effects import EXTENSIONS
from mukca.solver.identification.inference import Posterior
from mukca.solver.identification.robot import (
    Robot,
    load_robot,
    workspace,
)
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.parallel import Workers
from mukca.tools.simulation import (
    demo_arm,
    demo_bases,
    perturb,
    reachable_bases,
    record,
)

OFF = 5e-5
"""By so much is the base's distance misread [m]."""


def seconds(work: Callable[[], object], runs: int) -> float:
    """Return the median time of a piece of work, after one run to warm up."""
    work()
    times: list[float] = []
    for _ in range(runs):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def costs(robot: Robot, data: list[Measurement]) -> None:
    first = RobotRecordings(robot, data[:1])
    one = observe(first)
    found = fit(robot, data[:1]).arm
    model = found.model

    def evaluate() -> None:
        model.linearise(found.x, one)

    evaluation = seconds(evaluate, 30)
    duration = seconds(lambda: fit(robot, data[:1]), 5)
    print(
        f"auto, one placement ({data[0].name}): {duration:.2f} s = "
        f"{duration / evaluation:.0f} evaluations of {1e3 * evaluation:.2f} ms"
    )
    begin = time.perf_counter()
    fit(robot, data, FitOptions(curves=with_joint_curves))
    print(
        f"auto, {len(data)} placements, each left out in turn: {time.perf_counter() - begin:.1f} s"
    )


def distance_errors(found: Posterior, truth: np.ndarray, seed: int) -> np.ndarray:
    """Return errors of distances up to 400 mm between balls in the workspace [m]."""
    robot = found.model.robot
    q = workspace(robot, 2000, seed)
    ball = found.predict(STANDARD_LOAD.at(robot, q))
    true = found.model.ball.points(truth, q)
    lengths = np.linalg.norm(true[1::2] - true[::2], axis=1)
    errors = np.linalg.norm(ball[1::2] - ball[::2], axis=1) - lengths
    return errors[lengths < 0.4]


def misread(placement: Placement) -> Placement:
    """Return a placement whose base was measured a little too long."""
    assert placement.distance is not None
    return replace(placement, distance=placement.distance + OFF)


def misreading(seed: int) -> dict[str, np.ndarray]:
    """Return errors of distances with a misread base: alone, with known distances, long."""
    robot, generator = load_robot("panda"), np.random.default_rng(seed)
    arm = perturb(robot, generator, 2e-3, 5e-3)
    origins = arm.origins
    long = reachable_bases(arm, generator, 3, distance=0.15)
    bases = [replace(base, distance=0.05) for base in long]
    known = tuple(
        KnownDistance(
            (bases[0].name, 0),
            (other.name, 0),
            float(np.linalg.norm(bases[0].sockets[0] - other.sockets[0]))
            + generator.normal(0, 5e-5),
            5e-5,
        )
        for other in bases[1:]
    )
    errors: dict[str, np.ndarray] = {}
    for kind, there, also in (
        ("50 mm base", bases, ()),
        ("2 known distances", bases, known),
        ("150 mm base", long, ()),
    ):
        placements = [misread(record(arm, b, generator, noise=1e-4)) for b in there]
        measured = [measure(p, robot) for p in placements]
        places = places_of(measured, lengths=also, deviation=OFF)
        options = FitOptions(places=places, without=(*EXTENSIONS, JOINT_NOISE))
        found = fit(robot, measured, options).arm
        truth = found.model.ball.parameters_at(origins)
        errors[kind] = distance_errors(found, truth, seed)
    return errors


def scale(arms: int, workers: Workers) -> None:
    """Compare the kinds of bases over some arms."""
    draws = workers.map(misreading, range(arms))
    baseline = 0.0
    for kind in draws[0]:
        rms = float(
            np.sqrt(np.mean(np.concatenate([draw[kind] for draw in draws]) ** 2))
        )
        baseline = baseline or rms
        print(
            f"base misread by {1e3 * OFF} mm, {kind:17s}: rms error of distances up to 400 mm "
            f"{1e3 * rms:.3f} mm, {rms / baseline:.2f} x ({arms} arms)"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("placements", nargs="*", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--arms", type=int, default=20)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    if arguments.placements:
        recorded = [read_placement(p) for p in find_placements(arguments.placements)]
    else:
        generator = np.random.default_rng(0)
        recorded = [
            record(demo_arm()[1], b, generator, noise=5e-5) for b in demo_bases()
        ]
    costs(robot, [measure(p, robot) for p in recorded])
    scale(arguments.arms, read_options(arguments).workers)


if __name__ == "__main__":
    main()

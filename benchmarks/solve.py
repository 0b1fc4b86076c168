"""What a calibration costs, as ratios against baselines measured in the same run.

    python benchmarks/solve.py [PLACEMENT --robot R]

Without a placement, a simulated one of the demo arm is used. The SO-101 is simulated, too.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from mukca.recorder import read_placement, write_holes
from mukca.solver.diagnostics import RigidModel
from mukca.solver.diagnostics.hypotheses import samples_of
from mukca.solver.identification.data import (
    Measurement,
    RobotRecordings,
    measure,
    observe,
)
from mukca.solver.identification.inference import estimate
from mukca.solver.identification.model import extend
from mukca.solver.identification.paper import Problem, build_problem, solve
from mukca.solver.identification.robot import Robot, choose_parameters, load_robot
from mukca.tools.simulation import demo_arm, demo_bases, record, simulate_recordings

IMPORTS = {
    "import numpy, casadi": "import numpy, casadi",
    "import numpy, casadi, yourdfpy": "import numpy, casadi, yourdfpy",
    "all that mukca solve loads": "from mukca import calibrate; import mukca.tools.report.console",
    "nothing": "pass",
}
FIT = """
import sys, mukca
robot, placement = mukca.load_robot(sys.argv[2]), mukca.read_placements(sys.argv[1])
mukca.calibrate(robot, placement, distance=0.05)
"""
ONE_THREAD = 'import os; os.environ["OPENBLAS_NUM_THREADS"] = "1"'
"""The fit from Python is to cost at most 1.3 times as much without that line as with it."""


def seconds(work: Callable[[], object], runs: int = 15) -> float:
    """Return the median time of a piece of work, after one run to warm up."""
    work()
    times: list[float] = []
    for _ in range(runs):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def optimizers(problem: Problem) -> None:
    gauss_newton = seconds(lambda: solve(problem, "gauss-newton"))
    ipopt = seconds(lambda: solve(problem, "ipopt"), runs=5)
    print(f"gauss-newton {1e3 * gauss_newton:7.1f} ms")
    print(
        f"ipopt        {1e3 * ipopt:7.1f} ms   {ipopt / gauss_newton:.0f} x gauss-newton"
    )


def evaluations(problem: Problem) -> None:
    fits = [seconds(lambda: solve(problem), runs=3) for _ in range(5)]
    each = [seconds(lambda: problem.residuals(problem.start), runs=9) for _ in range(5)]
    fit, evaluation = statistics.median(fits), statistics.median(each)
    steps = len(solve(problem).iterates) - 1
    print(
        f"one fit of {steps} iterations costs {fit / evaluation:.1f} of its evaluations of "
        f"residuals and Jacobian ({1e3 * evaluation:.2f} ms each)"
    )


def fits(robot: Robot, measured: Measurement) -> None:
    """Compare the quick fit of the diagnostics with the full one, for the same unknowns."""
    quick = RigidModel(robot)
    samples = samples_of([measured])
    full = extend(robot, choose_parameters(robot))
    data = observe(RobotRecordings(robot, [measured]))
    by_quick = seconds(lambda: quick.fit(samples))
    by_full = seconds(lambda: estimate(full, data, joint_noise=False))
    print(f"quick fit    {1e3 * by_quick:7.1f} ms")
    print(
        f"full fit     {1e3 * by_full:7.1f} ms   {by_full / by_quick:.0f} x the quick fit"
    )


def processor_seconds(words: Sequence[str]) -> float:
    """Return what a command computes [s], which a busy machine does not change much.

    Modules are compiled once, in the first round, as an installer does.
    """
    environment = {
        k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(words, capture_output=True, env=environment)
    # 3: nothing was held out, so there is no verdict; 1: the simulated servos are not good enough.
    assert done.returncode in (0, 1, 3), done.stderr
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def commands(folder: Path, name: str, servo_arm: Path, runs: int) -> None:
    """Measure whole commands in turn, so that each is compared with its neighbours in time."""
    mukca = str(Path(sys.executable).with_name("mukca"))
    placement = (str(folder), "--robot", name, "--distance", "0.05")
    servos = (str(servo_arm), "--robot", "so101", "--distance", "0.05", "--zeros")
    words: dict[str, Sequence[str]] = {
        title: (sys.executable, "-c", code) for title, code in IMPORTS.items()
    } | {
        "mukca.calibrate": (sys.executable, "-c", FIT, str(folder), name),
        "mukca.calibrate, one thread": (
            *(sys.executable, "-c", ONE_THREAD + FIT),
            *(str(folder), name),
        ),
        "mukca --help": (mukca, "--help"),
        "mukca check": (mukca, "check", *placement),
        "mukca solve --method paper": (mukca, "solve", *placement, "--method", "paper"),
        "mukca solve --method auto": (mukca, "solve", *placement),
        "mukca solve --zeros of an SO-101": (mukca, "solve", *servos),
    }
    rounds = [
        {title: processor_seconds(w) for title, w in words.items()}
        for _ in range(runs + 1)
    ]
    bare, with_yourdfpy = list(IMPORTS)[:2]
    print(
        f"whole processes, processor time, medians of {runs} rounds; x {bare}; x {with_yourdfpy}"
    )
    for title in words:
        ratios = [
            statistics.median(one[title] / one[baseline] for one in rounds[1:])
            for baseline in (bare, with_yourdfpy)
        ]
        middle = statistics.median(one[title] for one in rounds[1:])
        print(f"{title:34s} {middle:6.2f} s  {ratios[0]:6.2f} x  {ratios[1]:6.2f} x")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("placement", nargs="?", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.placement
        if folder is None:
            folder = Path(temporary) / "front"
            front = record(
                demo_arm()[1], demo_bases()[0], np.random.default_rng(0), noise=5e-5
            )
            write_holes(front, folder)
        servo_arm = Path(temporary) / "so101"
        so101 = load_robot("so101")
        _, placements = simulate_recordings(so101, 1, samples=40, noise=5e-4)
        write_holes(placements[0], servo_arm)
        robot = load_robot(arguments.robot)
        measured = measure(read_placement(folder), robot)
        problem = build_problem(robot, [measured])
        evaluations(problem)
        optimizers(problem)
        fits(robot, measured)
        commands(folder, arguments.robot, servo_arm, arguments.rounds)


if __name__ == "__main__":
    main()

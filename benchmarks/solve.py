"""What a calibration costs, as ratios against baselines measured in the same run.

    python benchmarks/solve.py [PLACEMENT --robot R]

Without a placement, a simulated one of the demo arm is used.
"""

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from mukca.recorder.convert import write_holes
from mukca.recorder.dataset import Placement, Sample, read_placement
from mukca.solver.data.measurements import measure
from mukca.solver.paper.problem import Problem, build_problem, solve
from mukca.solver.robot.urdf import load_robot
from mukca.tools.commands.demo import demo_arm, demo_bases
from mukca.tools.simulated_arms import record


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
    print(f"ipopt        {1e3 * ipopt:7.1f} ms   {ipopt / gauss_newton:.0f} x gauss-newton")


def evaluations(problem: Problem) -> None:
    fits = [seconds(lambda: solve(problem), runs=3) for _ in range(5)]
    each = [seconds(lambda: problem.residuals(problem.start), runs=9) for _ in range(5)]
    fit, evaluation = statistics.median(fits), statistics.median(each)
    steps = solve(problem).solution.iterations
    print(
        f"one fit of {steps} iterations costs {fit / evaluation:.1f} of its evaluations of "
        f"residuals and Jacobian ({1e3 * evaluation:.2f} ms each)"
    )


def many(placement: Placement, count: int) -> Placement:
    """Return a placement with many samples: its own, again and again, a little off."""
    noise = np.random.default_rng(0).normal(0, 1e-5, (count, len(placement.samples[0].position)))
    samples = tuple(
        Sample(tuple((np.array(s.position) + noise[i]).tolist()), s.socket)
        for i, s in ((i, placement.samples[i % len(placement.samples)]) for i in range(count))
    )
    return replace(placement, samples=samples)


def growth(folder: Path, name: str) -> None:
    baseline = 0.0
    for count in (60, 600, 6_000, 60_000):
        words = [sys.executable, __file__, str(folder), "--robot", name, "--samples", str(count)]
        out = subprocess.run(words, check=True, capture_output=True, text=True).stdout
        per_sample, memory = map(float, out.split())
        baseline = baseline or per_sample
        print(
            f"{count:6d} samples: {1e6 * per_sample:7.1f} us a sample "
            f"({per_sample / baseline:.2f} x), peak memory {memory:.0f} MB"
        )


def one_size(folder: Path, name: str, count: int) -> None:
    """Print time per sample [s] and peak memory [MB] of a fit; run in a process of its own."""
    robot = load_robot(name)
    placement = many(read_placement(folder), count)
    problem = build_problem(robot, [measure(placement, robot)])
    per_sample = seconds(lambda: solve(problem), runs=5 if count < 60_000 else 2) / count
    print(per_sample, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)


def commands(folder: Path, name: str) -> None:
    def command(*words: str) -> Callable[[], object]:
        return lambda: subprocess.run(words, check=True, capture_output=True)

    mukca = str(Path(sys.executable).with_name("mukca"))
    imports = seconds(command(sys.executable, "-c", "import numpy, casadi, yourdfpy"), runs=7)
    print(f"import of numpy, casadi, yourdfpy {imports:.2f} s")
    for method in ("paper", "auto"):
        words = (mukca, "solve", str(folder), "--robot", name, "--method", method)
        whole = seconds(command(*words), runs=7)
        print(f"mukca solve --method {method:5s}, whole  {whole:.2f} s   {whole / imports:.2f} x")
    nothing = seconds(command(sys.executable, "-c", "pass"), runs=11)
    help_ = seconds(command(mukca, "--help"), runs=11)
    print(f"python -c pass                    {1e3 * nothing:.0f} ms")
    print(f"mukca --help                      {1e3 * help_:.0f} ms   {help_ / nothing:.1f} x")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("placement", nargs="?", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--samples", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.placement
        if folder is None:
            folder = Path(temporary) / "front"
            front = record(demo_arm()[1], demo_bases()[0], np.random.default_rng(0), noise=5e-5)
            write_holes(front, folder)
        if arguments.samples:
            one_size(folder, arguments.robot, arguments.samples)
            return
        robot = load_robot(arguments.robot)
        problem = build_problem(robot, [measure(read_placement(folder), robot)])
        evaluations(problem)
        optimizers(problem)
        growth(folder, arguments.robot)
        commands(folder, arguments.robot)


if __name__ == "__main__":
    main()

"""What a calibration costs, as ratios against baselines measured in the same run.

    python benchmarks/solve.py [PLACEMENT --robot R]

Without a placement, a simulated one of the demo arm is used.
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mukca.recorder.convert import write_holes
from mukca.recorder.dataset import read_placement
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
    steps = solve(problem).iterations
    print(
        f"one fit of {steps} iterations costs {fit / evaluation:.1f} of its evaluations of "
        f"residuals and Jacobian ({1e3 * evaluation:.2f} ms each)"
    )


def commands(folder: Path, name: str) -> None:
    def command(*words: str) -> Callable[[], object]:
        return lambda: subprocess.run(words, check=True, capture_output=True)

    mukca = str(Path(sys.executable).with_name("mukca"))
    imports = seconds(command(sys.executable, "-c", "import numpy, casadi"), runs=7)
    print(f"import of numpy, casadi           {imports:.2f} s")
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
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.placement
        if folder is None:
            folder = Path(temporary) / "front"
            front = record(demo_arm()[1], demo_bases()[0], np.random.default_rng(0), noise=5e-5)
            write_holes(front, folder)
        robot = load_robot(arguments.robot)
        problem = build_problem(robot, [measure(read_placement(folder), robot)])
        evaluations(problem)
        optimizers(problem)
        commands(folder, arguments.robot)


if __name__ == "__main__":
    main()

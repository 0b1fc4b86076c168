"""What the exported C functions cost a call, beside Pinocchio's forward kinematics in the same run.

    python benchmarks/export_c.py [CALIBRATION.json]

Without a calibration it is that of a simulated Panda, which bends and whose gears are uneven.

Pinocchio reads the URDF alone, and is called from Python; what such a call costs by itself is
measured too. The C functions hold the full model, corrections of the joints and gravity included.
Each figure is the least of five runs, in CPU time. Then 20,000 cycles of 1 ms of `arm_command_pose`
along a circle, at 0.5 m/s from the first recorded posture on, each near the one before: failures,
most rounds, and the slowest cycle. Where a pose is out of reach, the first such cycle stands beside
them, what is left there [mm], and the joint at its limit.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mukca import calibrate, simulate_recordings
from mukca.solver.calibration import load_calibration
from mukca.solver.identification.robot import load_robot, workspace
from mukca.tools.cli import main as mukca

FLAWS = {"compliance": 5e-5, "tilt": 3e-5, "transmission": 2e-4}
"""Of the simulated Panda [rad/(N m), rad]."""
LOOP = """
#define _POSIX_C_SOURCE 199309L
#include "arm.h"
#include <math.h>
#include <stdio.h>
#include <time.h>
static double q[ROWS][ARM_JOINTS] = {DATA};
static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}
#define TIME(call) do { \\
    double out[64], sum = 0, begin = now(); \\
    for (int n = 0; n < 100 * ROWS; ++n) { call(q[n % ROWS], out); sum += *out; } \\
    printf("%s %.4f %d\\n", #call, 1e6 * (now() - begin) / (100 * ROWS), sum == 0); \\
  } while (0)
static const double start[ARM_JOINTS] = {START};
static void circle(void) {
  double T[16], near[ARM_JOINTS], found[ARM_JOINTS], x, y, worst = 0;
  int failed = 0, rounds = 0, first = -1;
  arm_report report, there = {0, 0, 0, -1};
  for (int i = 0; i < ARM_JOINTS; ++i) near[i] = start[i];
  arm_flange(near, T);
  x = T[3], y = T[7];
  for (int n = 0; n < 20000; ++n) {
    const double turn = 0.5 / RADIUS * 1e-3 * n;
    T[3] = x + RADIUS * (cos(turn) - 1), T[7] = y + RADIUS * sin(turn);
    const double begin = now();
    const int missed = arm_command_pose(T, near, start, found, &report) != 0;
    if (missed && failed++ == 0) first = n, there = report;
    worst = fmax(worst, now() - begin);
    if (report.rounds > rounds) rounds = report.rounds;
    for (int i = 0; i < ARM_JOINTS; ++i) near[i] = found[i];
  }
  printf("circle %.4f %d %d\\n", 1e6 * worst, rounds, failed);
  if (failed)
    printf("first out of reach in cycle %d: %.1e m, %.1e rad left, joint at its limit: %s\\n",
           first, there.distance, there.angle,
           there.joint_at_limit < 0 ? "none" : arm_joint_names[there.joint_at_limit]);
}
int main(void) {
  CALLS
  circle();
  return 0;
}
"""
RADIUS = 0.05
"""Of the circle [m]."""


def in_c(
    file: Path, folder: Path, q: np.ndarray, start: Sequence[float]
) -> dict[str, float]:
    """Return the time of each function and of the slowest cycle [us], its steps, and misses."""
    source = folder / "arm.c"
    assert mukca(["export", str(file), "--to", "c", "--out", str(source)]) == 0
    names = re.findall(r"^\w+ (arm_\w+)\(", (folder / "arm.h").read_text(), re.M)
    data = ",".join("{" + ",".join(map(repr, row)) + "}" for row in q.tolist())
    loop = (
        LOOP.replace("ROWS", str(len(q)))
        .replace("DATA", data)
        .replace("RADIUS", str(RADIUS))
    )
    loop = loop.replace("START", ",".join(map(repr, start)))
    names.remove("arm_command_pose")
    (folder / "loop.c").write_text(
        loop.replace("CALLS", " ".join(f"TIME({n});" for n in names))
    )
    words = ["cc", "-std=c99", "-O2", "loop.c", "arm.c", "-o", "loop", "-lm"]
    subprocess.run(words, cwd=folder, check=True)
    lines = subprocess.run(
        ["./loop"], cwd=folder, check=True, capture_output=True, text=True
    )
    rows = lines.stdout.splitlines()
    end = 1 + next(i for i, row in enumerate(rows) if row.startswith("circle"))
    print(*rows[end:], file=sys.stderr)
    slowest, rounds, missed = map(float, rows[end - 1].split()[1:])
    times = {f"`{row.split()[0]}`": float(row.split()[1]) for row in rows[: end - 1]}
    cycle = "`arm_command_pose`, slowest of 20,000 cycles"
    return times | {
        cycle: slowest,
        "its most steps": rounds,
        "its poses missed": missed,
    }


def in_pinocchio(urdf: bytes, q: np.ndarray) -> tuple[float, float]:
    """Return the time of a forward kinematics, and of a call that does nothing [us]."""
    import pinocchio

    model = pinocchio.buildModelFromXML(urdf.decode())
    data = model.createData()
    rows = [np.resize(row, model.nq) for row in q]
    begin = time.process_time()
    for row in rows * 100:
        pinocchio.forwardKinematics(model, data, row)
    between = time.process_time()
    for _ in rows * 100:
        pinocchio.printVersion()
    end = time.process_time()
    calls = 100 * len(rows)
    return 1e6 * (between - begin) / calls, 1e6 * (end - between) / calls


def costs(file: Path) -> None:
    """Show the costs of a calibration's functions."""
    calibration = load_calibration(file)
    q = workspace(calibration.robot, 200)
    start = calibration.document.data[0].samples[0].position
    with tempfile.TemporaryDirectory() as folder:
        runs = [in_c(file, Path(folder) / str(i), q, start) for i in range(5)]
    urdf = calibration.calibrated.urdf()
    others = [in_pinocchio(urdf, q) for _ in range(5)]
    extensions = ", ".join(calibration.calibrated.deflection.extensions)
    print(
        f"| {calibration.robot.name} ({extensions}) | us a call |",
        "|---|---|",
        sep="\n",
    )
    for name in runs[0]:
        print(f"| {name} | {min(run[name] for run in runs):.3g} |")
    kinematics, nothing = map(min, zip(*others, strict=True))
    print(f"| Pinocchio's `forwardKinematics`, called from Python | {kinematics:.3g} |")
    print(f"| an empty call from Python | {nothing:.3g} |")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("calibration", type=Path, nargs="?", metavar="CALIBRATION.json")
    file: Path | None = parser.parse_args().calibration
    if file is not None:
        costs(file)
        return
    with tempfile.TemporaryDirectory() as folder:
        panda = load_robot("panda")
        _, placements = simulate_recordings(panda, 2, **FLAWS)
        calibrate(panda, placements).save(folder, force=True)
        costs(Path(folder) / "calibration.json")


if __name__ == "__main__":
    main()

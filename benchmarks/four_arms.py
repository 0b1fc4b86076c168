"""Four real arms under instruments, beside each other: errors at points that no fit has seen.

    python benchmarks/four_arms.py TRACKER

TRACKER has folders of points, or poses, of a UR5, a UR10, an ABB IRB 120 and a KUKA iiwa 7. The
first two are split at random, ten times and once; the others have a folder to train on and one to
test on. Each row has the points trained on and held out, the mean errors in mm by the nominal model
with its reflector refitted, by the calibrated URDF alone and by the full model, and how many points
lie within the stated 68 % and 95 %.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import shutil
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from instrument import shares_within, split

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import Robot


@dataclass(frozen=True)
class Arm:
    """An arm under an instrument."""

    folder: str
    robot: str
    """A shipped arm, or a URDF in the tracker's folder."""
    ball: tuple[float, float, float] | None = None
    """The reflector on tool0, about [m]; None for that of the model."""
    trained: int = 0
    """Points to train on; 0 where the folders say."""
    splits: int = 1


ARMS = {
    "UR5": Arm("ur5", "ur5.urdf", (0.0, 0.0, 0.031), trained=120, splits=10),
    "UR10": Arm("ur10", "ur10", trained=300),
    "ABB IRB 120": Arm("irb120", "irb120/irb120.urdf", (0.0, 0.0, 0.1)),
    "KUKA iiwa 7": Arm("iiwa7", "iiwa7"),
}


def figures(robot: Robot, train: Placement, test: Placement) -> list[float]:
    """Return points trained on and held out, three mean errors [mm], and two shares [%]."""
    calibration = mukca.calibrate(robot, train, test=test)
    summary = calibration.errors.summary.test
    assert summary is not None
    models = (summary.before, summary.loaded, summary.calibrated)
    errors = [1e3 * model.mean_absolute_error for model in models]
    counts = [float(len(part.samples)) for part in (train, test)]
    return [
        *counts,
        *errors,
        *shares_within(calibration, measure(test, robot, sockets=1)),
    ]


def points_of(folder: Path) -> list[Placement]:
    """Return the placements of a folder; of poses that are there as points, too, the points."""
    if not (folder / "poses.csv").exists():
        return mukca.read_placements(folder)
    with TemporaryDirectory() as copy:
        shutil.copy(folder / "points.csv", copy)
        return mukca.read_placements(copy)


def row(tracker: Path, name: str) -> str:
    """Return an arm's row of the table: the mean over its splits."""
    arm = ARMS[name]
    file, flange = tracker / arm.robot, None if arm.ball is None else "tool0"
    robot = mukca.load_robot(
        file if file.suffix else arm.robot, flange=flange, ball=arm.ball
    )
    placements = points_of(tracker / arm.folder)
    if arm.trained:
        pairs = [split(placements[0], arm.trained, seed) for seed in range(arm.splits)]
    else:
        by_name = {p.path.name: p for p in placements if p.path}
        pairs = [(by_name["train"], by_name["test"])]
    means = np.mean(
        [figures(robot, train, test) for train, test in pairs], axis=0
    ).tolist()
    cells = (f"{v:.{d}f}" for v, d in zip(means, (0, 0, 3, 3, 3, 0, 0), strict=True))
    return f"| {name} | {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tracker", type=Path, help="folder with the folders of points")
    parser.add_argument("--arms", nargs="+", choices=list(ARMS), default=list(ARMS))
    arguments = parser.parse_args()
    print(
        "| arm | trained on | held out | nominal | URDF | full model | in 68 % | in 95 % |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name in arguments.arms:
        print(row(arguments.tracker, name), flush=True)


if __name__ == "__main__":
    main()

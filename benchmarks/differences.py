"""What becomes of accuracy where something differs between places, as weighed and as recorded.

    python benchmarks/differences.py [--draws 10] [--arm panda] [--recordings ../shared/recordings]
                                     [--rigid MM]

Each figure is the median error of distances in the workspace by ``calibrated.urdf`` [mm]. A
placement of a real arm is trained on alone, against the full model of its others. A simulated arm
is against the truth, and its figure is the geometric mean over the draws; it bends and turns
unevenly as real arms do, or is ``--rigid`` with so much noise of the seat. Beside them stands what
the calibration states.
"""

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from worlds import realistic_flaws

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.robot import Robot, workspace
from mukca.tools.simulation import (
    Imperfection,
    Session,
    SessionFault,
    perturb,
    reachable_bases,
    record,
    truth_of,
    with_faults,
)

REAL = {
    "kuka_14": ("raised_left",),
    "panda_1": ("right",),
    "dinova_1": ("front",),
    "dinova_2": ("front", "front_rotated"),
    "panda_3": (
        "frontcenter",
        "frontleft",
        "frontright",
        "backcenter",
        "backleft",
        "backright",
    ),
}
"""Placements of each folder of recordings that are trained on alone."""
NOMINAL = {"panda_1": "panda_3", "dinova_1": "dinova_2"}
"""Folders that hold the URDF of another one."""
FAULTS = {"none": "", "step 0.5 mm": "base", "drift 1 mm": "drift", "step 3 mm": "base"}
SIZES = {"step 0.5 mm": 0.5e-3, "drift 1 mm": 1e-3, "step 3 mm": 3e-3}
CREEP = 3e-4
"""Distance of a ball from its place in the placement before [m]."""
EACH, PAIRS = 30, 2000
Ball = Callable[[np.ndarray], np.ndarray]


def error(robot: Robot, ball: Ball, truth: Ball) -> float:
    """Return the median error of distances between random poses [mm]."""
    q = workspace(robot, 2 * PAIRS)
    lengths: list[np.ndarray] = []
    for points in (ball(q), truth(q)):
        lengths.append(np.linalg.norm(points[PAIRS:] - points[:PAIRS], axis=1))
    return 1e3 * float(np.median(np.abs(lengths[0] - lengths[1])))


def errors(robot: Robot, train: Sequence[Placement], truth: Ball) -> list[float]:
    """Return the errors as weighed and as recorded, and the stated one as weighed [mm]."""
    fits = [mukca.calibrate(robot, train, as_recorded=no) for no in (False, True)]
    found = [error(robot, fit.calibrated.geometric_ball, truth) for fit in fits]
    return [*found, 1e3 * fits[0].document.better.workspace.now.value]


def real(folder: Path, name: str) -> list[float]:
    """Return the errors of a placement alone against the model of the others [mm]."""
    urdf = folder.parent / NOMINAL.get(folder.name, folder.name) / "nominal.urdf"
    robot = mukca.load_robot(str(urdf))
    placements = mukca.read_placements(folder)
    others = [placement for placement in placements if placement.place != name]
    alone = [placement for placement in placements if placement.place == name]
    reference = mukca.calibrate(robot, others)
    return errors(robot, alone, reference.calibrated.ball)


def simulated(robot: Robot, fault: str, noise: float | None, seed: int) -> list[float]:
    """Return the errors of an arm with a fault amid its one placement [mm]."""
    generator = np.random.default_rng([seed, 74])
    arm = perturb(robot, generator, 2e-3, 5e-3)
    how = Imperfection(noise) if noise else realistic_flaws(robot, generator)
    base = reachable_bases(arm, generator, 1)[0]
    placement = record(arm, base, generator, samples=EACH, imperfection=how)
    start = int(generator.integers(8, 2 * EACH - 8)) if FAULTS[fault] == "base" else 1
    if FAULTS[fault]:
        seats = np.array(base.sockets)
        q, sockets = placement.positions, placement.sockets
        session = Session(arm, q, sockets, seats, generator)
        happened = SessionFault(FAULTS[fault], start, size=SIZES[fault])
        placement = placement.with_positions(with_faults(session, [happened]))
    truth = truth_of(robot, arm, how.deflection)
    return errors(robot, [placement], truth.ball)


def creeping(robot: Robot, trained: int, seed: int) -> list[float]:
    """Return the errors where the ball creeps from placement to placement [mm]."""
    generator = np.random.default_rng([seed, 75])
    arm = perturb(robot, generator, 2e-3, 5e-3)
    how = realistic_flaws(robot, generator)
    truth = truth_of(robot, arm, how.deflection)
    placements: list[Placement] = []
    for base in reachable_bases(arm, generator, 5):
        placements.append(
            record(arm, base, generator, samples=EACH // 2, imperfection=how)
        )
        origins = arm.origins.copy()
        aside = generator.normal(size=3)
        origins[-1, :3] += CREEP * aside / np.linalg.norm(aside)
        arm = arm.with_origins(origins)
    return errors(robot, placements[:trained], truth.ball)


def show(case: str, rows: Sequence[Sequence[float]]) -> None:
    """Print the geometric means of a case."""
    means = np.exp(np.mean(np.log(rows), axis=0)).tolist()
    print(
        f"| {case} | " + " | ".join(f"{mean:.2f}" for mean in means) + " |", flush=True
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--arm", default="panda")
    parser.add_argument("--recordings", type=Path)
    parser.add_argument("--rigid", type=float, metavar="MM", help="noise of the seat")
    arguments = parser.parse_args()
    noise = arguments.rigid and 1e-3 * arguments.rigid
    print("| case | weighed | as recorded | stated |\n|---|---|---|---|")
    if arguments.recordings:
        for folder, names in REAL.items():
            for name in names:
                found = real(arguments.recordings / folder, name)
                show(f"{folder}/{name}", [found])
    robot = mukca.load_robot(arguments.arm)
    draws = range(arguments.draws)
    for fault in FAULTS:
        show(fault, [simulated(robot, fault, noise, seed) for seed in draws])
    for trained in (5, 1):
        rows = [creeping(robot, trained, seed) for seed in draws]
        show(f"ball creeps by 0.3 mm, trained on {trained}", rows)


if __name__ == "__main__":
    main()

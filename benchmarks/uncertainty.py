"""How often stated intervals hold the truth, on simulated arms whose truth is known.

    python benchmarks/uncertainty.py [--draws 200] [--rigid]

For each draw a robot is perturbed, bends and turns unevenly as real arms do (unless --rigid), is
recorded at two placements with a noisy seat, calibrated by `auto`, and asked for intervals: of
distances between far ball positions and near the third placement, by the full model and by the
URDF alone, of deviations of balls from their socket's mean there, and of parameters that the data
decide. The caliper's error of the base is drawn too. Shares are means over arms. Stated: 68 % and
95 %.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from dataclasses import replace
from functools import partial

import numpy as np

from mukca.solver.bayes.results.projection_poses import poses_near
from mukca.solver.bayes.results.uncertainty import (
    NEAR,
    NEARBY,
    deviations,
    distance_deviations,
    prior_deviations,
)
from mukca.solver.calibration import SolveOptions
from mukca.solver.calibration.fit import fit_robots
from mukca.solver.data import (
    CALIPER_DEVIATION,
    SEAT_DEVIATION,
    RobotRecordings,
    measure,
)
from mukca.solver.robot import gravity_moments, load_robot, workspace
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, realistic_flaws, record

ROBOTS = ("panda", "iiwa14", "gen3_lite", "ur5e")


def draw(rigid: bool, seed: int) -> dict[str, list[float]]:
    """Return errors over stated deviations, by kind, and whether any extension was kept."""
    robot = load_robot(ROBOTS[seed % len(ROBOTS)])
    generator = np.random.default_rng(seed)
    arm = perturb(robot, generator, 2e-3, 5e-3)
    bases = reachable_bases(arm, generator, 3)
    stated = bases[0].distance + generator.normal(0, CALIPER_DEVIATION)
    bases = [replace(b, distance=b.distance + generator.normal(0, SEAT_DEVIATION)) for b in bases]
    flaws = Imperfection(noise=1e-4) if rigid else realistic_flaws(robot, generator)
    placements = [record(arm, base, generator, imperfection=flaws) for base in bases]
    measured = [measure(p, robot, stated) for p in placements]
    (fit,) = fit_robots([RobotRecordings(robot, measured[:2])], SolveOptions(type_prior=("none",)))
    found = fit.posterior
    assert found is not None
    truth = arm.origins.ravel()[found.model.ball.free]

    def exactly(positions: np.ndarray) -> np.ndarray:
        bent = flaws.deflection.true_positions(positions, gravity_moments(arm, positions))
        return found.model.ball.points(truth, bent)

    def distances(q: np.ndarray) -> tuple[list[float], list[float]]:
        """By the full model, and by the URDF alone."""
        q = q[: len(q) // 2 * 2]
        full, deviation = distance_deviations(found, q, gravity_moments(robot, q))
        balls = (exactly(q), fit.calibrated.geometric_ball(q))
        true, alone = (np.linalg.norm(p[1::2] - p[::2], axis=1) for p in balls)
        by_urdf = (alone - true) / np.hypot(deviation, alone - full)
        return ((full - true) / deviation).tolist(), by_urdf.tolist()

    near, _ = poses_near(robot, measured[2].positions, (NEARBY, 1), NEAR)
    here, there = distances(near), distances(workspace(robot, 80, seed))

    size = found.model.size
    covariance = found.covariance[:size, :size]
    scatter: list[float] = []
    held = measured[2]
    for rows in held.slices:
        x = held.positions[rows]
        points, jacobian, _ = found.model.linearise(found.x, x, gravity_moments(robot, x))
        exact = exactly(x)
        error = (points - points.mean(axis=0)) - (exact - exact.mean(axis=0))
        centred = jacobian - jacobian.mean(axis=0)
        variance = np.einsum("nij,jk,nik->ni", centred, covariance, centred)
        scatter += (error / np.sqrt(variance)).ravel().tolist()

    n = found.model.geometry
    deviation = deviations(found)[:n]
    decided = (deviation > 0) & (deviation < 0.5 * prior_deviations(found)[:n])
    parameter = (found.values - truth)[decided] / deviation[decided]
    return {
        "workspace": there[0],
        "its URDF": there[1],
        "near": here[0],
        "near, URDF": here[1],
        "deviations": scatter,
        "parameters": parameter.tolist(),
        "extended": [float(bool(found.model.extensions))],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--rigid", action="store_true", help="arms that neither bend nor wobble")
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    draws = arguments.draws
    begin = time.perf_counter()
    results = read_options(arguments).workers.map(partial(draw, arguments.rigid), range(draws))
    print(f"{draws} draws over {', '.join(ROBOTS)} in {time.perf_counter() - begin:.0f} s")
    kept = sum(bool(result["extended"][0]) for result in results)
    print(f"an extension was kept in {kept}")
    for kind in list(results[0])[:-1]:
        arms = [np.abs(result[kind]) for result in results if result[kind]]
        one, two = (100 * np.mean([np.mean(z < k) for z in arms]) for k in (1, 1.96))
        print(
            f"{kind:11s} {len(arms):4d} arms: within 1 sigma {one:.1f} % (68.3), "
            f"within 1.96 sigma {two:.1f} % (95.0)"
        )


if __name__ == "__main__":
    main()

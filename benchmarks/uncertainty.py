"""How often stated intervals hold the truth, on simulated arms whose truth is known.

    python benchmarks/uncertainty.py [--draws 200] [--kind bending] [--placements 2] [--seed 0]

For each draw a robot is perturbed; it is rigid, or bends and turns unevenly as real arms do, alone
or on a rail, or is made of servos, whose gears have play and whose zeros are off. Lengths are 2 mm
off and angles 5 mrad, or, of rigid arms that are ``drawn``, as much as the prior expects: 1 mm and
5 mrad, each times a factor of the same distribution. It is recorded
at one or two placements with a noisy seat, calibrated by `auto`, and asked for intervals: of
distances between far ball positions, low ones, and ones near another placement, by the full model
and by the URDF alone, of deviations of balls from their socket's mean there, of parameters that
the data decide, and of poses of the flange in the base, all six numbers together. The caliper's
error of the base is drawn too. Shares are means over arms. Stated: 68 % and 95 %.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import NormalDist
from tempfile import TemporaryDirectory

import numpy as np
from worlds import realistic_flaws

from mukca.recorder import Placement
from mukca.solver.calibration import METHODS, SolveOptions, fit_robot
from mukca.solver.identification.data import (
    CALIPER_DEVIATION,
    SEAT_DEVIATION,
    STANDARD_LOAD,
    Measurement,
    RobotRecordings,
    measure,
)
from mukca.solver.identification.inference import Posterior
from mukca.solver.identification.model import GEOMETRY_WIDTHS, TYPICAL_SPREAD
from mukca.solver.identification.robot import (
    BallModel,
    Robot,
    load_robot,
    rotation_vectors,
    workspace,
)
from mukca.solver.results import CalibratedRobot
from mukca.solver.studies import pose_covariances
from mukca.solver.studies.predicted_errors import NEAR, NEARBY, poses_near
from mukca.solver.studies.uncertainty import distance_deviations
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

ROBOTS = {
    "rigid": ("panda", "iiwa14", "gen3_lite", "ur5e"),
    "drawn": ("panda", "iiwa14", "gen3_lite", "ur5e"),
    "bending": ("panda", "iiwa14", "gen3_lite", "ur5e"),
    "servos": ("so101",),
    "prismatic": ("ur5e on a rail", "panda on a rail"),
}
ON_A_RAIL = " on a rail"
RAIL = """<link name="rail_base"/><joint name="rail" type="prismatic"><parent link="rail_base"/>
<child link="{}"/><axis xyz="0 1 0"/><limit lower="-0.4" upper="0.4" effort="100" velocity="1"/>
</joint></robot>"""
LOW = 0.15
"""Balls below this are over the table [m]."""
PLAY, TICK = np.deg2rad(0.7), 2 * np.pi / 4096
ZEROS = np.deg2rad(5.0)
POSES = 60
REST = 0.03
"""Torque below which a joint with play is taken to rest amid it [N m]."""


@dataclass(frozen=True)
class Truth:
    """An arm, and where its ball is where its joints read q."""

    arm: Robot
    flaws: Imperfection
    zeros: np.ndarray

    def ball(self, q: np.ndarray) -> np.ndarray:
        """Ball centres, shape (N, 3) [m]."""
        samples = STANDARD_LOAD.at(self.arm, q + self.zeros)
        true = self.flaws.deflection.true_positions(samples)
        if self.flaws.play:
            torques = samples.torques
            true = true - 0.5 * self.flaws.play * np.sign(torques) * (
                abs(torques) > REST
            )
        return BallModel(self.arm, ()).points(np.zeros(0), true)


def standard(error: np.ndarray, gap: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return errors of a model that is off by a known gap, as multiples of a Gaussian's deviation.

    They are within one where the error is within what 68 % of |gap + deviation z| are.
    """
    phi = NormalDist().cdf
    shares = [
        phi((w - g) / s) - phi((-w - g) / s)
        for w, g, s in zip(
            abs(error).tolist(), gap.tolist(), deviation.tolist(), strict=True
        )
    ]
    return np.array([NormalDist().inv_cdf(min((1 + p) / 2, 1 - 1e-12)) for p in shares])


def arm_of(kind: str, robot: Robot, generator: np.random.Generator) -> Truth:
    """Return an arm of a kind."""
    m = len(robot.actuated)
    if kind == "servos":
        flaws = Imperfection(noise=3e-4, play=PLAY, resolution=TICK)
        zeros = generator.uniform(-ZEROS, ZEROS, m)
        return Truth(perturb(robot, generator, 3e-4, 0.0), flaws, zeros)
    sizes = np.array([2e-3, 5e-3])
    if kind == "drawn":
        typical = np.array(
            [GEOMETRY_WIDTHS["translation"], GEOMETRY_WIDTHS["rotation"]]
        )
        sizes = typical * np.exp(TYPICAL_SPREAD * generator.normal(0, 1, 2))
    arm = perturb(robot, generator, *sizes.tolist())
    rigid = Imperfection(noise=1e-4)
    flaws = rigid if kind in ("rigid", "drawn") else realistic_flaws(robot, generator)
    return Truth(arm, flaws, np.zeros(m))


def load(name: str) -> Robot:
    """Return a shipped robot, or one on a rail, whose prismatic joint is the first of its chain."""
    robot = load_robot(name.removesuffix(ON_A_RAIL))
    if not name.endswith(ON_A_RAIL):
        return robot
    with TemporaryDirectory() as folder:
        file = Path(folder, "rail.urdf")
        file.write_bytes(
            robot.text.data.replace(b"</robot>", RAIL.format(robot.base).encode())
        )
        return load_robot(file, base="rail_base")


def draw(kind: str, trained: int, seed: int) -> dict[str, list[float]]:
    """Return errors over stated deviations, by kind, and whether any extension was kept."""
    robots = ROBOTS[kind]
    robot = load(robots[seed % len(robots)])
    generator = np.random.default_rng(seed)
    truth = arm_of(kind, robot, generator)
    bases = reachable_bases(truth.arm, generator, 3)
    stated = bases[0].distance + generator.normal(0, CALIPER_DEVIATION)
    bases = [
        replace(b, distance=b.distance + generator.normal(0, SEAT_DEVIATION))
        for b in bases
    ]
    samples = 20 if kind == "servos" else 30
    placements = [
        record(truth.arm, base, generator, samples=samples, imperfection=truth.flaws)
        for base in bases
    ]
    placements = [_read(p, truth.zeros) for p in placements]
    measured = [measure(p, robot, stated) for p in placements]
    options = SolveOptions(zeros=kind == "servos")
    fit = fit_robot(RobotRecordings(robot, measured[:trained]), options, METHODS)
    found = fit.posterior
    assert found is not None
    balls = fit.calibrated.ball, fit.calibrated.geometric_ball
    errors: dict[str, list[float]] = {}

    def ask(where: str, q: np.ndarray) -> None:
        """Distances by the full model, and by the URDF alone."""
        q = q[: len(q) // 2 * 2]
        _, deviation = distance_deviations(found, STANDARD_LOAD.at(robot, q))
        true, full, alone = (_lengths(of(q)) for of in (truth.ball, *balls))
        errors[where] = ((full - true) / deviation).tolist()
        errors[f"{where}, URDF"] = standard(
            alone - true, full - alone, deviation
        ).tolist()

    ask("workspace", workspace(robot, 80, seed))
    many = workspace(robot, 600, seed)
    height = truth.ball(many)[:, 2]
    ask("table", many[(height > 0) & (height < LOW)][:80])
    ask("near", poses_near(robot, measured[2].positions, (NEARBY, 1), NEAR)[0])
    errors["deviations"] = _deviations(found, measured[2], truth)
    if kind != "servos":
        n = found.model.geometry
        deviation = np.sqrt(np.diag(found.of_unknowns))[:n]
        prior = np.sqrt(np.diag(found.prior_covariance))[:n]
        decided = (deviation > 0) & (deviation < 0.5 * prior)
        true = found.model.ball.parameters_at(truth.arm.origins)
        errors["parameters"] = (
            (found.values - true)[decided] / deviation[decided]
        ).tolist()
        errors["poses"] = _poses(found, fit.calibrated, truth)
    return {**errors, "extended": [float(bool(found.model.extensions))]}


def _read(placement: Placement, zeros: np.ndarray) -> Placement:
    """Return what joints read whose zeros are off."""
    rows = (placement.positions - zeros).tolist()
    pairs = zip(placement.samples, rows, strict=True)
    return replace(
        placement, samples=tuple(replace(s, position=tuple(q)) for s, q in pairs)
    )


def _lengths(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points[1::2] - points[::2], axis=1)


def _deviations(found: Posterior, held: Measurement, truth: Truth) -> list[float]:
    """Errors of balls less the mean of their socket, over their deviation."""
    size = found.model.size
    covariance = found.covariance[:size, :size]
    scatter: list[float] = []
    for rows in held.slices:
        x = held.positions[rows]
        points, jacobian, _ = found.linearise(STANDARD_LOAD.at(truth.arm, x))
        exact = truth.ball(x)
        error = (points - points.mean(axis=0)) - (exact - exact.mean(axis=0))
        centred = jacobian - jacobian.mean(axis=0)
        variance = np.einsum("nij,jk,nik->ni", centred, covariance, centred)
        scatter += (error / np.sqrt(variance)).ravel().tolist()
    return scatter


def _poses(found: Posterior, arm: CalibratedRobot, truth: Truth) -> list[float]:
    """Errors of flange poses as if of one number: as improbable as all six together."""
    true = CalibratedRobot(truth.arm, deflection=truth.flaws.deflection)
    q = workspace(arm.robot, POSES)
    at, exact = (one.poses(q)[0].reshape(-1, 4, 4) for one in (arm, true))
    poses = STANDARD_LOAD.at(arm.robot, q)
    covariances = pose_covariances(found, poses, at[:, :3, 3])
    turns = rotation_vectors(at[:, :3, :3] @ exact[:, :3, :3].swapaxes(1, 2))
    errors = np.hstack([(at - exact)[:, :3, 3], turns])
    squares = np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors)
    # Chi-square of 6.
    beyond = np.exp(-squares / 2) * (1 + squares / 2 + squares**2 / 8)
    return [NormalDist().inv_cdf(1 - p / 2) for p in beyond.clip(1e-12, 1).tolist()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--kind", choices=ROBOTS, default="bending")
    parser.add_argument("--placements", type=int, choices=(1, 2), default=2)
    parser.add_argument("--seed", type=int, default=0)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    draws = arguments.draws
    begin = time.perf_counter()
    seeds = range(arguments.seed, arguments.seed + draws)
    one = partial(draw, arguments.kind, arguments.placements)
    results = read_options(arguments).workers.map(one, seeds)
    robots = ", ".join(ROBOTS[arguments.kind])
    print(f"{draws} draws over {robots} in {time.perf_counter() - begin:.0f} s")
    kept = sum(bool(result["extended"][0]) for result in results)
    print(f"an extension was kept in {kept}")
    for kind in list(results[0])[:-1]:
        arms = [np.abs(result[kind]) for result in results if result[kind]]
        one, two = (100 * np.mean([np.mean(z < k) for z in arms]) for k in (1, 1.96))
        print(
            f"{kind:15s} {len(arms):4d} arms: within 1 sigma {one:.1f} % (68.3), "
            f"within 1.96 sigma {two:.1f} % (95.0)"
        )


if __name__ == "__main__":
    main()

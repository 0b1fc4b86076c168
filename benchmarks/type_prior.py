"""What the elasticity of another arm of the type is worth where samples are few.

    python benchmarks/type_prior.py [--arms 12] [--samples 10]

For each draw a type is drawn, by how much its joints and links bend, and two arms of it, which
differ from that by 15 %. The first is calibrated from two placements of 30 + 30 configurations, the
second from one of few: without what the first tells, with it, with five times as much, and with the
joints in reverse order. Errors are those at three other placements.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from functools import partial

import numpy as np
from worlds import TRANSLATION, TURN

from mukca.solver.bayes.model import Deflection, Expected
from mukca.solver.bayes.results.uncertainty import deviations
from mukca.solver.calibration import SolveOptions, fit_robots
from mukca.solver.data import Measurement, RobotRecordings, evaluate, measure
from mukca.solver.robot import Robot, load_robot
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

ROBOTS = ("panda", "iiwa14", "ur5e")


def recordings(
    robot: Robot,
    of_type: dict[str, np.ndarray],
    generator: np.random.Generator,
    samples: list[int],
) -> list[Measurement]:
    """Return recordings of an arm of a type, so many samples in each socket."""
    arm = perturb(robot, generator, TRANSLATION, TURN)
    own = [v * generator.normal(1, 0.15, len(v)).clip(0.2, 2) for v in of_type.values()]
    how = Imperfection(generator.uniform(5e-5, 1e-4), Deflection(tuple(of_type), tuple(own)))
    bases = reachable_bases(arm, generator, len(samples))
    return [
        measure(record(arm, base, generator, samples=count, imperfection=how), robot)
        for base, count in zip(bases, samples, strict=True)
    ]


def learned(robot: Robot, placements: list[Measurement]) -> dict[str, Expected]:
    """Return what a calibration tells of the elasticity."""
    options = SolveOptions(type_prior=("none",))
    found = fit_robots([RobotRecordings(robot, placements)], options)[0].posterior
    assert found is not None
    return {
        effect.name: (found.x[own], deviations(found)[own])
        for effect, own in zip(found.model.effects, found.model.slices, strict=True)
        if effect.shared_by_type
    }


def draw(samples: int, seed: int) -> dict[str, float]:
    """Return the errors of an arm elsewhere, with each prior [mm]."""
    robot, generator = load_robot(ROBOTS[seed % len(ROBOTS)]), np.random.default_rng(5000 + seed)
    joints = len(robot.joint_names)
    of_type = {
        "compliance": generator.uniform(1e-5, 6e-5, joints),
        "tilt": generator.uniform(0, 3e-5, 2 * joints),
    }
    other = learned(robot, recordings(robot, of_type, generator, [30, 30]))
    train, *test = recordings(robot, of_type, generator, [samples, 30, 30, 30])

    def turned(values: np.ndarray) -> np.ndarray:
        return values.reshape(-1, joints)[:, ::-1].ravel()

    priors: dict[str, dict[str, Expected]] = {
        "none": {},
        "of the type": other,
        "five times": {name: (5 * x, 5 * d) for name, (x, d) in other.items()},
        "reversed": {name: (turned(x), turned(d)) for name, (x, d) in other.items()},
    }
    trained = [RobotRecordings(robot, [train])]
    models = {"paper": fit_robots(trained, SolveOptions(method="paper"))[0].calibrated}
    for name, prior in priors.items():
        models[name] = fit_robots(trained, SolveOptions(), types=[prior])[0].calibrated
    return {
        name: 1e3
        * float(np.mean([evaluate(model.ball(m.positions), m).mean_absolute_error for m in test]))
        for name, model in models.items()
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=11)
    parser.add_argument("--samples", type=int, default=10)
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    draws = list(
        read_options(arguments).workers.map(partial(draw, arguments.samples), range(arguments.arms))
    )
    for name in draws[0]:
        values, without = (np.array([row[key] for row in draws]) for key in (name, "none"))
        worst = 100 * (values / without).max() - 100
        print(f"{name:12s} {values.mean():.3f} mm, at worst {worst:+.0f} % against none")


if __name__ == "__main__":
    main()

"""What the elasticity of another arm of the type is worth where samples are few.

    python benchmarks/type_prior.py [--arms 12] [--samples 10]
    python benchmarks/type_prior.py --robots panda --arms 20 --factors 0 0.5 1 3

For each draw a type is drawn, by how much its joints and links bend, and two arms of it, which
differ from that by 15 %. The first is calibrated from two placements of 30 + 30 configurations, the
second from one of few: without what the first tells, with it, with five times as much, and with the
joints in reverse order. Errors are those at three other placements. With ``--factors`` the second
arm bends so many times as much as its type, and errors are over the lesser of those without what
the first tells and without any elasticity.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from functools import partial

import numpy as np
from worlds import TRANSLATION, TURN

from mukca.solver.calibration import SolveOptions, fit_robots
from mukca.solver.identification.data import (
    Measurement,
    evaluate,
    measure,
)
from mukca.solver.identification.model import Deflection, Expected
from mukca.solver.identification.robot import Robot, load_robot
from mukca.solver.results import Measurements
from mukca.solver.studies.uncertainty import deviations
from mukca.tools.cli import WorkerOptions, add_options, read_options
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record


def recordings(
    robot: Robot,
    of_type: dict[str, np.ndarray],
    generator: np.random.Generator,
    samples: list[int],
) -> list[Measurement]:
    """Return recordings of an arm of a type, so many samples in each socket."""
    arm = perturb(robot, generator, TRANSLATION, TURN)
    own = [v * generator.normal(1, 0.15, len(v)).clip(0.2, 2) for v in of_type.values()]
    how = Imperfection(
        generator.uniform(5e-5, 1e-4), Deflection(tuple(of_type), tuple(own))
    )
    bases = reachable_bases(arm, generator, len(samples))
    return [
        measure(record(arm, base, generator, samples=count, imperfection=how), robot)
        for base, count in zip(bases, samples, strict=True)
    ]


def learned(robot: Robot, placements: list[Measurement]) -> dict[str, Expected]:
    """Return what a calibration tells of the elasticity."""
    options = SolveOptions(type_prior=("none",))
    found = fit_robots([Measurements(robot, placements)], options)[0].posterior
    assert found is not None
    return {
        effect.name: Expected(found.x[own], deviations(found)[own])
        for effect, own in zip(found.model.effects, found.model.slices, strict=True)
        if effect.shared_by_type
    }


def draw(robots: list[str], samples: int, case: tuple[int, float]) -> dict[str, float]:
    """Return the errors of an arm elsewhere, with each prior [mm]."""
    seed, factor = case
    robot, generator = (
        load_robot(robots[seed % len(robots)]),
        np.random.default_rng(5000 + seed),
    )
    joints = len(robot.joint_names)
    of_type = {
        "compliance": generator.uniform(1e-5, 6e-5, joints),
        "tilt": generator.uniform(0, 3e-5, 2 * joints),
    }
    other = learned(robot, recordings(robot, of_type, generator, [30, 30]))
    second = {name: factor * bends for name, bends in of_type.items()}
    train, *test = recordings(robot, second, generator, [samples, 30, 30, 30])

    def turned(values: np.ndarray) -> np.ndarray:
        return values.reshape(-1, joints)[:, ::-1].ravel()

    priors: dict[str, dict[str, Expected]] = {
        "none": {},
        "of the type": other,
        "five times": {
            name: Expected(5 * mean, 5 * deviation)
            for name, (mean, deviation) in other.items()
        },
        "reversed": {
            name: Expected(turned(mean), turned(deviation))
            for name, (mean, deviation) in other.items()
        },
    }
    trained = [Measurements(robot, [train])]
    ways = {
        "paper": SolveOptions(method="paper"),
        "rigid": SolveOptions(without=tuple(of_type)),
    }
    models = {
        name: fit_robots(trained, way)[0].calibrated for name, way in ways.items()
    }
    for name, prior in priors.items():
        models[name] = fit_robots(trained, SolveOptions(), types=[prior])[0].calibrated
    return {
        name: 1e3
        * float(
            np.mean(
                [evaluate(model.ball(m.positions), m).mean_absolute_error for m in test]
            )
        )
        for name, model in models.items()
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=11)
    parser.add_argument("--samples", type=int, default=10)
    parser.add_argument("--robots", nargs="+", default=["panda", "iiwa14", "ur5e"])
    parser.add_argument("--factors", nargs="+", type=float, default=[1.0])
    add_options(parser, WorkerOptions)
    arguments = parser.parse_args()
    errors, workers = (
        partial(draw, arguments.robots, arguments.samples),
        read_options(arguments),
    )
    for factor in arguments.factors:
        draws = list(
            workers.workers.map(errors, [(i, factor) for i in range(arguments.arms)])
        )
        mean = {name: float(np.mean([row[name] for row in draws])) for name in draws[0]}
        ratio = mean["of the type"] / min(mean["none"], mean["rigid"])
        print(
            f"{factor:g} times the type: over the better of none and rigid {ratio:.3f}"
        )
        for name in draws[0]:
            worst = 100 * max(row[name] / row["none"] for row in draws) - 100
            print(
                f"{name:12s} {mean[name]:.3f} mm, at worst {worst:+.0f} % against none",
                flush=True,
            )


if __name__ == "__main__":
    main()

"""What the exported URDF holds: as near to the full model as a URDF can be where it is used."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.auto.closest_rigid import closest_rigid
from mukca.solver.auto.deflection import Deflection
from mukca.solver.auto.estimation import estimate
from mukca.solver.auto.extended_model import extend
from mukca.solver.auto.posterior import Posterior
from mukca.solver.data.load import Load
from mukca.solver.data.measurements import measure
from mukca.solver.data.metrics import evaluate
from mukca.solver.data.observe import observe
from mukca.solver.fit import fit_by_auto, fit_by_paper
from mukca.solver.robot.kinematics import workspace
from mukca.solver.robot.parameters import choose_parameters
from mukca.solver.robot.urdf import Robot
from mukca.tools.simulated_arms import Imperfection, reachable_bases, record

ELASTIC = Deflection(("compliance", "tilt"), (np.full(7, 4e-5), np.full(14, 2e-5)))


@pytest.fixture(scope="module")
def recorded(panda: Robot, true_panda: Robot):
    generator = np.random.default_rng(0)
    how = Imperfection(noise=7e-5, deflection=ELASTIC)
    bases = reachable_bases(true_panda, generator, 4)
    return [measure(record(true_panda, base, generator, imperfection=how), panda) for base in bases]


@pytest.mark.slow
def test_it_is_better_than_the_papers_geometry_elsewhere(panda: Robot, recorded) -> None:
    parameters, (train, *test) = choose_parameters(panda), recorded
    by_auto = fit_by_auto(panda, parameters, [train]).calibrated
    by_paper = fit_by_paper(panda, parameters, [train]).calibrated
    assert by_auto.deflection.extensions
    errors = [
        np.mean([evaluate(robot.geometric_ball(m.positions), m).mean_absolute_error for m in test])
        for robot in (by_auto, by_paper)
    ]
    assert errors[0] < errors[1]


@pytest.mark.slow
def test_a_rigid_arm_is_its_own_closest(panda: Robot, true_panda: Robot) -> None:
    """Where nothing bends, the URDF predicts the same distances as the full model."""
    generator = np.random.default_rng(0)
    (base,) = reachable_bases(true_panda, generator, 1)
    placement = record(true_panda, base, generator, samples=15, noise=1e-6)
    data = observe([measure(placement, panda)], panda)
    full = estimate(extend(panda, choose_parameters(panda), ("compliance",)), data)
    q = workspace(panda, 30)
    points = [
        full.model.ball.points(values, q) for values in (full.values, closest_rigid(full, Load()))
    ]
    apart = [np.linalg.norm(p[:, None] - p, axis=2) for p in points]
    assert np.abs(apart[0] - apart[1]).max() < 1e-4


@pytest.fixture(scope="module")
def full(panda: Robot, recorded) -> Posterior:
    """What one placement tells of the arm, by a model without extensions."""
    return estimate(extend(panda, choose_parameters(panda)), observe(recorded[:1], panda))


def turned(full: Posterior, size: float) -> np.ndarray:
    """Return the geometry of a fit with all angles changed at random [rad]."""
    values, generator = full.values.copy(), np.random.default_rng(0)
    free = [i for i, p in enumerate(full.model.parameters) if p.unit == "rad" and not p.of_ball]
    values[free] += size * generator.normal(0, 1, len(free))
    return values


def test_what_the_full_model_is_not_sure_of_stays_the_samples_own(full: Posterior) -> None:
    alone = turned(full, 3e-4)
    unsure = replace(full, covariance=1e4 * full.covariance)
    assert np.array_equal(closest_rigid(unsure, Load(), alone), alone)
    assert np.array_equal(closest_rigid(full, Load(), turned(full, 1e-6)), turned(full, 1e-6))
    assert not np.array_equal(closest_rigid(full, Load(), alone), alone)


def test_the_surer_the_full_model_the_further_it_is_followed(full: Posterior) -> None:
    alone = turned(full, 1e-3)
    nearness: list[float] = []
    for doubt in (1e-2, 1.0, 1e2):
        more = replace(full, covariance=doubt * full.covariance)
        q = workspace(full.model.robot, 50)
        points = [
            full.model.ball.points(values, q)
            for values in (alone, closest_rigid(more, Load(), alone), full.values)
        ]
        nearness.append(
            float(np.linalg.norm(points[1] - points[2]) / np.linalg.norm(points[0] - points[2]))
        )
    assert nearness[0] < nearness[1] < nearness[2]

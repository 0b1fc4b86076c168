"""What the exported URDF holds: as near to the full model as a URDF can be where it is used."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.bayes.inference import Posterior, estimate
from mukca.solver.bayes.model import Deflection, extend
from mukca.solver.bayes.results import project_to_geometry
from mukca.solver.bayes.results.geometric_projection import CONFIDENCE, _doubt, _sure
from mukca.solver.bayes.results.projection_poses import simulated_poses
from mukca.solver.calibration import fit_by_auto
from mukca.solver.calibration.fit import fit_by_paper
from mukca.solver.data import Load, evaluate, measure, observe
from mukca.solver.robot import BallModel, Robot, choose_parameters, workspace
from mukca.tools.simulation import Imperfection, reachable_bases, record

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
        full.model.ball.points(values, q)
        for values in (full.values, project_to_geometry(full, Load()))
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
    steps = [np.linalg.norm(project_to_geometry(f, Load(), alone) - alone) for f in (unsure, full)]
    assert steps[0] < 0.01 * steps[1]


def test_the_samples_own_has_the_larger_share_where_both_hardly_differ(full: Posterior) -> None:
    """For then the difference is mostly chance, however sure the full model is of itself."""
    sure = replace(full, covariance=1e-6 * full.covariance)
    shares = [
        np.linalg.norm(project_to_geometry(sure, Load(), alone) - alone)
        / np.linalg.norm(full.values - alone)
        for alone in (turned(full, size) for size in (1e-5, 1e-4, 1e-2))
    ]
    assert shares[0] < 0.1 < shares[1] < 0.9 < shares[2]


def test_which_places_are_imagined_is_a_doubt_too(full: Posterior) -> None:
    alone, nothing = turned(full, 1e-3), 0 * full.covariance
    certain = replace(full, covariance=nothing)
    doubts = [_doubt(one, Load(), simulated_poses(one, Load()), alone) for one in (certain, full)]
    assert 0 < np.trace(doubts[0]) < np.trace(doubts[1])


def test_the_surer_the_full_model_the_further_it_is_followed(full: Posterior) -> None:
    alone = turned(full, 1e-3)
    nearness: list[float] = []
    for doubt in (1e-2, 1.0, 1e2):
        more = replace(full, covariance=doubt * full.covariance)
        q = workspace(full.model.robot, 50)
        points = [
            full.model.ball.points(values, q)
            for values in (alone, project_to_geometry(more, Load(), alone), full.values)
        ]
        nearness.append(
            float(np.linalg.norm(points[1] - points[2]) / np.linalg.norm(points[0] - points[2]))
        )
    assert nearness[0] < nearness[1] < nearness[2]


def test_a_sure_step_is_the_best_one() -> None:
    """No change near it makes s^T H s - 2 s^T g + 2 CONFIDENCE sqrt(s^T U s) less."""
    generator = np.random.default_rng(0)
    moved = 0
    for _ in range(30):
        root, other = generator.normal(size=(2, 6, 6))
        H, U = root @ root.T + 0.1 * np.eye(6), 0.3 * other @ other.T + 0.1 * np.eye(6)
        g = generator.normal(0, 3, 6)

        def cost(s: np.ndarray, H: np.ndarray = H, g: np.ndarray = g, U: np.ndarray = U) -> float:
            return float(s @ H @ s - 2 * s @ g + 2 * CONFIDENCE * np.sqrt(s @ U @ s))

        step = _sure(H, g, U)
        others = step + generator.normal(0, 1, (200, 6)) * generator.choice([1e-4, 0.1], (200, 1))
        assert min(map(cost, others)) > cost(step) - 1e-9
        assert np.array_equal(_sure(H, g, 1e6 * U), np.zeros(6))
        assert _sure(H, g, 0 * U) == pytest.approx(np.linalg.solve(H, g))
        moved += step.any()
    assert moved > 5


@pytest.mark.slow
def test_where_an_arm_bends_each_direction_goes_as_far_as_is_sure(panda: Robot, recorded) -> None:
    """And no place at all is a reason to change nothing."""
    parameters, data = choose_parameters(panda), observe(recorded[:1], panda)
    full = estimate(extend(panda, parameters, ("compliance", "tilt")), data)
    alone = fit_by_paper(panda, parameters, recorded[:1]).calibrated.values
    steps = [
        np.linalg.norm(project_to_geometry(more, Load(), alone) - alone)
        for more in (replace(full, covariance=k * full.covariance) for k in (0.01, 1, 1e6))
    ]
    assert steps[0] > steps[1] > steps[2] == 0
    nowhere = replace(panda, joints=tuple(replace(j, upper=j.lower) for j in panda.joints))
    unmoved = replace(full, model=extend(nowhere, parameters, ("compliance", "tilt")))
    assert np.array_equal(project_to_geometry(unmoved, Load(), alone), alone)


@pytest.mark.slow
@pytest.mark.parametrize("deflection", [ELASTIC, Deflection()])
def test_a_distance_that_is_hardly_known_does_not_set_the_size(
    panda: Robot, true_panda: Robot, deflection: Deflection
) -> None:
    """The paper's cost takes it as it is; so its geometry is not what the URDF has."""
    generator = np.random.default_rng(0)
    how = Imperfection(noise=7e-5, deflection=deflection)
    (base,) = reachable_bases(true_panda, generator, 1)
    placement = record(true_panda, base, generator, imperfection=how)
    train = [replace(measure(placement, panda), distance=0.051)]
    found = fit_by_auto(panda, choose_parameters(panda), train, distance_deviation=1e-3).calibrated
    q = workspace(panda, 60)
    true, exported = (
        np.linalg.norm(points[1::2] - points[::2], axis=1).sum()
        for points in (BallModel(true_panda, []).points(np.empty(0), q), found.geometric_ball(q))
    )
    assert exported / true == pytest.approx(1, abs=4e-3)

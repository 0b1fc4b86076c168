"""Balls that an instrument measured, alone and together with sockets."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.recorder.dataset import Placement
from mukca.solver.bayes.inference import estimate, estimate_all
from mukca.solver.bayes.inference.normal_equations import (
    leverage,
    normal_equations,
    predicted_errors,
)
from mukca.solver.bayes.inference.objective import build_objective, linearise
from mukca.solver.bayes.inference.state import start
from mukca.solver.bayes.model import Noise, as_arms, as_scene, extend
from mukca.solver.data import FrameError, Pose, evaluate, measure, observe
from mukca.solver.data.measurements import MeasurementError
from mukca.solver.robot import (
    BallModel,
    Robot,
    choose_parameters,
    load_robot,
    shipped_robots,
    workspace,
)
from mukca.tools.simulation import measured_points, perturb, random_pose, reachable_bases, record


def balls(robot: Robot, q: np.ndarray) -> np.ndarray:
    return BallModel(robot, []).points(np.empty(0), q)


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_robots())
def test_exact_points_give_the_arm_and_the_frame_back(name: str) -> None:
    """Where the tool is in the instrument's frame, and all distances, to a nanometre."""
    robot, generator = load_robot(name), np.random.default_rng(1)
    arm, frame = perturb(robot, generator, 2e-3, 5e-3), random_pose(generator)
    placement = measured_points(arm, frame, generator, samples=40)
    data = as_scene(observe([measure(placement, robot)], robot))
    found = estimate_all(as_arms(extend(robot, choose_parameters(robot))), data)
    q = workspace(robot, 50, 5)
    predicted = found.arms[0].predict(q, np.zeros_like(q))
    seen = found.frames["instrument"].inverse().apply(predicted)
    assert np.abs(seen - frame.inverse().apply(balls(arm, q))).max() < 1e-9


@pytest.fixture(scope="module")
def both(panda: Robot, true_panda: Robot) -> tuple[Placement, Placement, Pose]:
    """A placement of sockets, and one of points."""
    generator = np.random.default_rng(4)
    (base,) = reachable_bases(true_panda, generator, 1)
    frame = random_pose(generator)
    return (
        record(true_panda, base, generator, samples=12, noise=5e-5),
        measured_points(true_panda, frame, generator, samples=30, noise=2e-5),
        frame,
    )


@pytest.mark.slow
def test_normal_equations_of_sockets_and_points_are_those_of_the_whole_jacobian(
    both: tuple[Placement, Placement, Pose], panda: Robot
) -> None:
    seated, points, _ = both
    data = observe([measure(points, panda), measure(seated, panda)], panda)
    objective = build_objective(extend(panda, choose_parameters(panda)), data)
    state = start(objective, joint_noise=True)
    normal = normal_equations(objective, state)
    sockets = objective.rows.sockets
    by_centres = np.zeros((len(sockets), 3, 6))
    for i, socket in enumerate(sockets.tolist()):
        if socket >= 0:
            by_centres[i, :, 3 * socket : 3 * socket + 3] = -np.eye(3)
    whole = np.concatenate([state.linear.by_unknowns, by_centres], axis=2)
    weights = normal.weights[:, None, None] * normal.inverse_scales
    size = objective.dense
    curvature = Noise(1.0, 0.0).information * np.einsum("nia,nij,njb->ab", whole, weights, whole)
    information = normal.information
    columns = [information.times(unit)[:size] for unit in np.eye(objective.size)]
    assert np.transpose(columns) == pytest.approx(curvature[:size], rel=1e-9, abs=1e-3)
    generator = np.random.default_rng(1)
    covariance = information.plus(1e3 * np.eye(size)).inverse(np.ones(size, dtype=bool))
    expected = whole @ covariance.whole() @ whole.transpose(0, 2, 1)
    assert leverage(objective, state, covariance) == pytest.approx(expected, rel=1e-6)
    change = generator.normal(0, 1e-6, objective.size)
    n = objective.model.size
    frames = (state.frames[0].moved(change[n:size]),)
    centres = state.centres + change[size:].reshape(-1, 3)
    moved = linearise(objective, state.x + change[:n], centres, frames)
    assert predicted_errors(objective, state, change) == pytest.approx(moved.errors, abs=1e-9)


@pytest.mark.slow
def test_sockets_and_points_together_know_each_its_own_noise(
    both: tuple[Placement, Placement, Pose], panda: Robot, true_panda: Robot
) -> None:
    seated, points, _ = both
    data = observe([measure(seated, panda), measure(points, panda)], panda)
    model = extend(panda, choose_parameters(panda))
    found = estimate(model, data, joint_noise=False)
    assert found.measured_noise is not None
    assert found.noise.space == pytest.approx(5e-5, rel=0.4)
    assert found.measured_noise.space == pytest.approx(2e-5, rel=0.4)
    held = measured_points(
        true_panda, random_pose(np.random.default_rng(9)), np.random.default_rng(8)
    )
    measured = measure(held, panda)

    def error(placements: list[Placement]) -> float:
        one = estimate(model, observe([measure(p, panda) for p in placements], panda))
        return evaluate(one.predict(measured.positions, measured.positions), measured).max_error

    assert error([seated, points]) < min(error([seated]), 3e-4)


def test_leaving_points_out_leaves_the_sockets(
    both: tuple[Placement, Placement, Pose], panda: Robot
) -> None:
    seated, points, _ = both
    data = observe([measure(points, panda), measure(seated, panda)], panda)
    left = data.without([points.name])
    assert left.instrument is None and len(left.positions) == len(seated.samples)
    other = data.without([seated.name])
    assert other.labels == () and (other.sockets == -1).all() and not other.known


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p: (1e3 * p[0], 1e3 * p[1], 1e3 * p[2]), "millimetres"),
        (lambda p: (p[0], -p[1], p[2]), "mirrored"),
        (lambda _: (0.1, 0.2, 0.3), "are all the same"),
    ],
)
def test_points_in_other_units_or_hands_are_refused(
    both: tuple[Placement, Placement, Pose], panda: Robot, change, words: str
) -> None:
    points = both[1]
    wrong = replace(
        points, samples=tuple(replace(s, point=change(s.point)) for s in points.samples)
    )
    with pytest.raises(FrameError, match=words):
        estimate(extend(panda, choose_parameters(panda)), observe([measure(wrong, panda)], panda))


def test_too_few_points_are_refused(both: tuple[Placement, Placement, Pose], panda: Robot) -> None:
    points = both[1]
    with pytest.raises(MeasurementError, match="3 measured points; at least 4"):
        measure(replace(points, samples=points.samples[:3]), panda)
    with pytest.raises(MeasurementError, match="all 9 points are of one configuration"):
        measure(replace(points, samples=points.samples[:1] * 9), panda)


@pytest.mark.slow
def test_what_is_stated_of_measured_points_is_what_gaussian_noise_leaves(
    panda: Robot, true_panda: Robot
) -> None:
    """Such errors show that they have no tails; to claim more than they tell would be too sure."""
    generator = np.random.default_rng(3)
    placement = measured_points(
        true_panda, random_pose(generator), generator, samples=900, noise=1e-4
    )
    scene = as_scene(observe([measure(placement, panda)], panda))
    arms = as_arms(extend(panda, choose_parameters(panda)))
    found = estimate_all(arms, scene, joint_noise=False)
    x, frames = found.arms[0].x, tuple(found.frames.values())
    J = linearise(build_objective(arms, scene), x, np.zeros((0, 3)), frames).by_unknowns
    free = np.flatnonzero(np.diag(found.covariance))
    all_there_is = np.trace(np.einsum("nia,nib->ab", J, J)[np.ix_(free, free)]) / 1e-4**2
    stated = np.trace(np.linalg.inv(found.covariance[np.ix_(free, free)]))
    assert stated / all_there_is == pytest.approx(1, abs=0.03)

"""The estimation where it is stretched: with hardly any samples, and with thousands."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.recorder.dataset import Placement
from mukca.solver.bayes.inference import estimate, estimate_all
from mukca.solver.bayes.inference.map_estimate import _advance, gauss_newton
from mukca.solver.bayes.inference.normal_equations import (
    leverage,
    normal_equations,
    predicted_errors,
)
from mukca.solver.bayes.inference.objective import build_objective, linearise
from mukca.solver.bayes.inference.state import start
from mukca.solver.bayes.model import Deflection, Noise, extend
from mukca.solver.bayes.results import workspace_deviation
from mukca.solver.bayes.selection.model_selection import select_model
from mukca.solver.data import Load, Observations, measure, observe
from mukca.solver.paper import NotConverged
from mukca.solver.robot import BallModel, Robot, choose_parameters, load_robot
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record


def misread(placement: Placement, generator: np.random.Generator, angle: float) -> Placement:
    """A placement whose joints were read with so much noise [rad]."""
    shifts = generator.normal(0, angle, placement.positions.shape)
    samples = tuple(
        replace(sample, position=tuple((np.array(sample.position) + shift).tolist()))
        for sample, shift in zip(placement.samples, shifts, strict=True)
    )
    return replace(placement, samples=samples)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [7, 10])
def test_no_variance_is_negative_where_a_width_collapses(seed: int) -> None:
    """Five samples a socket of a gear with 5 mrad of noise."""
    generator = np.random.default_rng(seed)
    robot = load_robot("gen3_lite")
    arm = perturb(robot, generator, 2e-3, 5e-3)
    (base,) = reachable_bases(arm, generator, 1)
    placement = misread(record(arm, base, generator, samples=5, noise=1e-4), generator, 5e-3)
    data = observe([measure(placement, robot)], robot)
    posterior = estimate(extend(robot, choose_parameters(robot)), data)
    assert np.isfinite(posterior.covariance).all()
    assert np.linalg.eigvalsh(posterior.covariance).min() > -1e-12
    assert np.isfinite(workspace_deviation(posterior, Load())).all()


def again(data: Observations, times: int) -> Observations:
    """Every sample many times, a hundredth of a millimetre off."""
    order = np.argsort(np.tile(data.sockets, times), kind="stable")
    shifts = np.random.default_rng(0).normal(0, 1e-5, (times * len(data.positions), 7))
    return replace(
        data,
        positions=(np.tile(data.positions, (times, 1)) + shifts)[order],
        torques=np.tile(data.torques, (times, 1))[order],
        sockets=np.tile(data.sockets, times)[order],
    )


@pytest.fixture(scope="module")
def front(session, panda: Robot, true_panda: Robot) -> tuple[Observations, Robot]:
    generator = np.random.default_rng(3)
    (base,) = reachable_bases(true_panda, generator, 1)
    placement = record(true_panda, base, generator, samples=120, noise=1e-4)
    return observe([measure(placement, panda)], panda), panda


@pytest.mark.slow
def test_thousands_of_samples_do_not_blow_the_robot_up(front) -> None:
    data, panda = front
    model = extend(panda, choose_parameters(panda))
    few, many = (estimate(model, d) for d in (data, again(data, 9)))
    assert many.noise.space == pytest.approx(few.noise.space, rel=0.1)
    assert abs(model.by_scale() @ (many.x - few.x)) < 2e-3
    errors = [float(np.median(np.linalg.norm(p.residuals, axis=1))) for p in (few, many)]
    assert errors[1] == pytest.approx(errors[0], rel=0.1)


def test_no_width_follows_unknowns_that_are_far_astray(front) -> None:
    """Or of a hundred thousand samples it would be 100 rad after three steps, for good."""
    data, panda = front
    objective = build_objective(extend(panda, choose_parameters(panda)), again(data, 3))
    state, held = start(objective, joint_noise=False), list[bool]()
    for _ in range(8):
        step = gauss_newton(objective, state)
        after = _advance(objective, state, step)[0]
        held.append(after.groups == state.groups)
        assert held[-1] == (-step.slope > objective.size)
        state = after
    assert held[0]
    assert not held[-1]


@pytest.mark.slow
def test_a_noise_that_does_not_fit_yet_leaves_the_size_alone(front) -> None:
    """Or the size and the noise would drive each other, the faster the more samples there are."""
    data, panda = front
    model = extend(panda, choose_parameters(panda))
    found = estimate(model, data)
    loose = tuple(replace(known, deviation=1e-3) for known in data.known)
    objective = build_objective(model, replace(again(data, 10), known=loose))
    state = start(objective, joint_noise=False)
    linear = linearise(objective, found.x, found.centres)
    state = replace(state, x=found.x, centres=found.centres, groups=found.groups, linear=linear)
    by_scale = model.by_scale()
    steps = [
        gauss_newton(objective, replace(state, noises=(replace(found.noise, space=space),)))
        for space in (0.9 * found.noise.space, 1.1 * found.noise.space)
    ]
    sizes = [float(by_scale @ step.change[: model.size]) for step in steps]
    assert abs(sizes[1] - sizes[0]) < 3e-4
    assert steps[0].volume > 1 > steps[1].volume


def test_the_volume_of_the_swept_ball_is_that_of_its_jacobian(panda: Robot) -> None:
    """At random poses, against determinants; its slopes against finite differences."""
    model = BallModel(panda, [p.index for p in choose_parameters(panda)])
    q = np.random.default_rng(0).uniform(-1, 1, (5, 7))
    value, slope, by_joints = model.log_volume(model.nominal, q)
    J = model.linearise(model.nominal, q).by_joints
    assert value == pytest.approx(np.mean(0.5 * np.log(np.linalg.det(J @ J.transpose(0, 2, 1)))))
    for i in range(len(slope)):
        step = np.zeros(len(slope))
        step[i] = 1e-6
        ahead, behind = (model.log_volume(model.nominal + s, q)[0] for s in (step, -step))
        assert slope[i] == pytest.approx((ahead - behind) / 2e-6, abs=1e-6)
    for i, turn in enumerate(1e-6 * np.eye(7)):
        ahead, behind = (model.log_volume(model.nominal, q + s)[0] for s in (turn, -turn))
        assert by_joints[i] == pytest.approx((ahead - behind) / 2e-6, abs=1e-6)


def test_normal_equations_are_those_of_the_whole_jacobian(front) -> None:
    """Put together socket by socket, they equal what one large Jacobian gives."""
    data, panda = front
    model = extend(panda, choose_parameters(panda), ("compliance",))
    objective = build_objective(model, data)
    state = start(objective, joint_noise=True)
    normal = normal_equations(objective, state)
    by_centres = np.zeros((len(data.sockets), 3, 3 * data.socket_count))
    for axis in range(3):
        by_centres[np.arange(len(by_centres)), axis, 3 * data.sockets + axis] = -1
    whole = np.concatenate([state.linear.by_unknowns, by_centres], axis=2)
    weights = normal.weights[:, None, None] * normal.inverse_scales
    samples = np.einsum("nia,nij,njb->ab", whole, weights, whole)
    slope = np.einsum("nia,nij,nj->a", whole, weights, state.linear.errors)
    size = model.size
    expected = Noise(1.0, 0.0).information * samples[:size]
    information = normal.information
    columns = [information.times(unit)[:size] for unit in np.eye(objective.size)]
    assert np.transpose(columns) == pytest.approx(expected, rel=1e-9, abs=1e-3)
    turned = (model.ball.turns(model.values(state.x)) != 0).any(axis=0)
    turned = np.flatnonzero(np.r_[turned, np.zeros(size - len(turned), dtype=bool)])
    assert len(turned) == 3
    assert np.delete(normal.gradient[:size], turned) == pytest.approx(
        np.delete(slope[:size], turned), rel=1e-9
    )
    generator = np.random.default_rng(1)
    covariance = information.plus(1e3 * np.eye(size)).inverse(np.ones(size, dtype=bool))
    expected = whole @ covariance.whole() @ whole.transpose(0, 2, 1)
    assert leverage(objective, state, covariance) == pytest.approx(expected, rel=1e-6)
    change = generator.normal(0, 1e-6, objective.size)
    moved = linearise(
        objective, state.x + change[:size], state.centres + change[size:].reshape(-1, 3)
    )
    assert predicted_errors(objective, state, change) == pytest.approx(moved.errors, abs=1e-9)


def test_an_extension_whose_fit_does_not_settle_is_left_out(front, monkeypatch) -> None:
    data, panda = front

    def unsettled(model, observed, **options):
        if model.models[0].extensions:
            raise NotConverged("auto did not settle in 150 iterations")
        return estimate_all(model, observed, **options)

    monkeypatch.setattr("mukca.solver.bayes.selection.model_selection.estimate_all", unsettled)
    selection = select_model(panda, choose_parameters(panda), data)
    assert selection.full is selection.geometric
    assert all("does not settle" in note for note in selection.notes) and len(selection.notes) == 3


@pytest.mark.slow
def test_of_many_placements_some_are_left_out_at_a_time(panda, monkeypatch) -> None:
    """So that the time of a fit grows with their number, not with its square."""
    generator, bends = np.random.default_rng(3), (np.full(7, 1e-4),)
    how = Imperfection(5e-5, Deflection(("compliance",), bends))
    placements = [
        record(panda, base, generator, samples=8, imperfection=how)
        for base in reachable_bases(panda, generator, 3)
    ]
    data = observe([measure(placement, panda) for placement in placements], panda)
    fitted: list[tuple[str, ...]] = []

    def counted(model, observed, **options):
        fitted.append(observed.placements)
        return estimate_all(model, observed, **options)

    monkeypatch.setattr("mukca.solver.bayes.selection.model_selection.estimate_all", counted)
    monkeypatch.setattr("mukca.solver.bayes.selection.model_selection.PARTS", 2)
    chosen = select_model(panda, choose_parameters(panda), data, stages=["compliance"])
    a, b, c = (placement.name for placement in placements)
    assert fitted == [(a, b, c)] * 2 + [(b,), (a, c)] * 2
    assert "where one placement is left out" in chosen.notes[0]

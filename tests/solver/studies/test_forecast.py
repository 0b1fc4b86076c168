"""What is forecast comes true, and what is said of joints and places is what they do."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.design import error_map, joint_effects, predicted_posterior, workspace_samples
from mukca.solver.identification.data import STANDARD_LOAD, RobotRecordings, measure, observe
from mukca.solver.identification.inference import estimate
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import choose_parameters
from mukca.solver.studies import workspace_errors
from mukca.tools.simulation import simulate_recordings

LOAD = STANDARD_LOAD


@pytest.fixture(scope="module")
def recorded(panda):
    _, placements = simulate_recordings(panda, 2, samples=20, seed=5, noise=1e-4)
    return [measure(placement, panda) for placement in placements]


@pytest.fixture(scope="module")
def first(panda, recorded):
    data = observe(RobotRecordings(panda, recorded[:1]))
    return estimate(extend(panda, choose_parameters(panda)), data).arm


@pytest.mark.slow
def test_a_second_placement_brings_what_was_forecast(panda, recorded, first):
    both = estimate(first.model, observe(RobotRecordings(panda, recorded))).arm
    forecast = predicted_posterior(first, LOAD.by_socket(panda, recorded[1]))
    before, expected, found = (workspace_errors(p, LOAD).median for p in (first, forecast, both))
    assert expected < 0.95 * before
    assert found == pytest.approx(expected, rel=0.15)


def test_a_forecast_does_not_hang_on_rounding(panda, recorded, first):
    """Nothing is known of the new sockets, and much of what their samples tell."""
    signs = np.random.default_rng(0).choice([-1, 1], len(first.covariance))
    rounded = first.covariance * (1 + 2e-16 * np.outer(signs, signs))
    forecasts = [
        predicted_posterior(replace(first, covariance=one), LOAD.by_socket(panda, recorded[1]))
        for one in (first.covariance, rounded)
    ]
    errors = [workspace_errors(one, LOAD).median for one in forecasts]
    assert errors[1] == pytest.approx(errors[0], rel=1e-10, abs=0)


def test_recording_the_same_base_again_does_not_tell_its_distance(panda, recorded, first):
    """However often: the caliper's 0.06 % of scale stays."""
    sure = predicted_posterior(first, LOAD.by_socket(panda, recorded[1]))
    for _ in range(20):
        sure = predicted_posterior(sure, LOAD.by_socket(panda, recorded[1]))
    by_scale = first.model.by_scale()
    size = first.model.size
    scale = float(by_scale @ sure.covariance[:size, :size] @ by_scale) ** 0.5
    assert 4e-4 < scale < 7e-4


def test_what_a_joint_moves_the_ball_by_is_what_its_correction_does(panda, recorded):
    model = extend(panda, choose_parameters(panda))
    x = np.zeros(model.size)
    x[model.names.index("panda_joint4.yaw")] = 1e-3
    by_socket = LOAD.by_socket(panda, recorded[0])
    poses = workspace_samples(model, x, LOAD)
    found = {row.joint: row for row in joint_effects(model, x, poses, by_socket)}
    moved = [model.predict(x, rows) - model.predict(0 * x, rows) for rows in by_socket]
    offsets = np.concatenate([shift - shift.mean(axis=0) for shift in moved])
    expected = float(np.mean(np.sum(offsets**2, axis=1))) ** 0.5
    assert found["panda_joint4"].recorded == pytest.approx(expected, rel=1e-2)
    assert found["panda_joint4"].workspace > 1e-5
    assert all(row.recorded == 0 for name, row in found.items() if name != "panda_joint4")


def test_places_are_known_best_where_it_was_recorded(first):
    found = error_map(first, workspace_samples(first.model, first.x, LOAD))
    centre = first.points.mean(axis=0)
    cells = np.array(found.cells)
    away = np.linalg.norm(cells[:, :2] - centre[:2], axis=1)
    near, far = cells[away < 0.3, 2], cells[away > 1.0, 2]
    assert np.median(near) < 0.6 * np.median(far)
    assert (cells[:, 2] > 0).all() and 0.05 < found.width < 0.15

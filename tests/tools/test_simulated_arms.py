"""Synthetic recordings hold what they say: the ball in the socket, within limits and tilt."""

import numpy as np
import pytest
from cases import by_table
from imagined import poses

import mukca
from mukca.solver.identification.data import STANDARD_LOAD
from mukca.solver.identification.model import Deflection
from mukca.solver.identification.robot import BallModel, gravity_moments, load_robot
from mukca.solver.poses import InverseKinematics, SimulationError
from mukca.tools.simulation import Base, Imperfection, record

AT = Base("front", np.array([0.5, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]))


def test_the_ball_of_an_arm_that_bends_is_in_its_socket(true_panda):
    """Though joints twist and tilt under load: predicted from what the encoders read."""
    elastic = Deflection(("compliance", "tilt"), (np.full(7, 5e-5), np.full(14, 3e-5)))
    how = Imperfection(deflection=elastic)
    q = record(true_panda, AT, np.random.default_rng(0), samples=5, imperfection=how).positions
    bent = elastic.true_positions(STANDARD_LOAD.at(true_panda, q))
    balls = BallModel(true_panda, []).points(np.empty(0), bent)
    assert balls == pytest.approx(
        np.repeat(AT.sockets, 5, axis=0), abs=5e-6
    )  # the moments turn a little with what they bend
    stiff = BallModel(true_panda, []).points(np.empty(0), q)
    assert np.abs(stiff - balls).max() > 5e-4


def test_configurations_keep_limits_and_tilt_and_differ(panda):
    pytest.importorskip("pinocchio", reason="the extra simulation is not installed")
    positions = record(panda, AT, np.random.default_rng(0), samples=20).positions
    lower, upper = (np.array([getattr(j, k) for j in panda.actuated]) for k in ("lower", "upper"))
    assert np.all((lower < positions) & (positions < upper))
    assert positions.std(axis=0).min() > 0.1
    necks = poses(panda.text.data.decode(), panda.tip, positions)[:, :3, 2]
    tilts = np.degrees(np.arccos(-necks[:, 2]))
    assert 30 < tilts.max() <= 50 + 1e-4


@pytest.mark.slow
def test_noise_is_as_asked(true_panda):
    placement = record(true_panda, AT, np.random.default_rng(0), samples=150, noise=1e-3)
    balls = BallModel(true_panda, []).points(np.empty(0), placement.positions)
    errors = balls - np.repeat(AT.sockets, 150, axis=0)
    assert errors.std() == pytest.approx(1e-3, rel=0.15)


def test_out_of_reach_is_told(panda):
    far = Base("far", np.array([3.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    with pytest.raises(SimulationError, match="cannot reach"):
        record(panda, far, np.random.default_rng(0), samples=1)


def test_what_only_looks_near_enough_is_told_after_some_rounds(panda):
    guide, in_its_foot = InverseKinematics(panda), np.array([[0.0, 0.0, 0.02]])
    assert np.linalg.norm(in_its_foot) < guide.longest
    with pytest.raises(SimulationError, match=r"cannot reach \[0.0, 0.0, 0.02\]"):
        guide.reach(in_its_foot, np.random.default_rng(0), rounds=2)


@pytest.mark.slow
def test_simulated_recordings_come_with_the_truth(panda):
    truth, placements = mukca.simulate_recordings(panda, 2, samples=4, seed=3, noise=0)
    assert [(p.sockets == k).sum() for p in placements for k in (0, 1)] == [4] * 4
    for placement in placements:
        balls = truth.ball(placement.positions)
        centres = np.array([balls[placement.sockets == k].mean(axis=0) for k in (0, 1)])
        assert balls == pytest.approx(centres[placement.sockets], abs=1e-9)
        assert np.linalg.norm(centres[1] - centres[0]) == pytest.approx(0.05)
    more, _ = mukca.simulate_recordings(panda, 1, samples=2, seed=3)
    other, _ = mukca.simulate_recordings(panda, 1, samples=2, seed=4)
    assert np.array_equal(more.values, truth.values)
    assert not np.array_equal(other.values, truth.values)


def test_a_simulated_arm_may_bend_in_three_axes_and_turn_unevenly(panda):
    sizes = {"compliance": 6e-5, "tilt": 3e-5, "transmission": 2e-4}
    truth, (placement,) = mukca.simulate_recordings(panda, 1, samples=6, seed=3, noise=0, **sizes)
    assert truth.deflection.extensions == ("compliance", "tilt", "harmonic_1", "harmonic_2")
    for coefficients, most in zip(truth.deflection.coefficients, (6e-5, 3e-5), strict=False):
        assert 0.5 * most < coefficients.max() < most and (coefficients >= 0).all()
    spread = {
        bends: max(np.linalg.norm(np.ptp(balls[placement.sockets == k], axis=0)) for k in (0, 1))
        for bends, balls in (
            (True, truth.ball(placement.positions)),
            (False, truth.geometric_ball(placement.positions)),
        )
    }
    # what bends the truth is the weight of links where the nominal arm has them
    assert spread[True] < 5e-5 < 2e-4 < spread[False]
    same, _ = mukca.simulate_recordings(panda, 1, samples=2, seed=3)
    assert np.array_equal(same.values, truth.values)


def test_the_zeros_of_a_simulated_arm_are_in_its_truth():
    robot = load_robot("so101")
    truth, (placement,) = mukca.simulate_recordings(
        robot, 1, samples=4, seed=3, noise=0, zeros=0.05
    )
    (zeros,) = truth.deflection.coefficients
    assert truth.deflection.extensions == ("zero",) and 0.01 < np.std(zeros) < 0.1
    in_socket = placement.positions[placement.sockets == 0]
    assert np.ptp(truth.ball(in_socket), axis=0) == pytest.approx(0, abs=1e-9)
    assert np.ptp(truth.geometric_ball(in_socket), axis=0).max() > 1e-3


@by_table("numbers", "words")
def test_numbers_that_cannot_be_simulated_are_told(panda, numbers, words):
    with pytest.raises(mukca.MukcaError, match=words):
        mukca.simulate_recordings(panda, **numbers)


def test_a_joint_with_play_rests_on_either_side_where_nothing_loads_it():
    """A vertical axis is never loaded; the second joint mostly is, and is turned as told."""
    robot, readings = load_robot("so101"), []
    for play in (0.0, 5e-3):
        _, (placement,) = mukca.simulate_recordings(robot, 1, samples=10, noise=0, play=play)
        readings.append(placement.positions)
    turned = np.diff(readings, axis=0)[0]
    assert turned[:, 0].min() < -1e-3 and turned[:, 0].max() > 1e-3
    torques = gravity_moments(robot, readings[0])[:, 1]
    loaded = np.abs(torques) > 0.1
    assert loaded.any() and (np.sign(turned[:, 1]) == np.sign(torques))[loaded].all()


def test_a_simulated_arm_with_play_sags_and_its_encoders_have_steps():
    robot = load_robot("so101")
    base = Base("anchored", np.array([0.25, 0.0, 0.03]), np.array([0.7, 0.714, 0.0]), 0.15)
    one, sagged, stepped = (
        record(robot, base, np.random.default_rng(1), samples=6, imperfection=how).positions
        for how in (Imperfection(), Imperfection(play=0.02), Imperfection(resolution=0.01))
    )
    assert np.abs(sagged - one) == pytest.approx(0.01)
    torques = gravity_moments(robot, one)[:, : one.shape[1]]
    loaded = np.abs(torques) > 0.05
    assert loaded.sum() > 20
    assert (np.sign(sagged - one) == np.sign(torques))[loaded].all()
    assert stepped / 0.01 == pytest.approx(np.round(stepped / 0.01))

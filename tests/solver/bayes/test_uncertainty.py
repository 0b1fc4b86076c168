"""Stated deviations against draws, and what cannot be identified against the derivatives."""

import numpy as np
import pytest

from mukca.recorder import read_placement
from mukca.solver.bayes.inference import estimate
from mukca.solver.bayes.inference.laplace import _efficiency
from mukca.solver.bayes.model import Noise, degrees_of_freedom, extend
from mukca.solver.bayes.results import predicted_deviation, weakly_identifiable_directions
from mukca.solver.bayes.results.identifiability import _structural
from mukca.solver.bayes.results.uncertainty import (
    correlations,
    deviations,
    distance_deviations,
    effective_parameters,
    observability_index,
    prior_deviations,
)
from mukca.solver.data import measure, observe
from mukca.solver.robot import choose_parameters, gravity_torques, workspace


@pytest.fixture(scope="module")
def found(session, panda):
    data = observe([measure(read_placement(session / n), panda) for n in ("front", "left")], panda)
    return estimate(extend(panda, choose_parameters(panda), ("compliance",)), data)


@pytest.mark.slow
def test_distance_deviations_are_those_of_draws_from_the_posterior(found, panda) -> None:
    q = workspace(panda, 6)
    torque = gravity_torques(panda, q)
    size = found.model.size
    draws = np.random.default_rng(0).multivariate_normal(
        found.x, found.covariance[:size, :size], 1500
    )
    lengths = []
    for x in draws:
        points = found.model.linearise(x, q, torque)[0]
        lengths.append(np.linalg.norm(points[1::2] - points[::2], axis=1))
    assert distance_deviations(found, q, torque)[1] == pytest.approx(
        np.std(lengths, axis=0), rel=0.1
    )


def test_structural_directions_leave_every_ball_in_place(found, panda) -> None:
    """All but the base frame, which moves all balls together."""
    q = workspace(panda, 10)
    model = found.model.ball
    jacobian = model.linearise(found.values, q).by_parameters
    named = _structural(panda, found)
    assert len(named) == 23  # 6 of the base, 3 of the ball, and 2 for each of 7 joints
    assert np.linalg.matrix_rank(np.array([v for _, v in named])) == 23
    for text, vector in named:
        motion = jacobian @ (vector / np.linalg.norm(vector))
        if text != "the base frame":
            assert np.abs(motion).max() < 1e-5, text


def test_what_cannot_be_identified_is_named(found) -> None:
    texts = [direction.text for direction in weakly_identifiable_directions(found)]
    assert "the base frame" in texts
    assert "the ball's orientation" in texts
    assert "sliding along panda_joint3's axis" in texts
    assert all(
        0.5 < direction.deviation <= 1.001 for direction in weakly_identifiable_directions(found)
    )


def test_the_posterior_is_never_wider_than_the_prior(found) -> None:
    assert np.all(deviations(found) <= prior_deviations(found) * 1.001)


def test_more_samples_tell_more(session, panda) -> None:
    measured = [measure(read_placement(session / n), panda) for n in ("front", "left")]
    parameters = choose_parameters(panda)
    one, both = (
        estimate(extend(panda, parameters), observe(data, panda))
        for data in (measured[:1], measured)
    )
    q = workspace(panda, 40)
    torque = gravity_torques(panda, q)
    by_both, by_one = (distance_deviations(p, q, torque)[1].mean() for p in (both, one))
    assert by_both < by_one
    assert observability_index(both) > 0


def test_correlated_pairs_are_beyond_the_limit(found) -> None:
    assert all(abs(value) > 0.9 for _, _, value in correlations(found))


def test_the_predicted_spread_is_about_the_one_found(found, session, panda) -> None:
    held_out = measure(read_placement(session / "right"), panda)
    torque = gravity_torques(panda, held_out.positions)
    points = found.predict(held_out.positions, torque)
    squares = [np.sum((points[r] - points[r].mean(axis=0)) ** 2) for r in held_out.slices]
    rms = (sum(squares) / len(points)) ** 0.5
    by_socket = [(held_out.positions[r], torque[r]) for r in held_out.slices]
    assert predicted_deviation(found, by_socket) == pytest.approx(rms, rel=0.6)


@pytest.mark.parametrize(("nu", "told"), [(5, 1.0), (1e6, 0.889), (3, 1.087)])
def test_how_much_errors_tell_follows_from_their_tails_not_their_size(
    nu: float, told: float
) -> None:
    """By Huber's formula, with its means as integrals over Student's distribution."""
    generator = np.random.default_rng(0)
    squares = generator.chisquare(3, 40_000) / (generator.chisquare(nu, 40_000) / nu)
    assert _efficiency(squares, Noise(1.0, 0.0)) == pytest.approx(told, abs=0.02)
    assert _efficiency(9 * squares, Noise(1.0, 0.0)) == pytest.approx(
        _efficiency(squares, Noise(1.0, 0.0))
    )


@pytest.mark.parametrize("nu", [3.0, 7.0, 12.0, 1e6])
def test_errors_show_how_heavy_their_tails_are(nu: float) -> None:
    """Whatever their size; from 5, as robust as it gets, to 60, which has hardly any."""
    generator = np.random.default_rng(0)
    squares = generator.chisquare(3, 20_000) / (generator.chisquare(nu, 20_000) / nu)
    assert degrees_of_freedom(squares) == pytest.approx(np.clip(nu, 5, 60), rel=0.15)
    assert degrees_of_freedom(1e-6 * squares) == pytest.approx(degrees_of_freedom(squares))


def test_one_ball_beside_its_socket_makes_heavy_tails() -> None:
    squares = np.random.default_rng(0).chisquare(3, 60)
    assert degrees_of_freedom(squares) > 10
    squares[0] = 2000.0
    assert degrees_of_freedom(squares) < 6


def test_the_place_of_the_ball_is_settled_and_its_turn_is_not(found) -> None:
    (ball,) = [group for group in found.groups if group.name == "ball"]
    assert len(ball.members) == 6 and effective_parameters(found, ball) == pytest.approx(3, abs=0.1)
    for group in found.groups:
        assert 0 <= effective_parameters(found, group) <= len(group.members)

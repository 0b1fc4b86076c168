"""How sure the minimum of Eq. (5) is: of the arm's size, as sure as the caliper, and the noise."""

import numpy as np
import pytest
from recorded import PLACES, recorded_at

from mukca.solver.identification.data import CALIPER_DEVIATION, SEAT_DEVIATION, measure
from mukca.solver.identification.model import extend
from mukca.solver.identification.paper import build_problem, covariance, solve


@pytest.fixture(scope="module")
def recordings(panda, true_panda):
    """The same poses, with noise and without."""
    return {
        noise: recorded_at(true_panda, PLACES["front"], 2, samples=15, noise=noise)
        for noise in (0.0, 1e-4, 4e-4)
    }


def size(panda, placement, distance=0.05):
    """Return by how much the arm comes out larger, and the deviation of that."""
    problem = build_problem(panda, [measure(placement, panda, distance)])
    by_scale = extend(panda, problem.parameters, rotation_numbers="rpy").by_scale()
    x = solve(problem).x
    deviation = float(by_scale @ covariance(problem, x) @ by_scale) ** 0.5
    return float(by_scale @ (x - problem.start)), deviation


def test_a_caliper_s_error_makes_the_size_wrong_as_it_really_does(panda, recordings):
    """Without noise, nothing is unsure but what the caliper says, and how the base is seated."""
    off = float(np.hypot(CALIPER_DEVIATION, SEAT_DEVIATION))
    (right, deviation), (longer, _) = (size(panda, recordings[0.0], d) for d in (0.05, 0.05 + off))
    assert deviation == pytest.approx(longer - right, rel=0.03)
    assert 4e-4 < deviation < 7e-4


def test_noise_makes_it_less_sure_as_noise_grows(panda, recordings):
    calm, rough = (size(panda, recordings[noise]) for noise in (1e-4, 4e-4))
    of_noise = [(d**2 - size(panda, recordings[0.0])[1] ** 2) ** 0.5 for _, d in (calm, rough)]
    assert of_noise[1] == pytest.approx(4 * of_noise[0], rel=0.5)
    assert abs(rough[0] - calm[0]) < 3 * rough[1]

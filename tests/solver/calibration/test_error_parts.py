"""The held-out error in three parts: noise, want of data, and what is not in the model."""

import pytest
from error_parts import NOISE, draw
from recorded import RIGID

import mukca

pytestmark = pytest.mark.slow


def test_an_arm_that_lacks_nothing_has_noise_and_want_of_data():
    error, noise, want, lacking, low, _, _ = draw("none", 0.0, 1)
    assert low == 0
    assert noise == pytest.approx(3**0.5 * NOISE, rel=0.3) and want < noise
    assert error**2 == pytest.approx(noise**2 + want**2 + lacking**2)


def test_what_is_not_in_the_model_is_told():
    _, noise, _, lacking, low, high, truth = draw("play", 3e-4, 9)
    assert 0 < low < truth < high and lacking > noise
    assert lacking == pytest.approx(truth, rel=0.3)


def test_the_parts_are_in_the_document_and_in_words():
    robot = mukca.load_robot("ur5e")
    _, placements = mukca.simulate_recordings(robot, 2, samples=10, seed=1)
    parts = mukca.calibrate(robot, placements[:1], placements[1:], **RIGID).document.error_parts
    assert sum(parts.shares) == pytest.approx(1)
    assert f"{1e3 * parts.want_of_data:.2f} falls with more data" in parts.text


def test_nothing_is_said_where_nothing_was_held_out():
    _, placements = mukca.simulate_recordings(mukca.load_robot("ur5e"), 1, samples=8)
    assert (
        mukca.calibrate(mukca.load_robot("ur5e"), placements, **RIGID).document.error_parts is None
    )

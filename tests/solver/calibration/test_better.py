"""Errors of distances before a calibration, which it is held against."""

import numpy as np
import pytest
from recorded import RIGID

import mukca
from mukca.solver.calibration import document


@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_a_ball_refitted_far_off_makes_no_case_for_a_calibration(
    panda, session, monkeypatch, shift
):
    """The ball of the calibration is then the better one, as if no other had been fitted."""
    (front,) = mukca.read_placements(session / "front")

    def before(refitted):
        monkeypatch.setattr(document, "ball_refitted", lambda problem: refitted)
        return mukca.calibrate(panda, front, **RIGID).document.better.workspace.before

    place = np.array(panda.ball_joint.origin.xyz) + shift
    refitted = before(tuple(place.tolist()))
    by_calibration = before(None)
    assert refitted.value <= by_calibration.value
    if shift:
        assert refitted == by_calibration

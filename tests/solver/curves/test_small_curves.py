"""Joint error curves: none where nothing promises them, and how many numbers data decide."""

from pathlib import Path

import numpy as np
import pytest

import mukca
from mukca.solver.curves import with_joint_curves
from mukca.solver.curves.curve_estimate import curve_group
from mukca.solver.curves.curve_prior import CurvePrior, add_blocks
from mukca.solver.identification.data import RobotRecordings, measure, observe
from mukca.solver.identification.effects import KNOTS
from mukca.solver.identification.inference import estimate
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import choose_parameters

CRANE = Path(__file__).parents[1] / "identification/robot/crane.urdf"


def test_curves_that_promise_nothing_are_not_sought():
    robot = mukca.load_robot("so101")
    _, placements = mukca.simulate_recordings(robot, 2, samples=5, seed=5)
    recordings = RobotRecordings(robot, [measure(p, robot) for p in placements])
    posterior = estimate(extend(robot, choose_parameters(robot)), observe(recordings))
    result, words = with_joint_curves(posterior, None, str)
    assert result is posterior and "they would not raise the evidence" in words


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_data_decide_what_the_prior_alone_would_not_leave(share):
    """Of the joint that turns; one that slides has no curve."""
    model, prior = extend(mukca.load_robot(CRANE), []), CurvePrior(1e-3, 0.07)
    covariance = np.zeros((2 * KNOTS, 2 * KNOTS))
    add_blocks(covariance, (1 - share) * prior.block)
    knots = np.arange(2 * KNOTS).reshape(KNOTS, 2)
    assert curve_group(model, knots, prior, covariance).effective == pytest.approx(
        share * KNOTS, abs=1e-3
    )

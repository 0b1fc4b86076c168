"""A calibration does not depend on how the frames of a URDF's links are drawn."""

from functools import cache

import numpy as np
import pytest

import mukca
from mukca.solver.identification.robot import BallModel, gravity_moments, load_robot, workspace
from tests.turned_frames import turned_frames

ROBOTS = ("panda", "lite6")  # the second has a joint with a pitch of 90 degrees
BENDING = {"compliance": 1e-4, "tilt": 1e-4, "samples": 12, "rotation": 4e-3}


@cache
def calibrations(name):
    """A calibration by the shipped frames, and one by turned frames, of the same recordings."""
    robot = load_robot(name)
    _, (*train, test) = mukca.simulate_recordings(robot, 3, seed=2, **BENDING)
    arms = robot, turned_frames(robot)
    # harmonics and curves turn joints about their own axes, however frames are drawn
    without = ("transmission", "curves")
    return [mukca.calibrate(arm, train, test=[test], without=without) for arm in arms]


@pytest.mark.parametrize("name", ["panda", "lite6", "ur5e", "gen3_lite", "so101", "wxai"])
def test_turned_frames_leave_the_arm_as_it_is(name):
    robot = load_robot(name)
    other, q = turned_frames(robot), workspace(robot, 20)
    points = [BallModel(arm, []).points(np.zeros(0), q) for arm in (robot, other)]
    assert np.abs(points[0] - points[1]).max() < 1e-12
    moments = [gravity_moments(arm, q) for arm in (robot, other)]
    assert np.abs(np.abs(moments[0]) - np.abs(moments[1])).max() < 1e-9


@pytest.mark.parametrize("name", ROBOTS)
def test_predictions_and_evidence_stay(name):
    first, second = calibrations(name)
    q = workspace(first.robot, 100)
    assert first.calibrated.deflection.extensions == second.calibrated.deflection.extensions
    assert np.abs(first.ball(q) - second.ball(q)).max() < 1e-9
    alone = [c.calibrated.geometric_ball(q) for c in (first, second)]
    assert np.abs(alone[0] - alone[1]).max() < 1e-9
    logs = [c.document.log_evidence for c in (first, second)]
    assert logs[0] == pytest.approx(logs[1], abs=1e-6)


def told(hypotheses):
    """Names, probabilities and sizes of explanations, but what they say of a URDF's numbers."""
    keys = ("joint", "placement", "offset", "size")
    return [
        (h.name, f"{h.probability:.3f}", *(h.parameters.get(key) for key in keys))
        for h in hypotheses
    ]


@pytest.mark.parametrize("name", ROBOTS)
def test_verdict_and_causes_stay(name):
    first, second = calibrations(name)
    assert first.verdict.title == second.verdict.title
    causes = [told(c.document.hypotheses) for c in (first, second)]
    assert [c[:3] for c in causes[0]] == [c[:3] for c in causes[1]]
    for one, other in zip(*causes, strict=True):
        for a, b in zip(one[3:], other[3:], strict=True):
            assert a is b or a == b or abs(abs(a) - abs(b)) < 1e-9

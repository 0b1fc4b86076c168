"""The controller as a motion shows it: Eqs. (6) to (8), from the positions in the log alone."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra simulation is not installed")
pytest.importorskip("pinocchio", reason="the extra simulation is not installed")

import pinocchio as pin

from mukca.tools.experiments import Settings, model_urdf, run_experiment
from mukca.tools.simulation import demo_arm

pytestmark = pytest.mark.slow

K = np.array([15000.0, 15000.0, 2000.0, 40.0, 40.0, 40.0])
FRICTION, ROTOR_INERTIA = 0.2, 0.1
"""Of each joint [N m] and of each motor [kg m^2]."""
INTERVAL = 1 / 200
"""Between rows of a log [s]."""


@pytest.fixture(scope="module")
def arm():
    """The true arm's URDF and its tip: the controller is given the arm as it is."""
    nominal, true = demo_arm(keep_size=False)
    return model_urdf("true", nominal, true, 0), true


@pytest.fixture(scope="module")
def log(arm):
    urdf, true = arm
    run = run_experiment(Settings(1, 0, hole=0.0104), true, "true", urdf, lambda _: None)
    return run.trials[0].log


def test_the_compensator_is_off_but_just_before_the_insertion(log):
    np.testing.assert_array_equal(log.offset[log.during("approach", "insert", "rest")], 0)
    assert list(dict.fromkeys(log.phase)) == ["approach", "compensate", "insert", "rest"]
    ramp = np.abs(log.offset[log.during("compensate")]).max(axis=1)
    assert len(ramp) == round(5 / INTERVAL)
    assert 0 < ramp[0] < 0.5 * ramp[-1]
    assert np.abs(np.diff(ramp)).max() < 0.1 * ramp[-1]


def test_the_compensator_integrates_the_spring(log):
    # Eq. (8): the integral's rate, by the stiffness, is the distance to a goal that stands still.
    rows = log.during("compensate")
    tip = (log.tip[rows][1:] + log.tip[rows][:-1]) / 2
    goal = tip + np.diff(log.offset[rows, :3], axis=0) / INTERVAL / K[:3]
    assert np.ptp(tip, axis=0).max() > 1e-3
    assert np.ptp(goal, axis=0).max() < 2e-6


def test_spring_and_damper_lead_the_tool_along_a_straight_line(log, arm):
    """By Eqs. (6) and (7) a motion without contact tells the goal that it was led to.

    With the model true, C dq + g cancel: (M + rotors) ddq + friction is J' (K e - D J dq).
    """
    urdf, true = arm
    model = pin.buildModelFromXML(urdf.decode())
    data, tip = model.createData(), model.getFrameId(true.tip)
    rows = log.during("approach")
    q, positions = log.q[rows], log.tip[rows]
    dq = (q[2:] - q[:-2]) / (2 * INTERVAL)
    ddq = np.diff(q, 2, axis=0) / INTERVAL**2
    goals = []
    for x, v, a, place in zip(q[1:-1], dq, ddq, positions[1:-1], strict=True):
        J = pin.computeFrameJacobian(model, data, x, tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        upper = np.triu(pin.crba(model, data, x))
        inertia = upper + np.triu(upper, 1).T + ROTOR_INERTIA * np.eye(7)
        torque = inertia @ a + FRICTION * np.tanh(v / 1e-3)
        # Nothing but friction, which is not sharply known near rest, acts on the null space.
        assert abs(np.linalg.svd(J)[2][-1] @ torque) < 0.1
        wrench = np.linalg.lstsq(J.T, torque, rcond=None)[0] + 2 * np.sqrt(K) * (J @ v)
        goals.append(place + wrench[:3] / K[:3])
    t = np.arange(2, len(rows)) / len(rows)
    minimum_jerk = t**3 * (10 - 15 * t + 6 * t**2)
    line = positions[0] + minimum_jerk[:, None] * (goals[-1] - positions[0])
    assert np.abs(positions[1:-1] - line).max() > 1e-3
    assert np.abs(np.array(goals) - line)[20:-20].max() < 1e-4

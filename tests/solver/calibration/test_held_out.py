"""What is held out is measured, and never touches the fit."""

from dataclasses import replace

import numpy as np
import pytest
from altered import moved
from recorded import PLACES, RIGID, recorded_at

import mukca

pytestmark = pytest.mark.slow

NOMINAL = {"panda_1": "panda_3", "dinova_1": "dinova_2"}
"""Folders whose arm has its URDF in another one."""
DISTANCE = 0.05


def urdfs(robot, train, *tests, **options):
    """The bytes of ``calibrated.urdf`` for each choice of what is held out."""
    return {
        mukca.calibrate(robot, train, test, distance=DISTANCE, **options).calibrated.urdf()
        for test in tests
    }


@pytest.mark.parametrize("arm", ["panda_1", "panda_3", "kuka_14", "dinova_1", "dinova_2"])
def test_the_urdf_of_a_real_arm_is_the_same_whatever_is_held_out(arm, recordings):
    robot = mukca.load_robot(recordings / NOMINAL.get(arm, arm) / "nominal.urdf")
    placements = mukca.read_placements(recordings / arm)
    for train in placements[::2]:
        others = [placement for placement in placements if placement is not train]
        assert len(urdfs(robot, train, (), others)) == 1


def drifting(q):
    return q + 3e-3 * np.outer(np.arange(len(q)) / len(q), np.eye(7)[0])


def lost_zero(q):
    return q + np.outer(np.arange(len(q)) >= 16, np.deg2rad(1) * np.eye(7)[3])


def pushed(q):
    return q + 1e-2 * np.outer(np.arange(len(q)) >= 16, np.eye(7)[0])


def remounted(q):
    return q + np.deg2rad(1) * np.eye(7)[6]


def longer(q):
    return q * (1 + 0.02 * np.eye(7)[3])


@pytest.mark.parametrize("fault", [drifting, lost_zero, pushed, remounted, longer])
def test_faults_of_what_is_held_out_change_nothing(panda, true_panda, fault):
    train, *test = (recorded_at(true_panda, PLACES[name], 1, name, samples=12) for name in PLACES)
    faulty = [moved(placement, fault(placement.positions)) for placement in test]
    assert len(urdfs(panda, train, (), test, faulty, **RIGID)) == 1
    assert len(urdfs(panda, moved(train, fault(train.positions)), (), test, **RIGID)) == 1


def test_samples_held_out_are_measured_as_they_are(panda, true_panda):
    """Of a ball elsewhere in what is held out the centres of its sockets take what they can."""
    train, test, _ = (recorded_at(true_panda, PLACES[name], 1, name) for name in PLACES)
    origins = true_panda.origins.copy()
    origins[-1, 1] += 1.5e-3
    arm = true_panda.with_origins(origins)
    test = replace(recorded_at(arm, PLACES["left"], 1, "left"), name=test.name)
    calibration = mukca.calibrate(panda, train, test, distance=DISTANCE, **RIGID)
    (row,) = [row for row in calibration.errors if row.role == "test"]
    balls = calibration.ball(test.positions)
    errors = []
    for socket in (0, 1):
        of_socket = balls[test.sockets == socket]
        errors.append(np.linalg.norm(of_socket - of_socket.mean(axis=0), axis=1))
    assert row.calibrated.mean_absolute_error == pytest.approx(np.concatenate(errors).mean())
    assert calibration.document.data[1].samples[0].moved is None

"""What goes to another process, or is copied, computes as before."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest
from calibrated_arm import recorded_face_to_face

import mukca


def sent(value):
    return pickle.loads(pickle.dumps(value))


@pytest.fixture(scope="module")
def calibration():
    """A calibration that has been used, so that it holds compiled functions."""
    robot = mukca.load_robot("panda")
    _, placements = mukca.simulate_recordings(robot, 2, seed=3, samples=10, compliance=4e-5)
    made = mukca.calibrate(robot, placements[:1], test=placements[1:], without=["curves"])
    made.command(made.flange(middle(made)), near=middle(made))
    made.corrected_pose(made.flange(middle(made)), middle(made), payload=(1.0, (0, 0, 0.05)))
    made.deviation(middle(made))
    assert made.verdict.title
    return made


def middle(made):
    return made.calibrated.middle + 0.1


@pytest.mark.parametrize("way", [sent, copy.copy, copy.deepcopy])
def test_a_used_calibration_is_copied_whole(calibration, way):
    twin, q = way(calibration), middle(calibration)
    pose = calibration.flange(q)
    np.testing.assert_array_equal(twin.ball(q), calibration.ball(q))
    np.testing.assert_array_equal(twin.command(pose, near=q), calibration.command(pose, near=q))
    np.testing.assert_allclose(twin.deviation(q), calibration.deviation(q), rtol=1e-9)
    assert (repr(twin), twin.urdf()) == (repr(calibration), calibration.urdf())
    assert twin.document == calibration.document


def test_a_pool_of_processes_uses_a_calibration(calibration):
    """As a study does that spreads its poses over the cores."""
    q = middle(calibration)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        [ball] = pool.map_async(calibration.ball, [q]).get(timeout=60)
    np.testing.assert_array_equal(ball, calibration.ball(q))


def test_robots_that_were_calibrated_together_are_copied_with_their_bases():
    arms = {name: mukca.load_robot("panda") for name in ("left", "right")}
    recorded = recorded_face_to_face([*arms.values()], np.random.default_rng(0), noise=1e-4)
    train = dict(zip(arms, recorded, strict=True))
    both = mukca.calibrate(arms, train, distance=0.05, without=["curves"])
    twins, q = sent(both), middle(both["left"])
    np.testing.assert_array_equal(twins.pose("right").matrix, both.pose("right").matrix)
    setup = {"frame": "right"}
    np.testing.assert_array_equal(twins["left"].flange(q, **setup), both["left"].flange(q, **setup))


def test_a_pose_out_of_reach_is_told_across_processes(calibration):
    far = np.array([5.0, 0.0, 0.0])
    with pytest.raises(mukca.MukcaError) as refusal:
        calibration.command(far, near=middle(calibration))
    error, twin = refusal.value, sent(refusal.value)
    assert (str(twin), twin.joint) == (str(error), error.joint)
    np.testing.assert_array_equal(twin.positions, error.positions)
    np.testing.assert_array_equal(twin.left, error.left)

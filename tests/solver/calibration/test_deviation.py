"""How well poses are known: covariances of the flange and of tools on it."""

import numpy as np
import pytest

import mukca
from mukca.solver.calibration import UsageError
from mukca.solver.identification.robot import workspace
from mukca.solver.studies import HeldOut, distance_slopes, misfit, within
from mukca.solver.studies.uncertainty import covariance_of

FLAWS = {"compliance": 5e-5, "tilt": 3e-5, "transmission": 2e-4}


@pytest.fixture(scope="module", params=["smooth", "with curves"])
def arm(request):
    if request.param == "with curves":
        return request.getfixturevalue("curved")[0]
    robot = mukca.load_robot("ur5e")
    _, placements = mukca.simulate_recordings(robot, 2, samples=20, seed=2, **FLAWS)
    return mukca.calibrate(robot, placements, without=("curves",))


@pytest.mark.slow
def test_it_is_the_ball_s_own_covariance_in_any_shape_and_frame(arm):
    q, posterior = workspace(arm.robot, 6), arm.posterior
    assert arm.misfit == 0  # nothing was held out
    _, J, _ = posterior.linearise(arm.load.at(arm.robot, q))
    expected = J @ covariance_of(posterior) @ J.swapaxes(1, 2)
    at_ball = arm.deviation(q.reshape(2, 3, -1), tool=arm.robot.tip)
    assert at_ball.shape == (2, 3, 6, 6)
    blocks = at_ball.reshape(6, 6, 6)
    assert blocks[:, :3, :3] == pytest.approx(expected, rel=1e-3, abs=1e-10)
    assert blocks == pytest.approx(blocks.swapaxes(1, 2))
    assert np.linalg.eigvalsh(blocks).min() > 0
    base = arm.flange(q[0])
    R = np.kron(np.eye(2), base[:3, :3])
    turned = arm.deviation(q, tool=arm.robot.tip, base=base)
    assert turned == pytest.approx(R @ blocks @ R.T, abs=1e-12)


@pytest.mark.slow
def test_distances_have_the_deviations_that_calibrations_state(arm):
    q, posterior = workspace(arm.robot, 2), arm.posterior
    poses = arm.load.at(arm.robot, q)
    _, slopes = distance_slopes(posterior.model, posterior.x, poses)
    stated = float(np.sqrt(slopes[0] @ covariance_of(posterior) @ slopes[0]))
    first, second = arm.deviation(q, tool=arm.robot.tip)[:, :3, :3]
    bound = sum(np.linalg.eigvalsh(block)[-1] ** 0.5 for block in (first, second))
    assert 0 < stated < bound


@pytest.mark.slow
def test_a_long_tool_turns_with_the_flange(arm):
    q = workspace(arm.robot, 4)
    tool, lever = np.eye(4), 0.2
    tool[2, 3] = lever
    flange, tip = arm.deviation(q), arm.deviation(q, tool=tool)
    shift = lever * arm.flange(q)[:, :3, 2]
    for C, there, (x, y, z) in zip(flange, tip, shift, strict=True):
        A = np.eye(6)
        A[:3, 3:] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        assert there == pytest.approx(A @ C @ A.T, rel=1e-6, abs=1e-12)


@pytest.mark.slow
def test_errors_of_held_out_samples_count():
    """Those that are beyond the posterior, in all directions; 95 of 100 samples are within."""
    robot, rows, generator = mukca.load_robot("ur5e"), [1, 2, 3], np.random.default_rng(0)
    _, (*train, held) = mukca.simulate_recordings(robot, 3, samples=20, seed=2, **FLAWS)
    q = held.positions + generator.normal(0, 1e-3, held.positions.shape) * np.isin(range(6), rows)
    shaken = mukca.Placement.of_arrays("shaken", q, held.sockets, robot.joint_names, distance=0.05)
    without = ("curves",)
    sound, doubtful = (
        mukca.calibrate(robot, train, test=test, without=without) for test in (held, shaken)
    )
    assert doubtful.misfit > 3 * sound.misfit > 0
    poses = workspace(robot, 5)
    grown = doubtful.deviation(poses) - sound.deviation(poses)
    assert np.linalg.eigvalsh(grown).min() > -1e-12
    assert np.trace(grown, axis1=1, axis2=2).min() > 1e-8
    posterior, samples = doubtful.posterior, doubtful.load.at(robot, q)
    places = [HeldOut(samples.only(held.sockets == k)) for k in (0, 1)]
    assert misfit([(posterior, place) for place in places]) == pytest.approx(doubtful.misfit)
    shares = [within(posterior, place, doubtful.misfit, [7.815])[0] for place in places]
    assert 0.95 <= np.mean(shares) < 1
    assert misfit([(posterior, HeldOut(samples.only(slice(6))))]) == 0


def test_the_paper_s_method_has_none():
    robot = mukca.load_robot("ur5e")
    _, placements = mukca.simulate_recordings(robot, 1, samples=8)
    arm = mukca.calibrate(robot, placements, method="paper")
    with pytest.raises(UsageError, match="give a calibration by --method auto"):
        arm.deviation(workspace(robot, 1))

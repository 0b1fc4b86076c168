"""From a wanted pose to joint positions, by the full model."""

from dataclasses import replace

import numpy as np
import pytest
from cases import by_table

import mukca
from mukca.solver.calibration import CommandError, FullModel
from mukca.solver.identification.robot import workspace

FLAWS = {"compliance": 5e-5, "tilt": 3e-5, "transmission": 2e-4}
SETUP = {"tool": "ball_link", "payload": (1.0, (0.0, 0.0, 0.05))}
POSTURE = (0.0, -0.4, 0.0, -2.0, 0.0, 1.7, 0.8)


def arm(name):
    truth, _ = mukca.simulate_recordings(mukca.load_robot(name), 1, samples=2, **FLAWS)
    return FullModel(truth)


@pytest.fixture(scope="module", params=["panda", "ur5e", "so101"])
def model(request):
    return arm(request.param)


@pytest.fixture(scope="module")
def bent_panda():
    return arm("panda")


@pytest.mark.slow
def test_the_jacobian_is_the_derivative_of_the_pose(model):
    q, step = workspace(model.robot, 30), 1e-6
    for setup in ({}, SETUP):
        T, J = model.flange(q, **setup), model.jacobian(q, **setup)
        for i, change in enumerate(step * np.eye(q.shape[1])):
            slope = model.flange(q + change, **setup) - model.flange(q - change, **setup)
            slope /= 2 * step
            W = slope[:, :3, :3] @ T[:, :3, :3].transpose(0, 2, 1)
            spin = np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], axis=1)
            assert np.abs(J[:, :, i] - np.hstack([slope[:, :3, 3], spin])).max() < 1e-7


def test_the_flange_carries_the_ball_and_shapes_stay(model):
    q = workspace(model.robot, 6)
    T = model.flange(q.reshape(2, 3, -1), tool="ball_link")
    assert T.shape == (2, 3, 4, 4)
    assert T.reshape(6, 4, 4)[:, :3, 3] == pytest.approx(model.ball(q), abs=1e-12)


def test_a_ball_may_hang_on_the_last_link_that_moves():
    model = arm("gen3_lite")
    q = workspace(model.robot, 3)
    assert model.flange(q, tool=model.robot.tip)[:, :3, 3] == pytest.approx(model.ball(q))


def test_commands_bring_the_tool_to_poses_and_points(model):
    q, rng = workspace(model.robot, 100), np.random.default_rng(0)
    near = q + rng.uniform(-0.1, 0.1, q.shape)
    base = model.flange(q[0])
    for setup in ({}, {**SETUP, "base": base}):
        T = model.flange(q, **setup)
        found = model.command(T, near, **setup)
        assert np.abs(model.flange(found, **setup) - T).max() < 1e-9
        assert np.all((found >= model.robot.lower) & (found <= model.robot.upper))
    point = model.command(model.ball(q)[3], near[3], tool="ball_link")
    assert point.shape == q[3].shape and model.ball(point) == pytest.approx(model.ball(q)[3])


def test_a_pose_alone_is_solved_as_beside_others(model):
    q = workspace(model.robot, 12)
    q[1, 1] = model.robot.upper[1]
    near = np.clip(q - 0.05, model.robot.lower, model.robot.upper)
    T = model.flange(q)
    together = model.command(T, near)
    alone = np.array([model.command(*one) for one in zip(T, near, strict=True)])
    assert alone == pytest.approx(together, abs=1e-7)
    assert np.abs(model.flange(alone) - T).max() < 1e-9


def test_other_starts_are_tried_where_the_first_leads_nowhere(model):
    T = model.flange(workspace(model.robot, 15))
    assert np.abs(model.flange(model.command(T)) - T).max() < 1e-9


@pytest.mark.slow
def test_a_fold_at_a_limit_is_left_from_one_start():
    model = arm("openarm")  # whose elbow is straight at its limit
    q = np.clip(0.7 * workspace(model.robot, 200), model.robot.lower, model.robot.upper)
    near = q + 0.05 * np.sin(np.arange(q.size)).reshape(q.shape)
    q[:, 3], near[:, 3] = 0.06, 0.0
    solver = model.calibrated.solver("pose")
    found = solver.solve(model.flange(q)[:, :3].reshape(-1, 12), near)
    assert found.reached.all()  # 175, if joints did not stay away from their limits for a while
    assert np.abs(model.flange(found.positions) - model.flange(q)).max() < 1e-9


@pytest.mark.slow
def test_a_payload_is_held_and_the_command_makes_up_for_it(bent_panda):
    q, loaded = np.array(POSTURE), {"payload": (3.0, (0.0, 0.0, 0.1))}
    T = bent_panda.flange(q)
    assert bent_panda.flange(q, **loaded)[2, 3] < T[2, 3] - 1e-5
    assert np.abs(bent_panda.flange(bent_panda.command(T, q, **loaded), **loaded) - T).max() < 1e-9


@pytest.mark.slow
def test_what_is_out_of_reach_is_said_with_the_nearest_positions(bent_panda):
    with pytest.raises(CommandError, match=r"^pose: not reached; .* mm and 0 mrad") as stopped:
        bent_panda.command((3.0, 0.0, 0.3), POSTURE)
    place = bent_panda.flange(stopped.value.positions)[:3, 3]
    left = np.linalg.norm(place - [3.0, 0.0, 0.3])
    assert stopped.value.left[0] == pytest.approx(left) and 2.0 < left < 2.3
    assert "out of the arm's reach" in str(stopped.value)


def test_the_joint_at_its_limit_is_named(bent_panda):
    robot, at = bent_panda.robot, dict(zip(bent_panda.robot.joint_names, POSTURE, strict=True))
    joints = tuple(
        replace(j, lower=at[j.name] - 0.1, upper=at[j.name] + 0.1) if j.actuated else j
        for j in robot.joints
    )
    narrow = FullModel(replace(bent_panda.calibrated, robot=replace(robot, joints=joints)))
    with pytest.raises(CommandError) as stopped:
        narrow.command(bent_panda.flange(np.add(POSTURE, 0.2)), POSTURE)
    joint, positions = stopped.value.joint, stopped.value.positions
    assert abs(positions[robot.joint_names.index(joint)] - at[joint]) == pytest.approx(0.1)
    assert f"with {joint} at its limit" in str(stopped.value)


def circles(start, radius, rounds=10):
    """Poses along a circle, 50 a round, that ends where it begins."""
    angle = np.linspace(0, 2 * np.pi * rounds, 50 * rounds + 1)
    poses = np.tile(start, (len(angle), 1, 1))
    poses[:, 0, 3] += radius * (np.cos(angle) - 1)
    poses[:, 1, 3] += radius * np.sin(angle)
    return poses


@pytest.mark.slow
def test_a_closed_path_of_the_tool_is_one_of_the_joints(bent_panda):
    path = bent_panda.command_path(circles(bent_panda.flange(POSTURE), 0.1), POSTURE)
    assert path.reached.all() and not path.jumps and path.rounds.max() <= 6
    assert np.abs(path.checked()[-1] - POSTURE).max() < 1e-3
    assert np.abs(np.diff(path.positions, axis=0)).max() < 0.1
    assert path.singular_value.min() > 0.05


def test_the_preferred_posture_is_kept_on_the_way(bent_panda):
    T, turned = bent_panda.flange(POSTURE), np.array(POSTURE)
    found = bent_panda.command(T, POSTURE)
    assert found == pytest.approx(np.array(POSTURE), abs=1e-9)
    turned[0] += 0.3
    other = bent_panda.command(T, POSTURE, turned)
    assert np.linalg.norm(other - turned) < np.linalg.norm(found - turned) - 1e-3
    assert np.abs(bent_panda.flange(other) - T).max() < 1e-9


def test_jumps_and_poses_not_reached_are_refused(bent_panda):
    one = np.array(POSTURE)
    poses = bent_panda.flange(np.array([one, one]))
    poses[1, :2, 3] = -poses[1, :2, 3]  # to the other side of the foot
    path = bent_panda.command_path(poses, one)
    poses[1, :3, 3] = 3.0
    lost = bent_panda.command_path(poses, one)
    assert path.jumps == (1,) and lost.reached.tolist() == [True, False]
    assert repr(lost).startswith("JointPath(2 poses: 1 reached, 1 jumps, ")
    for table, words in ((path, "jump"), (lost, "not reached")):
        with pytest.raises(CommandError, match=f"pose 1: .*{words}"):
            table.checked()


@by_table("pose", "setup", "said")
def test_what_is_no_pose_is_said(bent_panda, pose, setup, said):
    with pytest.raises(mukca.MukcaError, match=said) as stopped:
        bent_panda.command(pose, **setup)
    assert "\n" not in str(stopped.value)


def test_a_controller_that_is_sent_corrected_poses_reaches_the_true_ones(bent_panda):
    six = arm("ur5e")
    start = np.array([0.0, -1.2, 1.6, -1.9, -1.57, 0.0])
    T = six.flange(start)
    sent = six.corrected_pose(T, start)
    assert np.abs(six.flange(six.nominal.command(sent, start)) - T).max() < 1e-9
    T, q = bent_panda.flange(POSTURE), np.array(POSTURE)
    q[2] += 0.2  # the controller's own choice of the elbow
    off = []
    for _ in range(3):
        q = bent_panda.nominal.command(bent_panda.corrected_pose(T, q), q)
        off.append(float(np.abs(bent_panda.flange(q) - T).max()))
    assert off[-1] < 2e-6 and off[-1] < off[0]


CONF = """[mounting]
delta_theta = [ 1e-4, -1e-3, 1.5e-3, -5e-4, 2e-4, -1e-4]
delta_a = [ 2e-4, 3e-4, -1e-4, 1e-4, -2e-4, 0]
delta_d = [ 1e-4, 1.25, -1.26, 0.01, 1e-4, -3e-4]
delta_alpha = [ 1e-3, -2e-3, 1e-3, 5e-4, -1e-3, 0]
"""
UR10E = np.array([[0.1807, 0, 0, 0.17415, 0.11985, 0.11655], [0, -0.6127, -0.57155, 0, 0, 0]])


def by_denavit_hartenberg(q):
    """The flange of a UR10e with that calibration: Denavit and Hartenberg, written out."""
    rows = [
        np.array(line.split("[")[1].strip("]").split(","), float) for line in CONF.split("\n")[1:5]
    ]
    T = np.eye(4)
    for theta, d, a, alpha in zip(
        q + rows[0], UR10E[0] + rows[2], UR10E[1] + rows[1],
        rows[3] + np.pi / 2 * np.array([1, 0, 0, 1, -1, 0]), strict=True,
    ):  # fmt: skip
        (st, ct), (sa, ca) = ((np.sin(x), np.cos(x)) for x in (theta, alpha))
        T = T @ [
            [ct, -st * ca, st * sa, a * ct],
            [st, ct * ca, -ct * sa, a * st],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    return T


@pytest.mark.slow
def test_a_factory_calibration_is_what_its_controller_computes_by(tmp_path):
    model, file, q = (
        arm("ur10e"),
        tmp_path / "calibration.conf",
        np.array([0.1, -1.2, 1.6, -1.9, -1.5, 0.3]),
    )
    file.write_text(CONF)
    sent = model.corrected_pose(model.flange(q), q, controller=file)
    assert np.abs(sent - by_denavit_hartenberg(q)).max() < 1e-9
    for name, text, said in (
        ("ur10e", "", "six numbers delta_theta"),
        ("panda", CONF, "one of UR3,"),
    ):
        file.write_text(text)
        with pytest.raises(mukca.MukcaError, match=said):
            arm(name).corrected_pose(np.eye(4), controller=file)


@pytest.mark.slow
def test_the_controller_of_another_arm_is_refused(tmp_path):
    file = tmp_path / "calibration.conf"
    file.write_text(CONF.replace("-1e-3, 1.5e-3, -5e-4", "-0.1, 0.15, -0.05"))
    model = arm("ur10e")
    T = model.flange(np.array([0.1, -1.2, 1.6, -1.9, -1.5, 0.3]))
    for other in (mukca.load_robot("ur5e"), mukca.load_robot("xarm6"), mukca.load_robot("panda")):
        with pytest.raises(mukca.MukcaError, match=f"controller {other.name}: "):
            model.corrected_pose(T, controller=other)
    with pytest.raises(mukca.MukcaError, match=r"calibration\.conf: its flange stands up to"):
        model.corrected_pose(T, controller=file)
    model.corrected_pose(T, controller=mukca.load_robot("ur10e", base="base_link_inertia"))


@pytest.mark.slow
def test_via_points_keep_a_line_straight(bent_panda):
    ends = np.tile(bent_panda.flange(POSTURE), (2, 1, 1))
    ends[1, 1, 3] += 0.2
    few, many = (bent_panda.corrected_line(ends, POSTURE, by) for by in (1e-2, 1e-5))
    assert len(few) == 2 < len(many) < 60
    controller, bows = bent_panda.nominal, []
    for sent in (few, many):
        middles = (sent[:-1] + sent[1:]) / 2
        true = bent_panda.flange(controller.command(middles, POSTURE))[:, [0, 2], 3]
        bows.append(np.abs(true - ends[0, [0, 2], 3]).max())
    assert bows[1] < 2e-5 < bows[0]


def test_virtual_positions_make_the_urdf_exact(bent_panda):
    calibrated = replace(bent_panda.calibrated, exported=bent_panda.calibrated.values + 1e-4)
    model = FullModel(calibrated)
    q = np.add(POSTURE, 0.3 * np.sin(np.arange(70)).reshape(10, 7))
    virtual = model.virtual_positions(q)
    assert np.abs(model.geometric.flange(virtual) - model.flange(q)).max() < 1e-9
    assert 1e-4 < np.abs(virtual - q).max() < 0.03
    with pytest.raises(CommandError, match="fewer than six"):
        arm("so101").virtual_positions(np.full(5, 0.3))


def test_a_singular_row_costs_no_other_row():
    """Wrists that are straight reach what the URDF has by a far turn, or not at all."""
    made = arm("ur5e")
    model = FullModel(replace(made.calibrated, exported=made.calibrated.values + 1e-4))
    q = np.random.default_rng(0).uniform(-1.5, 1.5, (80, 6))
    q[:40, 4] = 0.0
    virtual = model.virtual_positions(q)
    held = ~np.isnan(virtual).any(axis=1)
    assert np.isnan(virtual[~held]).all() and 0.6 < held.mean() < 1
    assert np.abs(virtual - q)[held].max() > 0.1
    off = model.geometric.flange(virtual[held]) - model.flange(q[held])
    assert np.abs(off).max() < 2e-9
    with pytest.raises(CommandError, match="singular"):
        model.virtual_positions(q[np.flatnonzero(~held)[0]])


def test_another_branch_is_refused(bent_panda):
    """The nearest solution to a pose beyond a full turn of the flange is that much away."""
    there = np.array(POSTURE)
    there[6] -= 1.2
    pose = bent_panda.flange(there)
    for within in (None, 1.3):
        q = bent_panda.command(pose, near=POSTURE, within=within)
        assert np.abs(bent_panda.flange(q) - pose).max() < 1e-9
    with pytest.raises(mukca.CommandError, match=r"pose 0: .* panda_joint7 .* within=0.5") as said:
        bent_panda.command(pose, near=POSTURE, within=0.5)
    assert said.value.joint == "panda_joint7" and said.value.left.max() < 1e-9

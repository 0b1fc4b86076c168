"""Derivatives against finite differences, torques against Pinocchio."""

import json
from pathlib import Path

import casadi as ca
import numpy as np
import pinocchio
import pytest
from imagined import slopes
from project import ROOT
from scipy.optimize import minimize

from mukca.solver.identification.robot import (
    BallModel,
    RowFunction,
    all_parameters,
    choose_parameters,
    gravity_moments,
    link_poses,
    load_robot,
    parse_robot,
    rotation_vectors,
    scan,
    shipped_robots,
    turn,
    workspace,
)
from mukca.solver.results import moments_function


def crane():
    """A robot that turns and lifts."""
    return parse_robot(scan(Path(__file__).with_name("crane.urdf").read_bytes(), "crane"))


def test_many_rows_are_computed_as_few_are_and_as_numpy_does(panda):
    model = BallModel(panda, [p.index for p in choose_parameters(panda)], "rpy")
    parameters = model.nominal + np.random.default_rng(1).normal(0, 0.01, len(model.nominal))
    x, symbols = ca.SX.sym("x", len(parameters)), ca.SX.sym("q", 7)
    balls = RowFunction("balls", [x, symbols], [model.function(x, symbols)])
    q = np.random.default_rng(0).uniform(-1, 1, (600, 7))
    [together] = balls(q, parameters)
    halves = np.split(q, 6)  # few enough for the other way
    alone = [balls(half, parameters)[0] for half in halves]
    assert together == pytest.approx(np.concatenate(alone), abs=1e-14)
    assert together == pytest.approx(model.points(parameters, q), abs=1e-14)


def test_the_ball_stays_exactly_where_it_is_as_its_frame_turns(panda):
    """The paper's fit leaves alone what has no effect at all."""
    turns = [p.index for p in all_parameters(panda) if p.of_ball and p.unit == "rad"]
    model = BallModel(panda, turns)
    q = np.random.default_rng(0).uniform(-1, 1, (9, 7))
    assert not model.linearise(model.nominal + 0.1, q).by_parameters.any()


@pytest.mark.parametrize("name", ["panda", "gen3_lite", "crane"])
def test_the_volume_changes_as_finite_differences_do(name):
    robot = crane() if name == "crane" else load_robot(name)
    model = BallModel(robot, [p.index for p in all_parameters(robot)])
    q = np.random.default_rng(0).uniform(-1, 1, (4, len(robot.actuated)))
    x = model.nominal + np.random.default_rng(1).normal(0, 0.01, len(model.nominal))
    _, by_parameters, by_joints = model.log_volume(x, q)
    volume = lambda x, turn: np.array([model.log_volume(x, q + turn)[0]])  # noqa: E731
    still = np.zeros(q.shape[1])
    assert by_parameters == pytest.approx(slopes(lambda x: volume(x, still), x).ravel(), abs=1e-6)
    if len(still) >= 3:
        expected = slopes(lambda turn: volume(x, turn), still).ravel()
        assert by_joints == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", ["panda", "crane"])
def test_gravity_moments_are_those_that_controllers_compute(name):
    robot = crane() if name == "crane" else load_robot(name)
    q = np.random.default_rng(0).uniform(-1, 1, len(robot.actuated))
    arguments = (1.0, 2.0, -9.0), 1.5
    by_controller = moments_function(robot, *arguments)(q).full().ravel()
    assert gravity_moments(robot, q[None], *arguments)[0] == pytest.approx(by_controller, abs=1e-9)


@pytest.mark.parametrize("name", ["panda", "gen3_lite", "crane"])
def test_derivatives_agree_with_finite_differences(name):
    robot = crane() if name == "crane" else load_robot(name)
    model = BallModel(robot, [p.index for p in all_parameters(robot)])
    generator = np.random.default_rng(0)
    x = model.nominal + generator.normal(0, 0.01, len(model.nominal))
    q = generator.uniform(-1, 1, (4, len(robot.actuated)))
    linear = model.linearise(x, q)
    assert linear.points == pytest.approx(model.points(x, q), abs=1e-15)
    tilted = np.hstack([q, generator.normal(0, 1e-3, (4, 2 * q.shape[1]))])
    by_parameters = slopes(lambda x: model.points(x, q), x)
    assert linear.by_parameters == pytest.approx(by_parameters, abs=1e-8)
    for positions in (q, tilted):
        by_joints = slopes(lambda q: model.points(x, q), positions)
        assert model.linearise(x, positions).by_joints == pytest.approx(by_joints, abs=1e-8)


@pytest.mark.parametrize("name", [*shipped_robots(), "crane"])
def test_gravity_torques_agree_with_pinocchio(name):
    robot = crane() if name == "crane" else load_robot(name)
    model = pinocchio.buildModelFromXML(robot.text.data.decode())
    gravity = (0.0, 3.0, -9.0)
    model.gravity.linear = np.array(gravity)
    data = model.createData()
    positions = np.random.default_rng(2).uniform(-1.5, 1.5, (5, len(robot.actuated)))
    expected = []
    for q in positions:
        configuration = pinocchio.neutral(model)
        for name, angle in zip(robot.joint_names, q, strict=True):
            joint = model.joints[model.getJointId(name)]
            wide = joint.nq == 2  # an endless joint is kept as cosine and sine
            configuration[joint.idx_q : joint.idx_q + joint.nq] = (
                [np.cos(angle), np.sin(angle)] if wide else [angle]
            )
        expected.append(pinocchio.computeGeneralizedGravity(model, data, configuration).copy())
    found = gravity_moments(robot, positions, gravity)[:, : positions.shape[1]]
    assert found == pytest.approx(np.array(expected), abs=1e-9)


def test_moments_across_are_those_of_the_weights_beyond(panda):
    """At each joint, against lever times weight."""
    q = np.random.default_rng(3).uniform(-1.5, 1.5, 7)
    places = [(pose[:, :3], pose[:, 3]) for pose in link_poses(panda.joints, q[None])[0, 1:]]
    found = gravity_moments(panda, q[None])[0].reshape(3, 7)
    moving = [i for i, joint in enumerate(panda.joints) if joint.actuated]
    for k, i in enumerate(moving):
        R, p = places[i]
        hold = np.zeros(3)
        for body in panda.bodies:
            if body.joint >= i:
                Rb, pb = places[body.joint]
                hold -= np.cross(pb + Rb @ body.centre - p, [0, 0, -9.80665 * body.mass])
        assert panda.joints[i].axis == (0, 0, 1)
        axes = np.eye(3)[[2, 0, 1]]  # its own, and the two across
        assert found[:, k] == pytest.approx(axes @ R.T @ hold, abs=1e-9)


def test_a_payload_pulls_at_the_ball(panda):
    q = np.array([[0.1, 0.5, -0.3, -1.8, 0.2, 2.0, 0.4]])
    by_payload = (gravity_moments(panda, q, payload=1.5) - gravity_moments(panda, q))[:, :7]
    by_joints = BallModel(panda, []).linearise(np.empty(0), q).by_joints[0]
    assert by_payload[0] == pytest.approx(by_joints.T @ [0, 0, 1.5 * 9.80665], abs=1e-12)


@pytest.mark.parametrize("short_of_half", [0.0, 1e-11, 1e-7, 1e-3])
def test_half_turns_have_their_vectors(short_of_half):
    axes = np.array([[1.0, 0, 0], [0, 0, -1], [0.6, -0.8, 0], [-2, 3, 6] / np.float64(7)])
    R = turn((np.pi - short_of_half) * axes)
    vectors = rotation_vectors(R)
    assert np.linalg.norm(vectors, axis=1) == pytest.approx(np.pi - short_of_half, abs=1e-9)
    assert turn(vectors) == pytest.approx(R, abs=1e-9)


def test_parameters_move_only_what_they_name(panda):
    chosen = choose_parameters(panda, free=["panda_joint3.xyz", "ball_joint.z"])
    model = BallModel(panda, [p.index for p in chosen])
    origins = model.origins(model.nominal + 1.0)
    changed = np.argwhere(origins != panda.origins).tolist()
    names = [panda.joints[joint].name for joint, _ in changed]
    assert names == ["panda_joint3"] * 3 + ["ball_joint"]


def test_words_name_joints_groups_components_and_patterns(panda):
    def names(**words):
        return [p.name for p in choose_parameters(panda, **words)]

    assert names(free=["ball_joint.xyz"]) == ["ball_joint.x", "ball_joint.y", "ball_joint.z"]
    assert names(free=["panda_joint8"])[0] == "panda_joint8.x"
    assert len(names(free=["panda_joint?.yaw"])) == 8
    assert len(names(fix=["*.rpy"])) == 24
    assert len(names(fix=["panda_joint1", "ball_joint.roll"])) == 41


LISTED = json.loads((ROOT / "tools/cli/commands/robots.json").read_bytes())


def test_mukca_robots_lists_each_model_that_is_shipped():
    assert set(LISTED) == set(shipped_robots())


@pytest.mark.parametrize("name", LISTED)
def test_the_reach_that_mukca_robots_lists_is_the_model_s(name):
    """The largest distance of the ball from the second joint, within the joints' limits."""
    robot = load_robot(name)
    model = BallModel(robot, [])
    q = workspace(robot, 2000)
    second = link_poses(robot.joints, q[:1])[0, 1 + robot.joints.index(robot.actuated[1]), :, 3]
    q[:, 0] = q[0, 0]  # the first joint moves the second one and the ball alike

    def minus_distance(q):
        linear = model.linearise(np.empty(0), q[None])
        arm = linear.points[0] - second
        distance = np.linalg.norm(arm)
        slopes = -arm @ linear.by_joints[0] / distance
        return -distance, np.where(np.arange(len(q)) == 0, 0.0, slopes)

    distances = np.linalg.norm(model.points(np.empty(0), q) - second, axis=1)
    limits = [*zip(robot.lower.clip(-7), robot.upper.clip(max=7), strict=True)]
    starts = q[np.argsort(distances)[-8:]]
    minima = [minimize(minus_distance, start, jac=True, bounds=limits).fun for start in starts]
    assert LISTED[name]["reach"] == pytest.approx(-min(minima), abs=1e-4)

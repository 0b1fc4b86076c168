"""The files of the shipped robots: one chain each, the makers' joints, masses, and a ball."""

import re
from math import pi

import numpy as np
import pytest
from robot_sheets import (
    DATA_SHEETS,
    FOLDER,
    NAMES,
    chain,
    having,
    inertials,
    load,
    path_of,
    pose,
    random_configurations,
)

every_robot = pytest.mark.parametrize("name", NAMES)


def test_every_robot_of_the_folder_is_tested_here():
    assert sorted(path.stem for path in FOLDER.glob("*.urdf")) == NAMES


@every_robot
def test_is_one_chain_from_base_link_to_the_ball(name):
    robot = load(name).robot
    children = {joint.child for joint in robot.joints}
    assert robot.name == name
    base = DATA_SHEETS[name].base
    assert [link.name for link in robot.links if link.name not in children] == [base]
    assert chain(name)[0].parent == base
    assert len(chain(name)) == len(robot.joints) == len(robot.links) - 1
    assert (chain(name)[-1].name, chain(name)[-1].type) == ("ball_joint", "fixed")


@every_robot
def test_joints_are_the_makers_in_order_with_finite_limits(name):
    actuated = [joint for joint in chain(name) if joint.type != "fixed"]
    assert [joint.name for joint in actuated] == DATA_SHEETS[name].joints
    for joint in actuated:
        limit = joint.limit
        assert joint.type == "revolute"
        assert np.linalg.norm(joint.axis) == pytest.approx(1)
        assert -2 * pi <= limit.lower < limit.upper <= 2 * pi
        assert 0 < limit.velocity <= 100 and 0 < limit.effort < 1000


@every_robot
def test_has_no_mesh_and_names_its_sources(name):
    text = path_of(name).read_text(encoding="utf-8")
    comments = re.findall(r"<!--(.*?)-->", text, flags=re.DOTALL)
    assert "Source of" in comments[0]
    assert "<mesh" not in text and "package://" not in text
    assert "<visual" not in text and "<collision" not in text


@every_robot
def test_every_moving_link_has_a_mass_near_its_frame(name):
    moving = {joint.child for joint in chain(name) if joint.type != "fixed"}
    assert moving <= inertials(name).keys()
    for link, inertial in inertials(name).items():
        assert inertial.mass > 0, link
        assert np.linalg.norm(inertial.origin[:3, 3]) < 0.5, link


@every_robot
def test_inertia_tensors_can_belong_to_a_body(name):
    """Positive principal moments, none larger than the sum of the other two."""
    for link, inertial in inertials(name).items():
        moments = np.linalg.eigvalsh(inertial.inertia)
        assert moments[0] > 0, link
        assert moments[2] <= (moments[0] + moments[1]) * (1 + 1e-3), link


@pytest.mark.parametrize("name", having("mass"))
def test_mass_is_the_data_sheets(name):
    total = sum(inertial.mass for inertial in inertials(name).values())
    sheet = DATA_SHEETS[name]
    assert total - sheet.end_effector_mass == pytest.approx(sheet.mass, rel=0.15)


@every_robot
def test_ball_is_a_hands_breadth_beyond_the_flange(name):
    q = random_configurations(name, 1)[0]
    T_base_flange = pose(name, DATA_SHEETS[name].flange, q)
    p_flange_ball = (np.linalg.inv(T_base_flange) @ pose(name, "ball_link", q))[:3, 3]
    sheet = DATA_SHEETS[name]
    np.testing.assert_allclose(np.delete(p_flange_ball, sheet.out), sheet.aside, atol=1e-12)
    assert 0.03 <= sheet.sign * round(p_flange_ball[sheet.out], 12) < 0.19


def test_fr3_is_not_a_panda_in_its_limits():
    """FR3's elbow does not stretch as far as the Panda's, and its wrist is twice as fast."""

    def limit(name, i):
        return next(j for j in chain(name) if j.name == f"{name}_joint{i}").limit

    assert limit("fr3", 4).upper == -0.1518 and limit("panda", 4).upper == -0.0698
    assert limit("fr3", 6).lower == 0.5445 and limit("panda", 6).lower == -0.0175
    assert limit("fr3", 5).velocity == 5.26 and limit("panda", 5).velocity == 2.61

"""The shipped robots against their makers' published figures, through an independent library.

Every pose below is worked out from the maker's own Denavit-Hartenberg table, drawing or model,
which robot_sheets.json holds apart from the files, and compared with pinocchio's kinematics of
the files.
"""

import numpy as np
import pinocchio
import pytest
from imagined import along, dh_frames, turned
from robot_sheets import DATA_SHEETS, chain, having, inertials, pose, random_configurations

OFF_AXIS = 2 * 0.00043625
"""The ROS-Industrial model of the iiwa14 sets its axes 2 and 3 off axis 1 by half of this [m]."""


def frames(name, q):
    """Where the maker's table has the frame of each joint."""
    table = DATA_SHEETS[name].dh
    turns = [(np.radians(theta), d, a, np.radians(alpha)) for theta, d, a, alpha in table["rows"]]
    rows = [dict(zip(("theta", "d", "a", "alpha"), row, strict=True)) for row in turns]
    base = turned(z=np.radians(table.get("turned", 0)))
    return [base @ T for T in dh_frames(rows, q, table["convention"])]


@pytest.mark.parametrize("name", having("dh"))
def test_the_flange_follows_the_published_dh_table(name):
    sheet = DATA_SHEETS[name]
    for q in random_configurations(name):
        T = pose(name, sheet.flange, q)
        expected = frames(name, q)[-1] @ along(z=sheet.dh.get("tool", 0))
        np.testing.assert_allclose(T[:3, :3], expected[:3, :3], atol=1e-12)
        off = np.linalg.norm(T[:3, 3] - expected[:3, 3])
        assert off < (OFF_AXIS if name == "iiwa14" else 1e-12)


@pytest.mark.parametrize("name", having("bodies"))
def test_links_have_their_published_masses_where_they_are(name):
    q = random_configurations(name, 1)[0]
    moving = [joint.child for joint in chain(name) if joint.type != "fixed"]
    bodies = DATA_SHEETS[name].bodies
    for link, (mass, *centre), T in zip(moving, bodies, frames(name, q), strict=True):
        inertial = inertials(name)[link]
        ours = pose(name, link, q) @ inertial.origin @ (0, 0, 0, 1)
        assert inertial.mass == mass
        np.testing.assert_allclose(ours, T @ (*centre, 1), atol=1e-9, err_msg=link)


@pytest.mark.parametrize("name", having("landmarks"))
def test_stands_where_its_drawing_says(name):
    for row in DATA_SHEETS[name].landmarks:
        place = pose(name, row["link"], np.radians(row["q"]))[:3, 3]
        np.testing.assert_allclose(place, row["at"], atol=1e-4)


@pytest.mark.parametrize("name", having("makers_model"))
def test_stands_where_the_makers_model_stands(name):
    sheet = DATA_SHEETS[name]
    at_zero, at_steps, quaternion = np.split(np.array(sheet.makers_model), (3, 6))
    count = len(sheet.joints)
    np.testing.assert_allclose(pose(name, sheet.flange, [0] * count)[:3, 3], at_zero, atol=2e-5)
    T = pose(name, sheet.flange, [0.1 * (i + 1) for i in range(count)])
    np.testing.assert_allclose(T[:3, 3], at_steps, atol=2e-5)
    expected = pinocchio.Quaternion(*np.roll(quaternion, 1)).normalized().matrix()
    np.testing.assert_allclose(T[:3, :3], expected, atol=5e-5)

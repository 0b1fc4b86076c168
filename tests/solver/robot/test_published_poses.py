"""The shipped robots against their makers' published figures, through an independent library.

Every pose below is worked out from the maker's own Denavit-Hartenberg table, drawing or model,
which these tests hold apart from the files, and compared with pinocchio's kinematics of the files.
"""

from math import cos, pi, sin

import numpy as np
import pinocchio
import pytest
from robot_sheets import DATA_SHEETS, chain, inertials, pose, random_configurations

# d1, a2, a3, d4, d5, d6 [m] of Universal Robots' table
UR_LENGTHS = {
    "ur3e": (0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
    "ur5e": (0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
    "ur10e": (0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
    "ur3": (0.1519, -0.24365, -0.21325, 0.11235, 0.08535, 0.0819),
    "ur5": (0.089159, -0.425, -0.39225, 0.10915, 0.09465, 0.0823),
    "ur10": (0.1273, -0.612, -0.5723, 0.163941, 0.1157, 0.0922),
    "ur20": (0.2363, -0.862, -0.7287, 0.201, 0.1593, 0.1543),
}

# masses [kg] and centres of mass [m] of links 1 to 6 in the Denavit-Hartenberg frames, same article
UR_SMALL_CENTRES = (
    *((0, -0.02, 0), (0.13, 0, 0.1157), (0.05, 0, 0.0238)),
    *((0, 0, 0.01), (0, 0, 0.01), (0, 0, -0.02)),
)
UR_BODIES = {
    "ur3e": ((1.98, 3.4445, 1.437, 0.871, 0.805, 0.261), UR_SMALL_CENTRES),
    "ur5e": (
        (3.761, 8.058, 2.846, 1.37, 1.3, 0.365),
        (
            *((0, -0.02561, 0.00193), (0.2125, 0, 0.11336), (0.15, 0, 0.0265)),
            *((0, -0.0018, 0.01634), (0, 0.0018, 0.01634), (0, 0, -0.001159)),
        ),
    ),
    "ur10e": (
        (7.369, 13.051, 3.989, 2.1, 1.98, 0.615),
        (
            *((0.021, 0, 0.027), (0.38, 0, 0.158), (0.24, 0, 0.068)),
            *((0, 0.007, 0.018), (0, 0.007, 0.018), (0, 0, -0.026)),
        ),
    ),
}


def translation(axis, length):
    T = np.eye(4)
    T[axis, 3] = length
    return T


def rotation(axis, angle):
    T = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    T[i, i] = T[j, j] = cos(angle)
    T[j, i], T[i, j] = sin(angle), -sin(angle)
    return T


X, Y, Z = range(3)


def standard_dh(theta, d, a, alpha):
    return rotation(Z, theta) @ translation(Z, d) @ translation(X, a) @ rotation(X, alpha)


def craig_dh(theta, d, a, alpha):
    """Modified Denavit-Hartenberg step: a and alpha are those of the link before."""
    return rotation(X, alpha) @ translation(X, a) @ rotation(Z, theta) @ translation(Z, d)


def product(steps):
    T = np.eye(4)
    for step in steps:
        T = T @ step
    return T


def franka_flange(q):
    """Franka's FCI documentation, "Denavit-Hartenberg parameters", the same for Panda and FR3."""
    d = (0.333, 0, 0.316, 0, 0.384, 0, 0)
    a = (0, 0, 0, 0.0825, -0.0825, 0, 0.088)
    alpha = (0, -pi / 2, pi / 2, pi / 2, -pi / 2, pi / 2, pi / 2)
    steps = [craig_dh(*row) for row in zip(q, d, a, alpha, strict=True)]
    return product([*steps, translation(Z, 0.107)])


def ur_frames(name, q):
    """Universal Robots' table, in the controller's frame, which is base_link turned by pi."""
    d1, a2, a3, d4, d5, d6 = UR_LENGTHS[name]
    d, a = (d1, 0, 0, d4, d5, d6), (0, a2, a3, 0, 0, 0)
    alpha = (pi / 2, 0, 0, pi / 2, -pi / 2, 0)
    steps = [standard_dh(*row) for row in zip(q, d, a, alpha, strict=True)]
    return [product([rotation(Z, pi), *steps[:count]]) for count in range(1, 7)]


def gen3_lite_flange(q):
    """Kinova's user guide, "Classical DH parameters", ending at the interface module."""
    theta = q + np.array([0, pi / 2, pi / 2, pi / 2, pi, pi / 2])
    d = (0.12825 + 0.115, 0.03, 0.02, 0.14 + 0.105, 0.0285 + 0.0285, 0.105)
    a = (0, 0.28, 0, 0, 0, 0)
    alpha = (pi / 2, pi, pi / 2, pi / 2, pi / 2, 0)
    return product([standard_dh(*row) for row in zip(theta, d, a, alpha, strict=True)])


def iiwa_flange(q):
    """The data sheet's drawing: seven axes through one line when upright, 360, 420, 400, 126 mm."""
    steps = [
        *(rotation(Z, q[0]), translation(Z, 0.36), rotation(Y, q[1])),
        *(rotation(Z, q[2]), translation(Z, 0.42), rotation(Y, -q[3])),
        *(rotation(Z, q[4]), translation(Z, 0.4), rotation(Y, q[5])),
        *(rotation(Z, q[6]), translation(Z, 0.126)),
    ]
    return product(steps)


@pytest.mark.parametrize("name", ["panda", "fr3"])
def test_franka_follows_its_published_dh_table(name):
    for q in random_configurations(name):
        np.testing.assert_allclose(pose(name, f"{name}_link8", q), franka_flange(q), atol=1e-12)


@pytest.mark.parametrize("name", sorted(UR_LENGTHS))
def test_ur_follows_its_published_dh_table(name):
    for q in random_configurations(name):
        np.testing.assert_allclose(pose(name, "tool0", q), ur_frames(name, q)[-1], atol=1e-12)


@pytest.mark.parametrize("name", sorted(UR_BODIES))
def test_ur_carries_its_published_masses_where_they_are(name):
    q = random_configurations(name, 1)[0]
    moving = [joint.child for joint in chain(name) if joint.type != "fixed"]
    masses, centres = UR_BODIES[name]
    for link, mass, centre, T in zip(moving, masses, centres, ur_frames(name, q), strict=True):
        inertial = inertials(name)[link]
        ours = pose(name, link, q) @ inertial.origin @ (0, 0, 0, 1)
        assert inertial.mass == mass
        np.testing.assert_allclose(ours, T @ (*centre, 1), atol=1e-9, err_msg=link)


def test_gen3_lite_follows_its_published_dh_table():
    for q in random_configurations("gen3_lite"):
        T = pose("gen3_lite", "end_effector_link", q)
        np.testing.assert_allclose(T, gen3_lite_flange(q), atol=1e-12)


def test_iiwa14_follows_the_data_sheets_drawing():
    """But for the 0.436 mm by which the ROS-Industrial model sets axes 2 and 3 off axis 1."""
    for q in random_configurations("iiwa14"):
        T = pose("iiwa14", "tool0", q)
        np.testing.assert_allclose(T[:3, :3], iiwa_flange(q)[:3, :3], atol=1e-12)
        assert np.linalg.norm(T[:3, 3] - iiwa_flange(q)[:3, 3]) < 2 * 0.00043625


READY = (0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4)
LANDMARKS = [
    # flange with all joints at zero, and in the ready pose of Franka's examples
    ("panda", "panda_link8", (0,) * 7, (0.088, 0, 0.926)),
    ("panda", "panda_link8", READY, (0.3069, 0, 0.5903)),
    ("panda", "panda_hand_tcp", READY, (0.3069, 0, 0.4869)),
    ("fr3", "fr3_hand_tcp", READY, (0.3069, 0, 0.4869)),
    # upright: 360 + 420 + 400 + 126 mm
    ("iiwa14", "tool0", (0,) * 7, (0, 0, 1.306)),
    # elbow at a right angle: the forearm level, 400 + 126 mm out at 360 + 420 mm
    ("iiwa14", "tool0", (0, 0, 0, -pi / 2, 0, 0, 0), (0.526, 0, 0.78)),
    # upright at zero: 128.25 + 115 + 280 + 140 + 105 + 105 mm, aside by 28.5 + 28.5 and -30 + 20 mm
    ("gen3_lite", "end_effector_link", (0,) * 6, (0.057, -0.01, 0.87325)),
    # at zero the arm lies along x: a2 + a3, d4 + d6, d1 - d5
    ("ur3e", "tool0", (0,) * 6, (0.45675, 0.22315, 0.0665)),
    ("ur5e", "tool0", (0,) * 6, (0.8172, 0.2329, 0.0628)),
    ("ur10e", "tool0", (0,) * 6, (1.18425, 0.2907, 0.06085)),
    # upright: d1 + a2 + a3 + d5 high, d4 + d6 aside
    ("ur5e", "tool0", (0, -pi / 2, 0, -pi / 2, 0, 0), (0, 0.2329, 1.0794)),
]


@pytest.mark.parametrize(("name", "link", "q", "expected"), LANDMARKS)
def test_stands_where_its_drawing_says(name, link, q, expected):
    np.testing.assert_allclose(pose(name, link, q)[:3, 3], expected, atol=1e-4)


# Where the flange, or the tip, of the makers' own models stands: with all joints at zero, and with
# them at 0.1, 0.2, 0.3, ... rad, there with its orientation as a quaternion x y z w. Worked out by
# pinocchio from each maker's file, whose angles of pi/2 are rounded: by 8 um and 26 urad at most.
MAKERS_POSES = """
so101   0.391361 -9e-06 0.22647  0.33155 -0.033206 0.032166  -0.165024 0.929746 -0.089584 0.316724
so100   0 -0.14663 0.136274  0.006795 -0.112925 0.055755  0.261428 0.71355 0.520396 0.389473
vx300s  0.536494 0 0.42705  0.474356 0.080795 0.122395  0.42098 0.470511 -0.10055 0.76895
wx250s  0.458325 0 0.36065  0.401391 0.070028 0.097757  0.42098 0.470511 -0.10055 0.76895
koch    -0.14828 -0.001253 0.1673  -0.095433 0.00952 0.251173  0.243559 0.409783 -0.151082 0.865986
xarm6   0.207 -1e-06 0.112  -0.028263 -0.010739 0.081876  0.7842 -0.405283 -0.44138 0.16112
xarm7   0.206 3e-06 0.1205  0.262211 0.115189 0.106862  -0.902354 0.363417 0.231634 0.005496
lite6   0.086999 -1e-06 0.153589  0.125276 0.024297 0.164591  0.883716 -0.421529 -0.203038 0.011619
uf850   0.149999 -4e-06 0.238  0.062271 -0.010643 0.224824  -0.883715 0.421532 -0.203039 0.01161
ur3     0.4569 0.19425 0.06655  0.363181 0.221589 -0.082555  -0.612823 -0.558768 -0.459866 0.317411
ur5 0.81725 0.19145 -0.005491 0.689485 0.251465 -0.273073 -0.612823 -0.558768 -0.459866 0.317411
ur10    1.1843 0.256141 0.0116  1.00925 0.347347 -0.375207  -0.612823 -0.558768 -0.459866 0.317411
ur20    1.5907 0.3553 0.077  1.36491 0.475047 -0.44128  -0.612823 -0.558768 -0.459866 0.317411
openarm 1e-06 -0.6161 0.118  0.293558 -0.417857 0.274775  0.559481 0.230905 0.684909 0.405665
wxai    0.253762 0 0.1635  0.208843 -0.068191 0.35043  0.350473 -0.282683 -0.114048 0.88558
gen3    0 -0.02486 1.18738  0.363424 -0.179338 1.02961  -0.103821 0.526434 -0.641949 0.547713
piper   0.056135 0 0.213178  0.024536 0.019567 0.067585  0.359512 0.865452 0.246185 0.24726
"""


def makers_poses():
    """Return name, and ten numbers, of each line of the table."""
    lines = [line.split() for line in MAKERS_POSES.strip().splitlines()]
    return [(name, np.array(numbers, dtype=float)) for name, *numbers in lines]


@pytest.mark.parametrize(("name", "numbers"), makers_poses())
def test_stands_where_the_makers_model_stands(name, numbers):
    sheet = DATA_SHEETS[name]
    at_zero, at_steps, quaternion = np.split(numbers, (3, 6))
    count = len(sheet.joints)
    np.testing.assert_allclose(pose(name, sheet.flange, [0] * count)[:3, 3], at_zero, atol=2e-5)
    T = pose(name, sheet.flange, [0.1 * (i + 1) for i in range(count)])
    np.testing.assert_allclose(T[:3, 3], at_steps, atol=2e-5)
    expected = pinocchio.Quaternion(*np.roll(quaternion, 1)).normalized().matrix()
    np.testing.assert_allclose(T[:3, :3], expected, atol=5e-5)

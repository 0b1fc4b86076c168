"""The controller's terms, each by itself: by hand, against finite differences, by energy."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra simulation is not installed")
pytest.importorskip("pinocchio", reason="the extra simulation is not installed")

import pinocchio as pin

from mukca.tools.experiments.cell import READY, build_cell
from mukca.tools.experiments.controller import ArmModel, ImpedanceController, pose_error
from mukca.tools.experiments.insertion import insert_at_centre
from mukca.tools.experiments.motion import ROWS_PER_SECOND
from mukca.tools.experiments.scene import ROTOR_INERTIA, Scene, urdf_of
from mukca.tools.simulation import demo_arm

K = np.array([15000.0, 15000.0, 2000.0, 40.0, 40.0, 40.0])
TWO_LINKS = b"""<robot name="two links">
<link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="upper"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="b" type="revolute"><origin xyz="0.5 0 0"/><parent link="upper"/><child link="lower"/>
<axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="lower"><inertial><origin xyz="0.4 0 0"/><mass value="3"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="ball" type="fixed"><origin xyz="0.4 0 0"/><parent link="lower"/>
<child link="ball_link"/></joint>
<link name="ball_link"/>
</robot>"""
"""Point masses of 2 and 3 kg at the ends of links of 0.5 and 0.4 m, in the vertical plane."""


@pytest.fixture(scope="module")
def arm() -> ArmModel:
    _, robot = demo_arm(keep_size=False)
    return ArmModel(urdf_of(robot), robot.joint_names, robot.tip)


@pytest.fixture
def moving() -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(1)
    return READY + generator.normal(0, 0.3, 7), generator.normal(0, 1, 7)


def moved(pose, translation, rotation=(0.0, 0.0, 0.0)):
    return pin.SE3(
        pin.exp3(np.array(rotation)) @ pose.rotation, pose.translation + np.array(translation)
    )


def by_differences(function, q: np.ndarray, h: float = 1e-5) -> np.ndarray:
    """Return the derivatives of a function by q, the last axis being q's."""
    steps = h * np.eye(len(q))
    return np.stack([(function(q + d) - function(q - d)) / (2 * h) for d in steps], axis=-1)


def test_torque_of_two_links_by_hand() -> None:
    # Upper link straight up, lower one along x: the tip is at (0.4, 0, 0.5), and the columns of J
    # are y x (0.4, 0, 0.5) = (0.5, 0, -0.4) and y x (0.4, 0, 0) = (0, 0, -0.4), turning about y.
    # With dq = (1, 2) it moves by (0.5, 0, -1.2) m/s and turns by 3 rad/s.
    controller = ImpedanceController(ArmModel(TWO_LINKS, ("a", "b")))
    q, dq = np.array([-np.pi / 2, np.pi / 2]), np.array([1.0, 2.0])
    goal = moved(controller.model.pose(q), (0.001, 0.0, 0.002))
    spring = np.array([0.5 * 15 - 0.4 * 4, -0.4 * 4])
    x, z, about_y = (2 * k**0.5 for k in (15000, 2000, 40))
    damper = -np.array([0.5 * 0.5 * x + 0.4 * 1.2 * z + 3 * about_y, 0.4 * 1.2 * z + 3 * about_y])
    # m2 l1 l2 sin(q2) = 0.6: -0.6 (2 dq1 dq2 + dq2^2), and 0.6 dq1^2.
    coriolis = np.array([-4.8, 0.6])
    # Only the lower link's mass lies beside the joints, 0.4 m beside both.
    gravity = np.full(2, -3 * 9.81 * 0.4)
    expected = spring + damper + coriolis + gravity
    np.testing.assert_allclose(controller.torque(goal, q, dq), expected, atol=1e-9)


def test_jacobian_against_differences(arm: ArmModel, moving) -> None:
    q, _ = moving
    here = arm.pose(q)
    expected = by_differences(lambda near: pose_error(arm.pose(near), here), q)
    np.testing.assert_allclose(arm.linearise(q)[1], expected, atol=1e-8)


def test_coriolis_and_gravity_against_differences(arm: ArmModel, moving) -> None:
    # Lagrange: C dq = dM/dt dq - 1/2 d(dq' M dq)/dq, g = dU/dq.
    q, dq = moving

    def mass(q: np.ndarray) -> np.ndarray:
        upper = np.triu(pin.crba(arm.model, arm.data, q))
        return upper + np.triu(upper, 1).T

    by_q = by_differences(mass, q)
    coriolis = (by_q @ dq) @ dq - 0.5 * np.einsum("i,ijk,j->k", dq, by_q, dq)
    gravity = by_differences(lambda q: pin.computePotentialEnergy(arm.model, arm.data, q), q)
    np.testing.assert_allclose(arm.bias(q, dq), coriolis + gravity, atol=1e-5)


def test_the_spring_is_the_gradient_of_its_energy(arm: ArmModel, moving) -> None:
    q, dq = moving
    goal = moved(arm.pose(q), (0.01, -0.02, 0.03), (0.1, 0.2, -0.3))

    def energy(q: np.ndarray) -> float:
        return 0.5 * float(K @ pose_error(goal, arm.pose(q)) ** 2)

    torque = ImpedanceController(arm).torque(goal, q, 0 * dq) - arm.bias(q, 0 * dq)
    np.testing.assert_allclose(torque, -by_differences(energy, q), rtol=1e-6, atol=1e-5)


def test_nothing_but_the_bias_acts_on_the_null_space(arm: ArmModel, moving) -> None:
    # The tool's springs and dampers do no work at a motion that leaves the tool where it is.
    q, dq = moving
    null = np.linalg.svd(arm.linearise(q)[1])[2][-1]
    assert np.abs(arm.linearise(q)[1] @ null).max() < 1e-12
    controller = ImpedanceController(arm)
    goal = moved(arm.pose(q), (0.01, 0.02, 0.03), (0.1, 0.1, 0.1))
    torque = controller.torque(goal, q, dq, 0.1, compensate=True) - arm.bias(q, dq)
    assert np.linalg.norm(torque) > 10
    assert abs(null @ torque) < 1e-9
    still = controller.torque(arm.pose(q), q, null) - arm.bias(q, null)
    np.testing.assert_allclose(still, 0, atol=1e-9)


def test_energy_does_not_grow_in_free_motion() -> None:
    # No friction and no contact, the model true: kinetic energy and that of the springs can only
    # go into the dampers.
    _, robot = demo_arm(keep_size=False)
    arm = ArmModel(urdf_of(robot), robot.joint_names, robot.tip)
    scene = Scene(robot, table=-1.0, friction=0.0)
    scene.reset(READY)
    controller = ImpedanceController(arm)
    goal = moved(arm.pose(READY), (0.05, -0.05, 0.05), (0.2, -0.2, 0.2))
    energies: list[float] = []
    for _ in range(1500):
        q, dq = scene.data.qpos.copy(), scene.data.qvel.copy()
        kinetic = pin.computeKineticEnergy(arm.model, arm.data, q, dq)
        kinetic += 0.5 * ROTOR_INERTIA * dq @ dq
        energies.append(kinetic + 0.5 * float(K @ pose_error(goal, arm.pose(q)) ** 2))
        scene.step(controller.torque(goal, q, dq))
    assert energies[-1] < 0.01 * energies[0]
    assert np.diff(energies).max() < 1e-4 * energies[0]


def test_the_compensator_integrates_the_spring_and_forgets(arm: ArmModel, moving) -> None:
    q, dq = moving
    error = np.array([1e-3, 0, 2e-3])
    goal = moved(arm.pose(q), error)
    controller = ImpedanceController(arm)
    without = controller.torque(goal, q, dq)
    for _ in range(500):
        torque = controller.torque(goal, q, dq, 0.01, compensate=True)
    # A constant error for 5 s: the integral is 5 s times K times it.
    expected = 5.0 * K * [*error, 0, 0, 0]
    np.testing.assert_allclose(controller.offset, expected, atol=1e-9)
    pushed = arm.linearise(q)[1].T @ expected
    np.testing.assert_allclose(torque - without, pushed, atol=1e-9)
    np.testing.assert_array_equal(controller.torque(goal, q, dq), without)
    np.testing.assert_array_equal(controller.offset, 0)


@pytest.mark.slow
def test_the_compensator_is_off_but_just_before_the_insertion() -> None:
    _, robot = demo_arm(keep_size=False)
    (trial,) = insert_at_centre(build_cell(robot, urdf_of(robot), hole=0.0104), 1, seed=0)
    log = trial.log
    np.testing.assert_array_equal(log.offset[log.during("approach", "insert", "rest")], 0)
    order = list(dict.fromkeys(log.phase))
    assert order == ["approach", "compensate", "insert", "rest"]
    ramp = np.abs(log.offset[log.during("compensate")]).max(axis=1)
    assert len(ramp) == 5 * ROWS_PER_SECOND
    assert 0 < ramp[0] < 0.5 * ramp[-1]
    assert np.abs(np.diff(ramp)).max() < 0.1 * ramp[-1]

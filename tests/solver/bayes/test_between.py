"""Two arms that visited the same bases."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mukca.solver.bayes.inference import JointPosterior, estimate_all
from mukca.solver.bayes.model import MultiRobotModel, extend
from mukca.solver.bayes.results import between
from mukca.solver.calibration.multi_robot_urdf import Placed, joined_urdf
from mukca.solver.data import (
    FrameError,
    KnownError,
    Pose,
    RobotRecordings,
    measure,
    observe_all,
    turn,
)
from mukca.solver.robot import (
    BallModel,
    ModelError,
    Robot,
    choose_parameters,
    load_robot,
    parse_robot,
    scan,
)
from mukca.tools.simulation import Base, perturb, recorded_by_both

HOME = Pose(np.eye(3), np.zeros(3))
FACING = Pose(turn(np.array([0.0, 0.0, np.pi])), np.array([1.2, 0.0, 0.0]))
BASES = [
    Base(name, np.array(centre), np.array([np.cos(i), np.sin(i), 0.0]))
    for i, (name, centre) in enumerate((("front", [0.6, 0, 0.15]), ("left", [0.55, 0.35, 0.3])))
]


class Pair:
    """A Panda and an arm with six joints, face to face, and what they recorded."""

    def __init__(self, noise: float) -> None:
        generator = np.random.default_rng(6)
        self.robots = [load_robot("panda"), load_robot("ur5e")]
        self.truth = [perturb(robot, generator, 2e-3, 5e-3) for robot in self.robots]
        self.placements = recorded_by_both(
            self.truth, [HOME, FACING], BASES, generator, samples=8, noise=noise
        )

    def fit(
        self, names: tuple[str, ...] = ("front", "left"), deviation: float = 3e-5
    ) -> JointPosterior:
        """Calibrate both on some of the placements."""
        arms = [
            RobotRecordings(robot, [measure(p, robot) for p in own if p.name in names], name=name)
            for robot, own, name in zip(self.robots, self.placements, "AB", strict=True)
        ]
        models = [extend(robot, choose_parameters(robot)) for robot in self.robots]
        scene = observe_all(arms, deviation=deviation)
        return estimate_all(MultiRobotModel(tuple(models)), scene, joint_noise=False)


@pytest.fixture(scope="module")
def exact() -> Pair:
    return Pair(0.0)


def predictions(found: JointPosterior, positions: list[np.ndarray]) -> list[np.ndarray]:
    """Each arm's balls in its own base."""
    pairs = zip(found.arms, positions, strict=True)
    return [arm.predict(q, np.zeros_like(q)) for arm, q in pairs]


@pytest.mark.slow
def test_exact_recordings_tie_the_tools_exactly(exact: Pair) -> None:
    """At the sockets and away from them, though the base frame is known to millimetres only."""
    found = exact.fit(deviation=1e-7)
    pose = between(found, 1).pose
    for a, b in zip(*exact.placements, strict=True):
        q = [p.positions for p in (a, b)]
        near = [q[0] + 0.02, q[1] - 0.02]
        predicted = predictions(found, near)
        true = [
            BallModel(arm, []).points(np.empty(0), at)
            for arm, at in zip(exact.truth, near, strict=True)
        ]
        seen = np.linalg.norm(pose.apply(predicted[1]) - predicted[0], axis=1)
        expected = np.linalg.norm(FACING.apply(true[1]) - true[0], axis=1)
        assert seen == pytest.approx(expected, abs=1e-9)
    assert np.abs(pose.translation - FACING.translation).max() > 1e-4


@pytest.mark.slow
def test_noise_makes_errors_as_large_as_stated() -> None:
    pair = Pair(1e-4)
    found = pair.fit()
    one = between(found, 1)
    assert one.unseen is None and one.shared == 4
    assert one.tools is not None and 5e-5 < one.tools < 1e-3
    errors: list[np.ndarray] = []
    for a, b in zip(*pair.placements, strict=True):
        balls = predictions(found, [a.positions, b.positions])
        errors += [one.pose.apply(balls[1]).mean(axis=0) - balls[0].mean(axis=0)]
    assert np.linalg.norm(errors, axis=1).max() < 3 * one.tools


@pytest.mark.slow
def test_one_base_leaves_a_turn_about_the_line_of_its_sockets(exact: Pair) -> None:
    axis = between(exact.fit(("front",)), 1).unseen
    assert axis is not None
    assert abs(axis @ BASES[0].direction) == pytest.approx(1, abs=1e-2)


def test_arms_that_share_nothing_are_refused(exact: Pair) -> None:
    panda, ur = exact.robots
    arms = [
        RobotRecordings(panda, [measure(exact.placements[0][0], panda)], name="A"),
        RobotRecordings(ur, [measure(exact.placements[1][1], ur)], name="B"),
    ]
    models = [extend(robot, choose_parameters(robot)) for robot in exact.robots]
    with pytest.raises(FrameError, match="frame 'the base of B': nothing ties it to the robot"):
        estimate_all(MultiRobotModel(tuple(models)), observe_all(arms))


def test_one_base_has_one_distance(exact: Pair) -> None:
    panda, ur = exact.robots
    arms = [
        RobotRecordings(panda, [measure(exact.placements[0][0], panda, 0.05)], name="A"),
        RobotRecordings(ur, [measure(exact.placements[1][0], ur, 0.06)], name="B"),
    ]
    with pytest.raises(KnownError, match=r"0.05 m apart for one robot, and 0.06 m for another"):
        observe_all(arms)


def placed(name: str, robot: Robot, pose: Pose) -> Placed:
    return Placed(name, robot, robot.origins, robot.text.data, pose)


def ball(robot: Robot, q: np.ndarray) -> np.ndarray:
    return BallModel(robot, []).points(np.empty(0), q[None])[0]


def test_one_urdf_has_both_arms_where_they_stand(panda: Robot) -> None:
    ur = load_robot("ur5e")
    text = scan(joined_urdf([placed("l", panda, HOME), placed("r", ur, FACING)]), "both")
    for name, robot, pose in (("l", panda, HOME), ("r", ur, FACING)):
        chain = parse_robot(text, source="both", tip=f"{name}_ball_link")
        q = np.linspace(-1, -0.5, len(robot.actuated))
        assert chain.base == "world"
        assert ball(chain, q) == pytest.approx(pose.apply(ball(robot, q)[None])[0])


TORSO = """<robot name="two"><link name="torso"/><link name="chest"/>
<joint name="spine" type="fixed"><origin xyz="0 0 0.5" rpy="0 0 0.3"/>
<parent link="torso"/><child link="chest"/></joint>{arms}</robot>"""
ARM = """<link name="{n}1"/><link name="{n}_ball"/>
<joint name="{n}_shoulder" type="revolute"><origin xyz="0 {y} 0" rpy="0 0.2 0"/><axis xyz="0 0 1"/>
<parent link="chest"/><child link="{n}1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="{n}_hand" type="fixed"><origin xyz="0.4 0 0"/>
<parent link="{n}1"/><child link="{n}_ball"/></joint>"""


def torso(spine: str = "fixed") -> list[Robot]:
    arms = "".join(ARM.format(n=n, y=y) for n, y in (("l", 0.2), ("r", -0.2)))
    data = TORSO.format(arms=arms).replace('"spine" type="fixed"', f'"spine" type="{spine}"')
    return [parse_robot(scan(data.encode(), "t"), source="t", tip=f"{n}_ball") for n in "lr"]


def test_chains_of_one_file_stay_in_it() -> None:
    """What the second base is off goes into the first joint that is its own."""
    left, right = torso()
    off = Pose(turn(np.array([0.01, 0.02, -0.03])), np.array([0.01, -0.02, 0.005]))
    data = joined_urdf([placed("l", left, HOME), placed("r", right, off)])
    assert len(ET.fromstring(data).findall("link")) == 6
    q = np.array([0.4])
    for robot, pose in ((left, HOME), (right, off)):
        chain = parse_robot(scan(data, "t"), source="t", tip=robot.tip)
        assert ball(chain, q) == pytest.approx(pose.apply(ball(robot, q)[None])[0])


def test_a_joint_that_moves_both_chains_is_refused() -> None:
    left, right = torso("continuous")
    with pytest.raises(ModelError, match="joint 'spine' moves both l and r"):
        joined_urdf([placed("l", left, HOME), placed("r", right, HOME)])

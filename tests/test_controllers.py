"""The lines of docs/controllers.md send what brings the true flange to its pose.

Packages of the makers are there only as stand-ins that keep what they are given.
"""

import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mukca
from mukca.solver.calibration import FullModel
from mukca.solver.results import CalibratedRobot

PAGE = Path(__file__).parents[1] / "docs" / "controllers.md"
ARMS = {"Universal Robots": "ur5e", "Franka": "panda", "KUKA": "ur10", "UFACTORY xArm": "xarm6"}
ARMS |= {"lerobot": "so101", "MoveIt 2": "ur5e"}
CONF = "\n".join(f"delta_{name} = [0, 0, 0, 0, 0, 0]" for name in ("theta", "a", "d", "alpha"))


class Recorder:
    """Whatever is called is kept."""

    def __init__(self, q, sent):
        self.q, self.sent = q, sent

    def __getattr__(self, name):
        def call(*words, angle=None, **_):
            self.sent[name] = words if angle is None else (angle,)
            return (0, [*self.q, 0.0]) if name == "get_servo_angle" else list(self.q)

        return call


@pytest.mark.parametrize("maker", ARMS)
def test_the_lines_send_what_they_should(maker, tmp_path, monkeypatch):
    flaws = {"compliance": 5e-5, "transmission": 2e-4}
    truth, _ = mukca.simulate_recordings(mukca.load_robot(ARMS[maker]), 1, samples=2, **flaws)
    arm = FullModel(truth)
    q = np.array(
        [0.1, -0.5, 0.2, -1.9, 0.3, 1.6, 0.8]
        if maker == "Franka"
        else [0.2, -1.2, 1.2, -1.0, 0.9, 0.1]
    )
    q = np.clip(q[: len(arm.robot.actuated)], arm.robot.lower + 0.1, arm.robot.upper - 0.1)
    T, sent = arm.flange(q), {}
    recorder = Recorder(q + 0.01, sent)
    monkeypatch.chdir(tmp_path)
    Path("calibration.conf").write_text(CONF)
    for name, kinds in {
        "rtde_control": ["RTDEControlInterface"],
        "rtde_receive": ["RTDEReceiveInterface"],
        "panda_py": ["Panda"],
        "xarm.wrapper": ["XArmAPI"],
    }.items():
        module = ModuleType(name)
        vars(module).update({kind: lambda *_, **__: recorder for kind in kinds})
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setitem(sys.modules, "xarm", ModuleType("xarm"))
    section = PAGE.read_text().split(f"\n## {maker}\n")[1].split("\n## ")[0]
    names = {"arm": arm, "T": T, "q": q + 0.01, "np": np, "Rotation": Rotation, "mukca": mukca}
    for block in re.findall(r"```python\n(.*?)```", section, re.S):
        assert len(block.splitlines()) <= 10
        exec(block, names)
    CHECKS[maker](arm, q, T, sent, names)


def pose(place, turn):
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = place, turn.as_matrix()
    return T


def reaches(controller, arm, sent, q, T):
    """The controller's joints for what it was sent bring the true flange to the pose."""
    assert np.abs(arm.flange(controller.command(sent, q)) - T).max() < 2e-6


def check_ur(arm, q, T, sent, names):
    robot = mukca.load_robot("ur5e", base="base_link_inertia")
    controller = FullModel(CalibratedRobot(robot, (), np.zeros(0)))
    written = np.array(re.search(r"\[(.*)\]", names["script"])[1].split(","), dtype=float)
    for six in (written, np.array(sent["moveL"][0])):
        reaches(controller, arm, pose(six[:3], Rotation.from_rotvec(six[3:])), q, T)
    assert np.abs(arm.flange(sent["moveJ"][0]) - T).max() < 1e-9


def check_franka(arm, q, T, sent, names):
    place, turn, _ = sent["move_to_pose"]
    reaches(arm.nominal, arm, pose(place, Rotation.from_quat(turn)), q + 0.01, T)
    assert np.abs(arm.flange(sent["move_to_joint_position"][0]) - T).max() < 1e-9


def check_kuka(arm, q, T, sent, names):
    X, Y, Z, A, B, C = map(float, re.findall(r"-?\d+\.\d+", names["line"]))
    turn = Rotation.from_euler("ZYX", [A, B, C], degrees=True)
    reaches(arm.nominal, arm, pose(1e-3 * np.array([X, Y, Z]), turn), q, T)


def check_xarm(arm, q, T, sent, names):
    six = np.array(sent["set_position"])
    reaches(arm.nominal, arm, pose(1e-3 * six[:3], Rotation.from_euler("xyz", six[3:])), q, T)
    assert np.abs(arm.flange(sent["set_servo_angle"][0]) - T).max() < 1e-9


def check_lerobot(arm, q, T, sent, names):
    motors = ["a", "b", "c", "d", "e"]
    robot = SimpleNamespace(
        get_observation=lambda: {
            f"{m}.pos": x for m, x in zip(motors, np.degrees(q) + 1, strict=True)
        },
        send_action=lambda action: np.radians([action[f"{m}.pos"] for m in motors]),
    )
    point = arm.ball(q)
    assert arm.ball(names["act"](robot, point, motors)) == pytest.approx(point, abs=1e-9)


def check_moveit(arm, q, T, sent, names):
    rows = [q, q + 0.02]
    points = [SimpleNamespace(positions=row.tolist()) for row in rows]
    trajectory = SimpleNamespace(joint_trajectory=SimpleNamespace(points=points))
    found = [p.positions for p in names["corrected"](trajectory).joint_trajectory.points]
    assert np.abs(arm.flange(found) - arm.geometric.flange(rows)).max() < 1e-9


EACH = (check_ur, check_franka, check_kuka, check_xarm, check_lerobot, check_moveit)
CHECKS = dict(zip(ARMS, EACH, strict=True))

"""PAL's geometric_calibration: added to the nominal URDF, it gives the calibrated arm."""

import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from imagined import configurations, imagine, poses

import mukca
from mukca import load_calibration

yaml = pytest.importorskip("yaml", reason="PyYAML comes with xacro")
pytest.importorskip("pinocchio", reason="the extra simulation is not installed")
AXES = {"xyz": ("dx", "dy", "dz"), "rpy": ("droll", "dpitch", "dyaw")}
PRESENT = """# the robot's own
robot_state_publisher:
  other: 1
  geometric_calibration:
      arm_left_1_dx: 0.25   # the other arm
      arm_right_2_dx: 9.0
      arm_right_2_dyaw: 9.0
      head_1_dyaw: 0.5
camera:
  arm_right_2_d: 3
"""


@pytest.fixture
def calibration(calibrations, tmp_path):
    """A robot whose joints are called as PAL calls them, one of them upright in pitch."""
    text = mukca.load_robot("panda").text.data.decode()
    text = re.sub(r"panda_joint([1-7])\b", r"arm_right_\1_joint", text)
    turned = text.replace('rpy="1.5707963267948966 0 0"', 'rpy="0.3 1.5707963267948966 0.1"', 1)
    (tmp_path / "robot.urdf").write_text(turned)
    robot = mukca.load_robot(tmp_path / "robot.urdf")
    template = json.loads((calibrations / "fitted.json").read_text())
    file = tmp_path / "calibration.json"
    file.write_text(json.dumps(imagine(robot, template)))
    return file


def applied(urdf, file):
    """What robot_state_publisher makes of a URDF and the file."""
    entries = yaml.safe_load(file.read_text())["robot_state_publisher"]["geometric_calibration"]
    root = ET.fromstring(urdf)
    for joint in root.iter("joint"):
        key, origin = joint.get("name").removesuffix("_joint"), joint.find("origin")
        for attribute, suffixes in AXES.items():
            numbers = map(float, origin.get(attribute).split())
            changes = (entries.pop(f"{key}_{suffix}", 0.0) for suffix in suffixes)
            new = (repr(n + change) for n, change in zip(numbers, changes, strict=True))
            origin.set(attribute, " ".join(new))
    return ET.tostring(root, encoding="unicode"), entries


def test_added_to_the_nominal_urdf_it_gives_the_calibrated_one(export, calibration, tmp_path):
    out = tmp_path / "master_calibration.yaml"
    status, shown, error = export(calibration, "--to", "pal", "--out", out)
    assert status == 0, error
    assert "Copy it to /etc/calibration" in shown
    loaded = load_calibration(calibration)
    robot, nominal = loaded.robot, loaded.document.model.nominal_urdf
    urdf, left = applied(nominal, out)
    assert not left
    q, flange = configurations(robot, 20), robot.ball_joint.parent
    expected = poses(loaded.calibrated.urdf().decode(), flange, q)
    assert np.abs(poses(urdf, flange, q) - expected).max() < 1e-12
    assert np.abs(poses(nominal, flange, q) - expected).max() > 1e-3


def test_what_is_of_other_joints_stays(export, calibration, tmp_path):
    alone, both, like = (tmp_path / f"{name}.yaml" for name in ("alone", "both", "like"))
    like.write_text(PRESENT)
    words = (calibration, "--to", "pal", "--out")
    assert export(*words, alone)[0] == 0
    status, _, error = export(*words, both, "--like", like)
    assert status == 0, error
    old, new, own = (yaml.safe_load(file.read_text()) for file in (like, both, alone))
    entries, others, expected = (
        document["robot_state_publisher"].pop("geometric_calibration")
        for document in (new, old, own)
    )
    kept = {key: others[key] for key in ("arm_left_1_dx", "head_1_dyaw")}
    assert entries == kept | expected and new == old


def test_what_cannot_be_gets_one_line(refused, calibrations, calibration, tmp_path):
    words = ("--to", "pal", "--out", tmp_path / "new.yaml")
    ur5e = calibrations / "ur5e.json"
    refused("not named like the joints of a robot of PAL", "export", ur5e, *words)
    like = tmp_path / "like.yaml"
    refused("No such file", "export", calibration, *words, "--like", like)
    like.write_text("robot_state_publisher: {}\n")
    refused("no geometric_calibration", "export", calibration, *words, "--like", like)


def test_read_again_it_gives_the_calibrated_arm(export, calibration, tmp_path):
    """Also of a calibration that began with such a file: its entries are of the URDF alone."""
    first, second = tmp_path / "first.yaml", tmp_path / "second.yaml"
    assert export(calibration, "--to", "pal", "--out", first)[0] == 0
    calibrated, nominal = load_calibration(calibration).calibrated, tmp_path / "robot.urdf"
    read = mukca.load_robot(f"{nominal}+{first}")
    q = configurations(read, 20)
    flange = read.ball_joint.parent
    expected = poses(calibrated.urdf().decode(), flange, q)
    assert np.abs(poses(read.text.data.decode(), flange, q) - expected).max() < 1e-9
    assert np.abs(poses(nominal.read_text(), flange, q) - expected).max() > 1e-3
    document = json.loads(calibration.read_text())
    again = tmp_path / "again.json"
    again.write_text(json.dumps(imagine(read, document)))
    assert export(again, "--to", "pal", "--out", second)[0] == 0
    expected = poses(load_calibration(again).calibrated.urdf().decode(), flange, q)
    both = mukca.load_robot(f"{nominal}+{second}")
    assert np.abs(poses(both.text.data.decode(), flange, q) - expected).max() < 1e-9
    text = nominal.read_text()
    nominal.write_text(text.replace('xyz="0 0 0.333"', 'xyz="0 0 0.433"'))  # another robot's
    assert nominal.read_text() != text
    third = (again, "--to", "pal", "--out", tmp_path / "third.yaml")
    refusal = "cannot be read as it was calibrated"
    assert (export(*third)[0], refusal in export(*third)[2]) == (2, True)
    nominal.unlink()
    status, _, error = export(*third)
    assert status == 2 and refusal in error


def test_lines_may_end_as_windows_ends_them(calibration):
    """Also behind the mark that it puts before a text."""
    file, windows = (calibration.with_name(f"{name}.yaml") for name in ("of_robot", "windows"))
    file.write_text("geometric_calibration:\n  arm_right_2_dx: 0.01\n  arm_right_2_dyaw: 0.1\n")
    windows.write_bytes(file.read_text().replace("\n", "\r\n").encode("utf-8-sig"))
    urdf = calibration.with_name("robot.urdf")
    nominal, plain, other = (
        mukca.load_robot(f"{urdf}{added}").text.origins for added in ("", f"+{file}", f"+{windows}")
    )
    assert other == plain != nominal


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("a: 1", "no geometric_calibration with an entry a line"),
        ("arm_left_3_dx: 0.1", ":3: no joint of the URDF is called 'arm_left_3_joint'"),
        ("arm_right_3_dw: 0.1", ":3: expected an entry such as arm_1_dx: 0.001"),
        ("arm_right_3_dx: much", ":3: expected an entry such as arm_1_dx: 0.001"),
        ("arm_right_3_dx: 0.1\n    arm_right_3_dx: 0.1", ":4: another line has 'arm_right_3_dx'"),
        ("arm_right_3_droll: 20", "are these degrees?"),
        ("# none", "no entry stands below geometric_calibration"),
    ],
)
def test_an_entry_that_cannot_be_added_gets_one_line(content, words, refused, calibration):
    file = calibration.with_name("of_robot.yaml")
    title = "" if content == "a: 1" else "robot_state_publisher:\n  geometric_calibration:\n    "
    file.write_text(f"{title}{content}\n")
    urdf = calibration.with_name("robot.urdf")
    refused(words, "check", calibration.parent, "--robot", f"{urdf}+{file}")

"""Files for ROS: expanded by the real xacro and read by Pinocchio, they give the calibrated arm.

The xacro of a description package is imitated: the URDF, in which the origins of the joints that
the file carries stand as ``${...}`` of the file's keys.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from imagined import configurations, edited, poses, rigid

import mukca
from mukca import load_calibration

xacro = pytest.importorskip("xacro", reason="xacro is not installed")
yaml = pytest.importorskip("yaml", reason="PyYAML comes with xacro")
pinocchio = pytest.importorskip("pinocchio", reason="the extra simulation is not installed")

KEYS = {"shoulder_pan": "shoulder", "shoulder_lift": "upper_arm", "elbow": "forearm"}
KEYS |= {f"wrist_{i}": f"wrist_{i}" for i in (1, 2, 3)}
UR = {f"{name}_joint": f"k['kinematics']['{key}']" for name, key in KEYS.items()}
FRANKA = {f"_joint{i}": f"k['joint{i}']['kinematic']" for i in range(1, 9)}
MY_ROBOT = Path(__file__).with_name("my_robot.yaml")
"""A file as ur_calibration writes it for a UR5e."""
XARM = {f"joint{i}": f"k['kinematics']['joint{i}']" for i in range(1, 7)}


def hooked(urdf, hooks, head):
    """Return a URDF as a xacro, with other elements for the origins of some joints."""
    for name, origin in hooks.items():
        begin = re.search(rf'<joint name="{re.escape(name)}"', urdf)
        end = urdf.index("</joint>", begin.end())
        body = re.sub(r"<origin [^>]*/>", "", urdf[begin.end() : end])
        urdf = urdf[: begin.end()] + body + origin + urdf[end:]
    start = re.search(r"<robot [^>]*", urdf)
    space = ' xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
    return urdf[: start.end()] + space + head + urdf[start.end() + 1 :]


def by_key(key):
    """An origin as ur_description, franka_description and xarm_description write it."""
    xyz, rpy = (
        " ".join(f"${{{key}['{part}']}}" for part in parts)
        for parts in (("x", "y", "z"), ("roll", "pitch", "yaw"))
    )
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>'


def expanded(text, folder):
    """What the real xacro makes of it."""
    file = folder / "arm.urdf.xacro"
    file.write_text(text)
    return xacro.process_file(str(file)).toxml()


def positions(urdf, link, q):
    """Where Pinocchio has a link's origin, shape (N, 3)."""
    return poses(urdf, link, q)[:, :3, 3]


def names_ending(robot, endings):
    names = [joint.name for joint in robot.joints]
    return {next(n for n in names if n.endswith(end)): key for end, key in endings.items()}


def check_yaml(file, calibration, format_, endings, export, folder):
    """Export, expand, read; the flange is where calibrated.urdf has it."""
    out = folder / "kinematics.yaml"
    status, said, err = export(file, "--to", format_, "--out", out)
    assert status == 0, err
    robot = calibration.robot
    hooks = {n: by_key(key) for n, key in names_ending(robot, endings).items()}
    head = f'<xacro:property name="k" value="${{xacro.load_yaml(\'{out}\')}}"/>\n'
    nominal = calibration.document.model.nominal_urdf
    urdf = expanded(hooked(nominal, hooks, head), folder)
    q, flange = configurations(robot, 20), robot.ball_joint.parent
    expected = positions(calibration.calibrated.urdf().decode(), flange, q)
    assert np.abs(positions(urdf, flange, q) - expected).max() < 1e-12
    assert np.abs(positions(nominal, flange, q) - expected).max() > 1e-3
    assert f"the ball's place on {flange}" in said
    assert "mukca" in yaml.safe_load(out.read_text())


def test_tesseracts_joints_stand_where_the_urdf_has_them(export, calibrations, tmp_path):
    """Each is put there by a command that changes a joint's origin."""
    for name in ("ur5e", "panda", "uf850"):
        file, out = calibrations / f"{name}.json", tmp_path / f"{name}.yaml"
        assert export(file, "--to", "tesseract", "--out", out)[0] == 0
        calibration = load_calibration(file)
        *joints, ball = calibration.robot.joints
        read = yaml.safe_load(out.read_text())["calibration"]["joints"]
        assert list(read) == [joint.name for joint in joints] and ball.name not in read
        for row, origin in zip(read.values(), calibration.calibrated.origins[:-1], strict=True):
            place = [row["position"][axis] for axis in "xyz"]
            x, y, z, w = (row["orientation"][axis] for axis in "xyzw")
            R = pinocchio.Quaternion(w, x, y, z).matrix()
            assert np.abs(place - origin[:3]).max() < 1e-15
            assert np.abs(R - rigid(origin)[:3, :3]).max() < 1e-14


@pytest.mark.parametrize("name", ["panda", "fr3", "ur3e", "ur5e", "ur10e"])
def test_kinematics_yaml_of_frankas_and_of_universal_robots(export, calibrations, tmp_path, name):
    file = calibrations / f"{name}.json"
    format_, endings = ("ur", UR) if name.startswith("ur") else ("franka", FRANKA)
    check_yaml(file, load_calibration(file), format_, endings, export, tmp_path)


def renamed(file, out, words):
    """Write the same calibration of an arm whose links and joints are called otherwise."""
    text = file.read_text()
    for old, new in words.items():
        text = text.replace(old, new)
    out.write_text(text)
    return out


def test_xarms_kinematics_yaml(export, calibrations, tmp_path):
    words = {f"joint_{i}": f"joint{i}" for i in range(1, 7)} | {"base_link": "link_base"}
    file = renamed(calibrations / "gen3_lite.json", tmp_path / "xarm6.json", words)
    check_yaml(file, load_calibration(file), "xarm", XARM, export, tmp_path)


def test_a_fixed_joint_that_moved_goes_into_the_next_one(export, calibrations, tmp_path):
    joint = "base_link-base_link_inertia"

    def turn(document):
        other = next(p for p in document["parameters"] if p["component"] == "roll")
        changed = {"nominal": 0.0, "calibrated": 0.01, "exported": 0.01}
        document["parameters"] = [
            {**other, "name": f"{joint}.roll", "joint": joint, **changed},
            *document["parameters"],
        ]

    file = edited(calibrations / "ur5e.json", tmp_path / "turned.json", turn)
    check_yaml(file, load_calibration(file), "ur", UR, export, tmp_path)


def test_a_xacro_of_ones_own_includes_the_overlay(export, imagined, tmp_path):
    file, calibration = imagined
    out = tmp_path / "overlay.xacro"
    assert export(file, "--to", "xacro", "--out", out)[0] == 0
    robot = calibration.robot
    joints = [joint.name for joint in robot.joints]
    hooks = {name: f'<xacro:calibrated_origin joint="{name}"/>' for name in joints}
    head = f'<xacro:include filename="{out}"/>\n'
    urdf = expanded(hooked(calibration.document.model.nominal_urdf, hooks, head), tmp_path)
    (tmp_path / "expanded.urdf").write_text(urdf)
    read = mukca.load_robot(tmp_path / "expanded.urdf")
    origins = calibration.calibrated.model.origins(calibration.calibrated.exported)
    assert np.array_equal(read.origins, origins)  # to the last digit
    q = configurations(robot, 20)
    found = positions(urdf, robot.tip, q)
    assert np.abs(found - calibration.calibrated.geometric_ball(q)).max() < 1e-9


def test_a_tool_is_added_to_the_urdf(export, calibrations, tmp_path):
    file, out = calibrations / "panda.json", tmp_path / "with_tools.urdf"
    words = ("--tool", "gripper=0.01,0.02,0.1,0,0,1.5", "--tool", "camera=0,0,0.05,0.1,0.2,0.3")
    assert export(file, "--to", "urdf", *words, "--flange", "panda_link8", "--out", out)[0] == 0
    text = out.read_text()
    q = configurations(mukca.load_robot("panda"), 5)
    calibration = load_calibration(file)
    found = positions(text, "ball_link", q)
    assert np.abs(found - calibration.calibrated.geometric_ball(q)).max() < 1e-9
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q[0])
    flange, tool = (data.oMf[model.getFrameId(n)] for n in ("panda_link8", "gripper"))
    place = flange.actInv(tool)
    assert np.abs(place.translation - [0.01, 0.02, 0.1]).max() < 1e-12
    assert np.abs(pinocchio.log3(place.rotation) - [0, 0, 1.5]).max() < 1e-12
    assert "sha256" in text and 'link name="camera"' in text
    yourdfpy = pytest.importorskip("yourdfpy", reason="the extra meshes is not installed")
    other = yourdfpy.URDF.load(str(out), load_meshes=False)
    other.update_cfg(dict(zip(calibration.robot.joint_names, q[0], strict=True)))
    ball = other.get_transform("ball_link", "base_link")[:3, 3]
    assert np.abs(ball - calibration.calibrated.geometric_ball(q[0])).max() < 1e-9


def test_the_makers_hash_is_kept_and_never_made_up(export, calibrations, tmp_path):
    words = (calibrations / "ur5e.json", "--to", "ur", "--out", tmp_path / "a.yaml")
    _, said, _ = export(*words)
    own = yaml.safe_load((tmp_path / "a.yaml").read_text())["kinematics"]["hash"]
    assert own.startswith("mukca_") and "harmless" in said
    status, said, _ = export(*words, "--like", MY_ROBOT, "--force")
    kept = yaml.safe_load((tmp_path / "a.yaml").read_text())["kinematics"]["hash"]
    assert status == 0 and kept == "calib_12788084448423163542" and "harmless" not in said


def test_every_number_is_a_number_to_yaml_1_1(export, calibrations, tmp_path):
    def shrink(document):
        for value in document["parameters"]:
            value["exported"] = 1e-5

    file = edited(calibrations / "ur5e.json", tmp_path / "a.json", shrink)
    export(file, "--to", "ur", "--out", tmp_path / "a.yaml")
    read = yaml.safe_load((tmp_path / "a.yaml").read_text())["kinematics"]
    assert all(isinstance(v, float) for key in read if key != "hash" for v in read[key].values())


def test_a_file_of_another_robot_is_refused(refused, calibrations, tmp_path):
    """A UR10e's shoulder stands 18 mm higher than a UR5e's, its elbow 188 mm farther."""
    file, text = tmp_path / "other.yaml", MY_ROBOT.read_text()
    file.write_text(text.replace("0.1625", "0.1807").replace("-0.425", "-0.6127"))
    words = ("--to", "ur", "--like", file, "--out", tmp_path / "a.yaml")
    refused("another robot's", "export", calibrations / "ur5e.json", *words)
    file.write_text(text.partition("  hash")[0])
    refused("no `hash`", "export", calibrations / "ur5e.json", *words)
    assert not (tmp_path / "a.yaml").exists()


def test_another_first_link_is_told_with_the_one_that_is_needed(calibrations, tmp_path, refused):
    file = tmp_path / "calibration.json"
    file.write_text((calibrations / "panda.json").read_text().replace("panda_link0", "foot"))
    words = ("export", file, "--to", "franka", "--out", tmp_path / "a.yaml")
    line = refused("the parent of panda_joint1 is foot, in a Franka arm panda_link0", *words)
    assert "--base panda_link0" in line

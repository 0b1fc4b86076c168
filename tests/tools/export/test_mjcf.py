"""A MuJoCo model of one's own is corrected; MuJoCo itself reads it back."""

import re
import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np
import pytest
from cases import by_table
from imagined import configurations, edited, rigid

import mukca
from mukca import load_robot

mujoco = pytest.importorskip("mujoco", reason="the extra simulation is not installed")

BASE = rigid((0.4, -0.2, 0.8, 0.2, -0.3, 2.0))
"""The arm's base in the world."""


HEAD = """<!-- mine -->
<mujoco model="cell">
  <compiler angle="radian"/>
  <default><joint damping='1'/></default>
  <worldbody>
    <geom size="1 1 .1"
      type="plane"/><!-- floor -->
    <light pos='0 0 3'/>"""


def frames(robot, seed=0):
    """Where each URDF link stands on its body, whose origin is on the axis; the base's first."""
    rng = np.random.default_rng(seed)
    carriers = [rigid(rng.uniform(-0.3, 0.3, 6))]
    for joint in robot.actuated:
        along = np.array(joint.axis) * rng.uniform(-0.3, 0.3)
        carriers.append(np.linalg.inv(rigid((*along, *rng.uniform(-2, 2, 3)))))
    return carriers


def numbers(values):
    return " ".join(map(repr, np.asarray(values, dtype=float).tolist()))


def pose(T, euler):
    """A body's attributes, in either of the words that models use."""
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(T[:3, :3]).ravel())
    if not euler:
        return f'quat="{numbers(quat)}" pos="{numbers(T[:3, 3])}"'
    axis = quat[1:] / np.linalg.norm(quat[1:])
    angle = 2 * np.arctan2(np.linalg.norm(quat[1:]), quat[0])
    return f"axisangle='{numbers([*axis, angle])}'  pos='{numbers(T[:3, 3])}'"


def model_of(robot, prefix="", welded=True):
    """Return a MuJoCo model of the nominal arm as somebody may have written it."""
    carriers = frames(robot)
    text = [HEAD]
    text.append(f'    <body name="stand" {pose(BASE @ np.linalg.inv(carriers[0]), False)}>')
    place, depth, count = carriers[0], 1, 0
    for joint in robot.joints:
        place = place @ rigid(joint.origin.xyz + joint.origin.rpy)
        if not joint.actuated:
            continue
        count += 1
        place = place @ np.linalg.inv(carriers[count])
        if welded and count == 3:  # a body between two joints
            half = rigid((0.1, 0.0, -0.05, 0.3, 0.0, 0.0))
            text.append(f'<body name="cover" {pose(half, True)}>')
            place, depth = np.linalg.inv(half) @ place, depth + 1
        axis = carriers[count][:3, :3] @ joint.axis
        kind = "slide" if joint.type == "prismatic" else "hinge"
        name = prefix + joint.name
        text.append(f'<body  name="{name}_body" {pose(place, count % 2 == 0)} >')
        text.append(f"  <joint name='{name}' type='{kind}' axis='{numbers(axis)}'/>")
        text.append('  <inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.1 0.1"/>')
        place, depth = carriers[count], depth + 1
    text.append("</body>" * depth + "\n  </worldbody>\n  <actuator>")
    text += [f'    <position joint="{prefix}{name}" kp="100"/>' for name in robot.joint_names]
    return "\n".join([*text, "  </actuator>", "</mujoco>\n"])


def balls(file, robot, last, place, q):
    """Where MuJoCo has the ball, in the frame of the URDF's base."""
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    found = []
    for row in q:
        for name, value in zip(robot.joint_names, row, strict=True):
            joint = next(model.joint(j) for j in range(model.njnt) if name in model.joint(j).name)
            data.qpos[joint.qposadr[0]] = value
        mujoco.mj_kinematics(model, data)
        body = data.body(last)
        ball = body.xmat.reshape(3, 3) @ place + body.xpos
        found.append(np.linalg.inv(BASE)[:3, :3] @ (ball - BASE[:3, 3]))
    return np.array(found)


def ball_on_last_body(calibration):
    """The ball in the frame of the last joint's body, with the calibrated origins behind it."""
    robot, calibrated = calibration.robot, calibration.calibrated
    last = max(i for i, joint in enumerate(robot.joints) if joint.actuated)
    place = frames(robot)[-1]
    for origin in calibrated.model.origins(calibrated.exported)[last + 1 :]:
        place = place @ rigid(origin)
    return place[:3, 3]


def test_mujoco_reads_back_the_calibrated_arm(export, imagined, tmp_path):
    prefix = "left/"
    file, calibration = imagined
    robot = calibration.robot
    mine, out = tmp_path / "mine.xml", tmp_path / "corrected.xml"
    mine.write_text(model_of(robot, prefix))
    status, said, err = export(file, "--to", "mjcf", "--like", mine, "--out", out)
    assert status == 0, err
    last = f"{prefix}{robot.joint_names[-1]}_body"
    q = configurations(robot, 10)
    expected = calibration.calibrated.geometric_ball(q)
    found = balls(out, robot, last, ball_on_last_body(calibration), q)
    assert np.abs(found - expected).max() < 1e-9
    found = balls(mine, robot, last, ball_on_last_body(calibration), q)
    assert np.abs(found - expected).max() > 1e-4
    assert "the ball's place" not in said and "Keyframes" in said
    model = mujoco.MjModel.from_xml_path(str(out))
    site = model.site("mukca_ball")
    assert model.body(site.bodyid[0]).name == last
    assert np.abs(site.pos - ball_on_last_body(calibration)).max() < 1e-9


def motions(model, names, q):
    """How the last body screws from each configuration to the next: its angle, and how far.

    Both are the same wherever the frames of the base and of the body stand.
    """
    data = mujoco.MjData(model)
    poses = []
    for row in q:
        for name, value in zip(names, row, strict=True):
            data.qpos[model.joint(name).qposadr[0]] = value
        mujoco.mj_kinematics(model, data)
        body = data.body(model.jnt_bodyid[model.joint(names[-1]).id])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        poses.append(pose)
    found = []
    for one, other in pairwise(poses):
        T = np.linalg.inv(one) @ other
        (x, y, z), cosine = (T - T.T)[[2, 0, 1], [1, 2, 0]] / 2, (np.trace(T[:3, :3]) - 1) / 2
        sine = np.linalg.norm([x, y, z])
        found.append((np.arctan2(sine, cosine), T[:3, 3] @ [x, y, z] / sine))
    return np.array(found)


@pytest.mark.parametrize(("digits", "told"), [(5, False), (3, True)])
def test_a_model_with_rounded_numbers_moves_as_the_calibrated_arm(
    export, calibrations, tmp_path, digits, told
):
    calibration = mukca.load_calibration(calibrations / "ur5e.json")
    robot, mine, out = calibration.robot, tmp_path / "mine.xml", tmp_path / "out.xml"
    number = r"-?\d+\.\d{6,}(e-\d+)?"
    mine.write_text(re.sub(number, lambda n: f"{float(n[0]):.{digits}f}", model_of(robot)))
    words = ("--to", "mjcf", "--like", mine, "--out", out)
    status, said, err = export(calibrations / "ur5e.json", *words)
    assert status == 0, err
    assert ("in the new file it is the calibrated arm's" in said) == told
    q = configurations(robot, 12)
    calibrated = mujoco.MjModel.from_xml_string(calibration.calibrated.urdf().decode())
    expected = motions(calibrated, robot.joint_names, q)
    off = motions(mujoco.MjModel.from_xml_path(str(out)), robot.joint_names, q) - expected
    assert np.abs(off).max() < 1e-9
    off = motions(mujoco.MjModel.from_xml_path(str(mine)), robot.joint_names, q) - expected
    assert np.abs(off).max() > 1e-4


def two_arms(folder):
    """Two Pandas in a scene, each in a file that it includes where its bodies stand."""
    for side in ("left", "right"):
        model = model_of(load_robot("panda"), f"{side}/", welded=False)
        arm = model[model.index("<body") : model.rindex("</body>")] + "</body>"
        arm = arm.replace('name="stand"', f'name="{side}"')
        (folder / f"{side}.xml").write_text(f"<mujocoinclude>\n{arm}\n</mujocoinclude>\n")
    scene = folder / "scene.xml"
    included = '<include file="left.xml"/><include file="right.xml"/>'
    head = '<mujoco><compiler angle="radian"/><worldbody>'
    scene.write_text(f"{head}{included}</worldbody></mujoco>")
    return scene


def test_one_of_two_arms_in_files_that_a_scene_includes(export, refused, calibrations, tmp_path):
    file, scene, out = calibrations / "panda.json", two_arms(tmp_path), tmp_path / "out.xml"
    words = (file, "--to", "mjcf", "--like", scene, "--out", out)
    refused("--joints 'left/*'", "export", *words)
    assert not out.exists()
    before = mujoco.MjModel.from_xml_path(str(scene))
    status, said, err = export(*words, "--joints", "right/*")
    assert status == 0 and f"It is {tmp_path / 'right.xml'}, corrected" in said, err
    out.rename(tmp_path / "right.xml")
    assert "sha256" in (tmp_path / "right.xml").read_text()
    calibration = mukca.load_calibration(file)
    names, q = calibration.robot.joint_names, configurations(calibration.robot, 5)
    calibrated = mujoco.MjModel.from_xml_string(calibration.calibrated.urdf().decode())
    after = mujoco.MjModel.from_xml_path(str(scene))
    for side, model, its in (("right/", calibrated, names), ("left/", before, None)):
        mine = [side + name for name in names]
        off = motions(after, mine, q) - motions(model, its or mine, q)
        assert np.abs(off).max() < 1e-9
    words = (file, "--to", "mjcf", "--like", tmp_path / "left.xml", "--out", out)
    refused("name the model that includes it", "export", *words)


def test_a_tool_that_was_found_has_a_site(export, calibrations, tmp_path):
    xyz, parent = [0.01, 0.02, 0.1], load_robot("panda").ball_joint.parent
    tool = {"name": "tip", "parent": parent, "xyz": xyz, "rpy": [0.3, 0, 0]}
    tool["covariance"] = [[0.0] * 3] * 3

    def add(document):
        document["tools"] = [tool, {**tool, "name": "camera", "parent": "panda_link0"}]

    file = edited(calibrations / "panda.json", tmp_path / "panda.json", add)
    mine, out = tmp_path / "mine.xml", tmp_path / "corrected.xml"
    mine.write_text(model_of(load_robot("panda")))
    assert export(file, "--to", "mjcf", "--like", mine, "--out", out)[0] == 0
    model = mujoco.MjModel.from_xml_path(str(out))
    assert [model.site(i).name for i in range(model.nsite)] == ["mukca_ball", "mukca_tip"]
    origin = mukca.load_calibration(file).calibrated.origins[-1]
    apart = np.linalg.norm(model.site("mukca_tip").pos - model.site("mukca_ball").pos)
    assert abs(apart - np.linalg.norm(xyz - origin[:3])) < 1e-12


def test_all_else_is_untouched_to_the_byte(export, calibrations, tmp_path):
    mine, out = tmp_path / "mine.xml", tmp_path / "corrected.xml"
    text = model_of(load_robot("panda"))
    mine.write_text(text)
    export(calibrations / "panda.json", "--to", "mjcf", "--like", mine, "--out", out)
    corrected = out.read_text()

    def without_places(model):
        bodies = r"(<body  name=\"panda_joint\d_body\")[^>]*?( >)"
        return re.sub(bodies, r"\1\2", model)

    added = re.compile(r'  <custom><text name="mukca" data="[^"]*sha256[^"]*"/></custom>\n')
    assert len(added.findall(corrected)) == 1
    site = re.compile(r'\n<site name="mukca_ball" [^>]*/>')
    kept = site.sub("", added.sub("", corrected))
    assert without_places(kept) == without_places(text)
    assert not re.search(r"panda_joint\d_body\"[^>]*axisangle", corrected)
    assert 'name="cover" axisangle' in corrected
    assert mine.read_text() == text


def test_urdf_models_that_mujoco_saved(export, calibrations, tmp_path):
    """What MuJoCo itself makes of the nominal URDF can be corrected as well."""
    calibration = mukca.load_calibration(calibrations / "iiwa14.json")
    (tmp_path / "nominal.urdf").write_text(calibration.document.model.nominal_urdf)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "nominal.urdf"))
    mujoco.mj_saveLastXML(str(tmp_path / "mine.xml"), model)
    root = ET.parse(tmp_path / "mine.xml").getroot()
    assert root.find(".//body") is not None
    words = ("--to", "mjcf", "--like", tmp_path / "mine.xml", "--out", tmp_path / "out.xml")
    status, _, err = export(calibrations / "iiwa14.json", *words)
    assert status == 0, err


@by_table("robot", "arm", "old", "new", "said")
def test_a_model_that_does_not_fit_is_refused(
    refused, calibrations, tmp_path, robot, arm, old, new, said
):
    mine, out = tmp_path / "mine.xml", tmp_path / "out.xml"
    text, count = re.subn(old, new, model_of(load_robot(arm)))
    assert count
    mine.write_text(text)
    words = ("--to", "mjcf", "--like", mine, "--out", out)
    refused(said, "export", calibrations / f"{robot}.json", *words)
    assert not out.exists()


def test_an_axis_the_other_way_round_is_told(refused, calibrations, tmp_path):
    def other_way(axis):
        return numbers(-np.array(axis[0].split(), float))

    axis = r"(?<=name='panda_joint5' type='hinge' axis=')[^']*"
    mine = tmp_path / "mine.xml"
    mine.write_text(re.sub(axis, other_way, model_of(load_robot("panda"))))
    words = (calibrations / "panda.json", "--to", "mjcf", "--like", mine, "--out", tmp_path / "o")
    refused("counts its angles otherwise", "export", *words)


def test_it_needs_a_model(refused, calibrations, tmp_path):
    words = (calibrations / "panda.json", "--to", "mjcf", "--out", tmp_path / "a.xml")
    for like, said in (((), "--like FILE"), (("--like", tmp_path), "no such file")):
        refused(said, "export", *words, *like)

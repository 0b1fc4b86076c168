"""Reading chains of any shape, and editing text without touching the rest."""

from pathlib import Path

import numpy as np
import pytest
import yourdfpy
from cases import by_table

from mukca.solver.identification.robot import (
    BallModel,
    ModelError,
    Origin,
    load_robot,
    scan,
    set_origins,
    shipped_robots,
)
from mukca.solver.results import relocate_meshes

ODD_ARM = Path(__file__).with_name("odd_arm.urdf").read_text()
"""Every kind of joint, axes of any direction and length, origins whole, half and missing."""


@pytest.fixture
def odd(tmp_path):
    file = tmp_path / "odd.urdf"
    file.write_text(ODD_ARM)
    return file


def yourdfpy_ball(file, base, names, q):
    model = yourdfpy.URDF.load(str(file), load_meshes=False)
    cfg = dict(zip(names, q, strict=True))
    model.update_cfg({name: cfg.get(name, 0.0) for name in model.actuated_joint_names})
    return model.get_transform("ball_link", base)[:3, 3]


def test_the_chain_is_found_by_names(odd):
    robot = load_robot(str(odd))
    assert [j.name for j in robot.joints] == [
        "mount", "turn", "slide", "endless", "still", "ball_joint",
    ]  # fmt: skip
    assert robot.joint_names == ("turn", "slide", "endless")
    assert np.linalg.norm([j.axis for j in robot.joints], axis=1) == pytest.approx(1)
    assert load_robot(str(odd), base="b").joint_names == ("slide", "endless")


def test_the_axis_of_a_fixed_joint_means_nothing(odd):
    nominal = load_robot(str(odd))
    odd.write_text(
        ODD_ARM.replace(
            '<joint name="still" type="fixed">',
            '<joint name="still" type="fixed"><axis xyz="0 0 0"/>',
        )
    )
    robot = load_robot(str(odd))
    q = np.full((1, 3), 0.3)
    points = [BallModel(r, []).points(np.empty(0), q) for r in (nominal, robot)]
    assert np.array_equal(*points)


@pytest.mark.parametrize("base", ["world", "b"])
def test_forward_kinematics_agree_with_yourdfpy(odd, base):
    # yourdfpy wants unit axes, so the comparison file is given them.
    robot = load_robot(str(odd), base=base)
    text = ODD_ARM
    for xyz, joint in (("1 2 -0.5", "turn"), ("0 -3 1", "slide")):
        axis = np.array(xyz.split(), float)
        text = text.replace(xyz, " ".join(map(repr, (axis / np.linalg.norm(axis)).tolist())))
        assert joint in text
    unit = odd.with_name("unit.urdf")
    unit.write_text(text)
    model = BallModel(robot, [])
    for q in np.random.default_rng(0).uniform(-1.5, 1.5, (20, len(robot.actuated))):
        expected = yourdfpy_ball(unit, base, robot.joint_names, q)
        assert model.points(np.empty(0), q[None])[0] == pytest.approx(expected, abs=1e-12)


def test_masses_beside_the_chain_are_carried_along(odd):
    odd.write_text(
        ODD_ARM.replace(
            '<link name="finger"/>',
            '<link name="finger"><inertial><origin xyz="0.1 0.2 0.3" rpy="1 1 1"/>'
            '<mass value="2"/></inertial></link>',
        ).replace(
            '<child link="finger"/>', '<child link="finger"/><origin xyz="1 2 3" rpy="0.3 -1 2"/>'
        )
    )
    model = yourdfpy.URDF.load(str(odd), load_meshes=False)
    expected = model.get_transform("finger", "d") @ [0.1, 0.2, 0.3, 1]
    (body,) = load_robot(str(odd)).bodies
    assert (body.joint, body.mass) == (3, 2.0)
    assert body.centre == pytest.approx(expected[:3], abs=1e-12)


@pytest.mark.parametrize(
    "line",
    [
        '<xacro:property name="reach" value="0.85"/>',
        '<xacro:property name="twice" value="${2 * reach}"/>',
        '<xacro:property name="at"><origin xyz="1 ${2 * reach} 3"/></xacro:property>',
        '<xacro:arg name="prefix" default="$(env ARM)"/>',
    ],
)
def test_properties_that_nothing_uses_change_nothing(odd, line):
    q = np.random.default_rng(0).uniform(-1, 1, (5, 4))
    before = BallModel(load_robot(str(odd)), []).points(np.empty(0), q)
    odd.write_text(ODD_ARM.replace('<link name="world"/>', f'{line}<link name="world"/>'))
    assert np.array_equal(BallModel(load_robot(str(odd)), []).points(np.empty(0), q), before)


def test_edits_touch_nothing_else(odd):
    text = scan(odd.read_bytes(), "odd")
    new = set_origins(
        text,
        {
            "turn": Origin((1, 2, 3), (0, 0, 0)),
            "slide": Origin((0.1, 0, 0.2), (0.5, 0, 0)),
            "still": Origin((0.01, 0.02, 0.07), (-1, 0.5, 2)),
            "endless": text.origins["endless"],
        },
    ).decode()
    expected = (
        ODD_ARM.replace('<joint name="turn" type="revolute">',
                        '<joint name="turn" type="revolute"><origin xyz="1.0 2.0 3.0"/>')
        .replace('<origin xyz="0.1 0 0.2"/>', '<origin xyz="0.1 0 0.2" rpy="0.5 0.0 0.0"/>')
        .replace('xyz = "0.01 0.02 0.03"', 'xyz = "0.01 0.02 0.07"')
    )  # fmt: skip
    assert new == expected


@pytest.mark.parametrize("name", shipped_robots())
def test_written_origins_read_back_exactly(name):
    robot = load_robot(name)
    generator = np.random.default_rng(3)
    origins = {
        joint.name: Origin(*map(tuple, generator.normal(size=(2, 3)).tolist()))
        for joint in robot.joints
    }
    assert scan(set_origins(robot.text, origins), "again").origins | origins == (
        scan(set_origins(robot.text, origins), "again").origins
    )


def test_relative_meshes_are_found_from_the_new_place(tmp_path):
    (tmp_path / "model/meshes").mkdir(parents=True)
    mesh = tmp_path / "model/meshes/arm link.stl"
    mesh.write_text("solid")
    absolute, package = "/somewhere/x.stl", "package://robot/y.stl"
    visuals = "".join(
        f'<visual><geometry><mesh scale="1 1 1" filename="{name}"/></geometry></visual>'
        for name in ("meshes/arm link.stl", absolute, package)
    )
    data = f'<robot name="m"><link name="a">{visuals}</link></robot>'.encode()
    new = relocate_meshes(scan(data, "m"), tmp_path / "model", tmp_path / "out/deep").decode()
    assert absolute in new and package in new
    name = new.split('filename="')[1].split('"')[0]
    assert (tmp_path / "out/deep" / name).resolve() == mesh


def test_tags_may_be_nested_deeply(tmp_path):
    depth = 5000
    data = (
        b'<robot name="m"><link name="a">' + b"<x>" * depth + b"</x>" * depth + b"</link></robot>"
    )
    assert relocate_meshes(scan(data, "m"), tmp_path, tmp_path / "out") == data


def test_a_ball_is_put_on_a_flange(odd):
    odd.write_text(ODD_ARM.replace("ball_link", "hand"))
    with pytest.raises(ModelError, match="as in --flange hand --ball X Y Z"):
        load_robot(str(odd))
    robot = load_robot(str(odd), flange="e", ball=(0.05, -0.02, 0.1), tip="sphere")
    assert robot.ball_joint.origin.xyz == (0.05, -0.02, 0.1)
    assert robot.joint_names == ("turn", "slide", "endless")
    with pytest.raises(ModelError, match="no link is called 'nowhere'"):
        load_robot(str(odd), flange="nowhere", ball=(0, 0, 0))


def test_a_link_behind_all_turns_and_before_fingers_is_named_for_a_ball(tmp_path):
    text = load_robot("gen3").text.data.decode().replace("ball_link", "tool0")
    finger = '<link name="finger"/><joint name="f" type="prismatic"><parent link="tool0"/>'
    finger += '<child link="finger"/><limit lower="0" upper="1"/></joint><link name="camera"/>'
    finger += (
        '<joint name="c" type="fixed"><parent link="base_link"/><child link="camera"/></joint>'
    )
    (tmp_path / "arm.urdf").write_text(text.replace("</robot>", f"{finger}</robot>"))
    with pytest.raises(ModelError, match="as in --flange tool0 --ball X Y Z"):
        load_robot(tmp_path / "arm.urdf")


@pytest.mark.timeout(30)  # without a ball, all links are compared
def test_a_chain_of_many_links_is_soon_refused(tmp_path):
    count = 16_000
    links = "".join(f'<link name="l{i}"/>' for i in range(count))
    joints = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/></joint>'
        for i in range(count - 1)
    )
    file = tmp_path / "long.urdf"
    file.write_text(f'<robot name="long">{links}{joints}</robot>')
    with pytest.raises(ModelError, match=f"as in --flange l{count - 1} --ball"):
        load_robot(file)


@pytest.mark.parametrize("ball", [3, "0 0 1", (0, 0), (0, 0, None), np.zeros((1, 3))])
def test_a_ball_that_is_no_point_is_told(ball):
    with pytest.raises(ModelError, match="give its centre as three finite numbers, x y z in m"):
        load_robot("panda", flange="panda_link8", ball=ball)


def test_a_path_with_a_zero_is_no_robot():
    with pytest.raises(ModelError, match="cannot be read, did you mean 'panda'"):
        load_robot("panda\0")


def test_an_axis_of_any_length_is_a_direction(odd):
    axis = load_robot(str(odd)).actuated[0].axis
    for factor in (1e-7, 1e200):
        x, y, z = factor * 1, factor * 2, factor * -0.5
        odd.write_text(ODD_ARM.replace("1 2 -0.5", f"{x} {y} {z}"))
        assert load_robot(str(odd)).actuated[0].axis == pytest.approx(axis, abs=1e-15)


@by_table("old", "new", "told")
def test_bad_models_get_one_line(odd, old, new, told):
    """The odd arm with something replaced, or another text in its place."""
    odd.write_text(ODD_ARM.replace(old, new, 1) if old else new)
    with pytest.raises(ModelError, match=told) as caught:
        load_robot(str(odd))
    assert "odd.urdf" in str(caught.value)


@by_table("head", "comment", "encoding")
def test_a_model_in_any_encoding_is_read_edited_and_written_in_utf8(odd, head, comment, encoding):
    text = ODD_ARM.replace("an odd arm", comment).partition("\n")[2]
    odd.write_bytes(f"{head}\n{text}".encode(encoding))
    robot = load_robot(str(odd))
    assert comment in robot.text.data.decode()
    odd.write_bytes(ODD_ARM.replace('"0.1 0 0.2"', '"0.1 0 0.25"').encode())
    changed = set_origins(robot.text, load_robot(str(odd)).text.origins)
    assert changed.decode() == robot.text.data.decode().replace('"0.1 0 0.2"', '"0.1 0.0 0.25"')
    odd.write_bytes(changed)
    yourdfpy.URDF.load(str(odd), load_meshes=False)
    assert load_robot(str(odd)).joint_names == ("turn", "slide", "endless")


def test_a_model_that_is_not_in_its_encoding_is_told_with_the_line(odd):
    odd.write_bytes(ODD_ARM.replace("an odd arm", "\n gepr\xfcft").encode("latin-1"))
    with pytest.raises(ModelError, match=r"odd.urdf:3: not in utf-8.*; save the file as UTF-8"):
        load_robot(str(odd))


def test_a_mass_of_zero_is_none_and_one_below_is_refused(odd):
    weighed = '<link name="finger"><inertial><mass value="{}"/></inertial></link>'
    odd.write_text(ODD_ARM.replace('<link name="finger"/>', weighed.format("0")))
    assert load_robot(str(odd)).masses_assumed
    odd.write_text(ODD_ARM.replace('<link name="finger"/>', weighed.format("-1e-9")))
    with pytest.raises(ModelError, match="write zero or more"):
        load_robot(str(odd))


def test_a_byte_of_another_encoding_is_told_with_its_line_after_a_declaration_of_two(odd):
    declaration = b'<?xml version="1.0"\n encoding="utf-8"?>\n'
    odd.write_bytes(declaration + b'<robot name="a">\n<link name="\xe9"/>\n</robot>')
    with pytest.raises(ModelError, match=r"odd.urdf:4: not in utf-8"):
        load_robot(str(odd))

"""Tables as other programs write them: the same joints come out, or one line says why not."""

import os
from pathlib import Path

import numpy as np
import pytest
from cases import by_table
from foreign_tables import BYTES, LOOKS, MORE, PARTS, UR, Q, beside, named, page, text_of, workbook
from project import ROOT

import mukca
from mukca.recorder import POSE_FORMS, match_joints, read_rows, seconds_of, unit_quaternion
from mukca.solver.identification.robot import matrix_rpy, rotation_matrices, rotation_vectors

BEGIN, END = "<!-- tables: by tests/foreign_tables.py -->\n", "<!-- end of tables -->\n"


def rows_in_holes(folder, content):
    (folder / "hole_0.csv").write_bytes(content)
    return mukca.read_placements(folder)[0].for_joints(UR).positions


def rows_of_file(folder, content):
    (folder / "joints.csv").write_bytes(content)
    return np.array(read_rows(folder / "joints.csv", UR).numbers)


@pytest.mark.parametrize("read", [rows_in_holes, rows_of_file])
@pytest.mark.parametrize("look", BYTES)
def test_one_arm_is_read_alike_whatever_wrote_it(tmp_path, look, read):
    assert np.abs(read(tmp_path, BYTES[look]) - Q).max() < 1e-12


def test_a_line_of_units_may_end_before_the_last_column(tmp_path):
    rows = [[*UR, ""], ["[deg]"] * len(UR), [*np.degrees(Q[0]), ""]]
    lines = [",".join(map(str, row)) for row in rows]
    positions = rows_in_holes(tmp_path, "\n".join(lines).encode())
    assert np.abs(positions - Q[0]).max() < 1e-12


ALONE = (
    "plain",
    "without a header",
    "row",
    "echo",
    "spreadsheet",
    "comments",
    "numpy",
    "trailing",
    "RTDE",
    "lists",
    "tuples",
    "title",
    "groups",
    "strokes",
    "blanks in names",
)
"""Looks whose lines have no place for another column."""


@pytest.mark.parametrize("look", [look for look in LOOKS if not any(map(look.count, ALONE))])
def test_measured_points_stand_beside_them(tmp_path, look):
    head, *lines = LOOKS[look].lstrip("\ufeff").splitlines()
    separator = next(mark for mark in (";", "\t", ",", "  ") if mark in head)
    point = "," if "decimal" in look else "."
    names = ["x_mm", "y [mm]", "z (mm)"] if separator != "  " else ["x_mm", "y_mm", "z_mm"]
    numbers = [f"{number}{point}5" for number in (100, -20, 3)]
    rows = [separator.join([line, *numbers]) for line in lines]
    (tmp_path / "points.csv").write_text("\n".join([separator.join([head, *names]), *rows]))
    placement = mukca.read_placements(tmp_path)[0].for_joints(UR)
    assert np.abs(placement.positions - Q).max() < 1e-12
    assert placement.samples[4].point == pytest.approx((0.1005, -0.0205, 0.0035))


@pytest.mark.parametrize(
    ("header", "said"),
    [
        (
            [f"{arm}_{n}" for arm in ("left", "right") for n in UR],
            "may be any of left_shoulder_pan_joint, right",
        ),
        ([*UR, UR[0]], "may be any of shoulder_pan_joint, shoulder_pan_joint"),
        ([f"{arm}_q{k}" for arm in "ab" for k in range(6)], "may be any of a_q0, b_q0"),
        (
            [f"{'left' if k < 3 else 'right'}_{n}" for k, n in enumerate(UR)],
            "no arm has all of them",
        ),
        (UR[:5], "missing: wrist_3_joint"),
        ([*UR[:5], "tool"], "missing: wrist_3_joint"),
        ([f"target_q_{k}" for k in range(6)], "no column holds the positions"),
        ([f"{n}_velocity" for n in UR], "no column holds the positions"),
        (
            [f"q{k}" for k in range(1, 8)],
            "7 joint positions.*6 actuated joints.*the header is q1,q2",
        ),
    ],
)
def test_where_nobody_can_tell_it_is_said(tmp_path, header, said):
    rows = np.random.default_rng(0).uniform(-1, 1, (4, len(header))).tolist()
    with pytest.raises(mukca.MukcaError, match=said) as caught:
        rows_in_holes(tmp_path, text_of(header, rows).encode())
    assert "hole_0.csv" in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(mukca.MukcaError, match=r"joints\.csv"):
        rows_of_file(tmp_path, text_of(header, rows).encode())


def test_what_is_taken_in_order_is_said(tmp_path):
    for look in ("q1", "0 to 5", "ur_rtde", "axes with a gripper"):
        (tmp_path / "hole_0.csv").write_text(LOOKS[look])
        remarks = " ".join(mukca.read_placements(tmp_path)[0].for_joints(UR).remarks)
        assert "hole_0.csv" in remarks and "taken in order" in remarks
        assert ("taken for names" in remarks) == (look == "0 to 5")
    (tmp_path / "q.csv").write_text(LOOKS["plain"])
    assert "the columns are taken in order" in read_rows(tmp_path / "q.csv", UR).notes[0]


@pytest.mark.parametrize("cell", ["abc", "", "nan", "1,5"])
def test_a_cell_that_is_needed_is_a_number(tmp_path, cell):
    header, first, second, *rest = named("{}").splitlines()
    spoilt = ",".join([f'"{cell}"', *second.split(",")[1:]])
    content = "\n".join([header, first, spoilt, *rest]).encode()
    for read, file in ((rows_in_holes, "hole_0"), (rows_of_file, "joints")):
        with pytest.raises(mukca.MukcaError, match=rf"{file}.csv:3: .*(elbow|column 1)"):
            read(tmp_path, content)


def test_lines_without_any_joint_are_left_out_and_said(tmp_path):
    lines = beside("gripper", [MORE] * 5).splitlines()
    content = "\n".join([*lines[:3], f"{MORE},,,,,,", *lines[3:]]).encode()
    assert np.array_equal(rows_in_holes(tmp_path, content), Q)
    remarks = mukca.read_placements(tmp_path)[0].for_joints(UR).remarks
    assert remarks == (f"{tmp_path / 'hole_0.csv'}: 1 lines without joint positions are left out",)
    assert np.array_equal(rows_of_file(tmp_path, content), Q)


@pytest.mark.parametrize("first", ["0,1,2,3,4,5", "1,2,3,4,5,6"])
def test_whole_numbers_above_whole_numbers_are_a_sample(tmp_path, first):
    content = f"{first}\n1,0,2,1,0,1\n".encode()
    assert rows_in_holes(tmp_path, content)[0].tolist() == list(map(float, first.split(",")))


def test_joints_called_by_numbers_are_found_by_them():
    names = tuple("123456")
    for header, order in (
        ("654321", [5, 4, 3, 2, 1, 0]),
        ([f"motor_{k}" for k in names], range(6)),
        ([f"q{k}" for k in range(6)], range(6)),
    ):
        match = match_joints(list(header), names)
        assert match is not None and list(match.order) == list(order)


POSES = {
    "quaternion": "x,y,z,qx,qy,qz,qw\n0.1,0.2,0.3,0,0,0.6,0.8\n",
    "millimetres": "qw,qz,qy,qx,z_mm,y [mm],x (mm),note\n0.8,0.6,0,0,300,200,100,a\n",
    "PoseStamped": "%time,field.pose.position.x,field.pose.position.y,field.pose.position.z,"
    "field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
    "field.pose.orientation.w\n5,0.1,0.2,0.3,0,0,0.6,0.8\n",
    "PlotJuggler": "__time,/pose/position/x,/pose/position/y,/pose/position/z,/pose/orientation/x,"
    "/pose/orientation/y,/pose/orientation/z,/pose/orientation/w\n5,0.1,0.2,0.3,0,0,0.6,0.8\n",
    "TUM": "# timestamp tx ty tz qx qy qz qw\n5.0 0.1 0.2 0.3 0 0 0.6 0.8\n",
    "no header": "0.1,0.2,0.3,0,0,0.6,0.8\n",
    "rotation vector": "x,y,z,rx,ry,rz [deg]\n0.1,0.2,0.3,0,0,73.73979529168804\n",
    "RTDE": "timestamp " + " ".join(f"actual_TCP_pose_{k}" for k in range(6)) + "\n"
    "17.0 0.1 0.2 0.3 0.0 0.0 1.2870022175866\n",
    "angles": "x,y,z,roll [deg],pitch [deg],yaw [deg]\n0.1,0.2,0.3,0,0,73.73979529168804\n",
    "commands beside": "target_x,target_y,target_z,x_actual,y_actual,z_actual,"
    "qx_actual,qy_actual,qz_actual,qw_actual\n"
    "9,9,9,0.1,0.2,0.3,0,0,0.6,0.8\n",
    "Soll and Ist": "X Soll,Y Soll,Z Soll,X Ist,Y Ist,Z Ist,QX Ist,QY Ist,QZ Ist,QW Ist\n"
    "9,9,9,0.1,0.2,0.3,0,0,0.6,0.8\n",
    "matrix": "x,y,z,r11,r12,r13,r21,r22,r23,r31,r32,r33\n"
    "0.1,0.2,0.3,0.28,-0.96,0,0.96,0.28,0,0,0,1\n",
}


@pytest.mark.parametrize("look", POSES)
def test_poses_are_read_alike(tmp_path, look):
    from mukca.recorder import unit_quaternion

    file = tmp_path / "poses.csv"
    file.write_text(POSES[look])
    rows = read_rows(file, (), POSE_FORMS)
    (x, y, z, *turn) = rows.numbers[0]
    assert (x, y, z) == pytest.approx((0.1, 0.2, 0.3))
    assert unit_quaternion(turn, rows.form[3:], "") == pytest.approx((0, 0, 0.6, 0.8))


def test_of_columns_with_one_number_the_first_counts():
    """Angles in radians, and the same ones in degrees."""
    match = match_joints(["q1", "q2", "q1", "q2"], ["pan", "lift"])
    assert match is not None and match.order == (0, 1)


@by_table("header")
def test_half_a_pose_is_none(tmp_path, header):
    file = tmp_path / "poses.csv"
    file.write_text(f"{header}\n{','.join('0' * len(header.split(',')))}\n")
    with pytest.raises(mukca.MukcaError, match=r"poses\.csv:?.*(needed: x,y,z|may be any of|unit)"):
        read_rows(file, (), POSE_FORMS)


@pytest.mark.parametrize("names", ["C,B,A", "W,P,R", "roll,pitch,yaw", "rx,ry,rz"])
def test_angles_have_the_meaning_of_their_maker(tmp_path, names):
    """KUKA's A is about z, Fanuc's W about x; a UR's vector is none of these."""
    header = ",".join(f"{name} [deg]" for name in (*names.split(","),))
    file = tmp_path / "poses.csv"
    file.write_text(f"X [mm],Y [mm],Z [mm],{header}\n400,0,300,10,20,30\n")
    rows = read_rows(file, (), POSE_FORMS)
    found = unit_quaternion(rows.numbers[0][3:], rows.form[3:], "")
    vector = [np.deg2rad([10, 20, 30])]
    expected = rotation_vectors(matrix_rpy(np.array(vector)))
    if names == "rx,ry,rz":
        expected = np.array(vector)
        assert rows.notes == (
            f"{file}: rx,ry,rz are taken as a rotation vector in degrees, as a UR's pendant has it",
        )
    else:
        assert not rows.notes
    assert rotation_vectors(rotation_matrices(np.array([found]))) == pytest.approx(expected)
    assert rows.numbers[0][:3] == pytest.approx((0.4, 0.0, 0.3))


def test_six_columns_without_a_header_are_no_pose(tmp_path):
    file = Path(tmp_path / "poses.csv")
    file.write_text("0.1,0.2,0.3,0,0,0\n")
    with pytest.raises(mukca.MukcaError, match="several kinds of pose"):
        read_rows(file, (), POSE_FORMS)


def test_times_are_seconds():
    start = seconds_of("2026-05-12T10:00:00Z")
    for text, later in (
        ("2026-05-12T10:00:00.123Z", 0.123),
        ("2026-05-12 12:00:01,5+02:00", 1.5),
        ("2026-05-12T10:00:00.123456789", 0.123456789),
    ):
        assert seconds_of(text) == pytest.approx(start + later, abs=1e-6)
    assert seconds_of("10:00:01") - seconds_of("10:00:00") == 1
    assert seconds_of("12.05.2026") is None and seconds_of("1.5") is None


def test_the_documentation_shows_what_is_read():
    """MUKCA_KEEP_PAGES=1 writes it anew."""
    file = ROOT / "docs" / "tables.md"
    before, _, others = file.read_text().partition(BEGIN)
    text = f"{before}{BEGIN}\n{page()}{END}{others.partition(END)[2]}"
    if os.environ.get("MUKCA_KEEP_PAGES"):
        file.write_text(text)
    assert file.read_text() == text


@pytest.mark.parametrize(
    "matrix", [np.ones((3, 3)), 1.1 * np.eye(3), np.diag([1, 1, -1]), 0 * Q[:3]]
)
def test_a_matrix_that_is_no_rotation_is_refused(matrix):
    from mukca.recorder import unit_quaternion

    turn = matrix.ravel()[:9].tolist()
    with pytest.raises(mukca.MukcaError, match=r"v.csv:2: r11 to r33 are no rotation"):
        unit_quaternion(turn, [f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)], "v.csv:2")


@pytest.mark.parametrize("names", ["S1 L1 U1 R1 B1 T1", "s l u r b t", "A B C t id time"])
def test_a_joint_may_be_called_like_a_time(tmp_path, names):
    """A robot's own names come before what a name usually means."""
    joints = names.split()
    rows = np.random.default_rng(1).uniform(-1, 1, (4, 9))
    header = ["stamp", *reversed(joints), "x", "y", "z"]
    cells = [[str(i), *row[5::-1], *row[6:]] for i, row in enumerate(rows)]
    (tmp_path / "points.csv").write_text(text_of(header, cells))
    placement = mukca.read_placements(tmp_path)[0].for_joints(joints)
    assert np.array_equal(placement.positions, rows[:, :6])
    forms = [("x", "y", "z")]
    assert np.array_equal(read_rows(tmp_path / "points.csv", joints, forms).numbers, rows)


BOMB = '<!DOCTYPE a [<!ENTITY b "c">]><workbook xmlns="{main}">&b;</workbook>'


def test_a_workbook_names_rows_as_a_spreadsheet_does(tmp_path):
    file = tmp_path / "joints.xlsx"
    file.write_bytes(workbook(named("{}").replace("\n", "\nx,0,0,0,0,0\n", 1)))
    with pytest.raises(mukca.MukcaError, match=r"joints\.xlsx:4: column 1 is 'x'"):
        read_rows(file, UR)
    file.write_bytes(
        workbook(named("{}"), **{"xl/worksheets/sheet2.xml": PARTS["xl/worksheets/sheet1.xml"]})
    )
    (note,) = read_rows(file, UR).notes
    assert "its largest sheet is read; Cell 3 is not" in note
    title = (
        '<worksheet xmlns="{main}"><row r="1"><c r="A1" t="str"><v>by Jan</v></c></row></worksheet>'
    )
    file.write_bytes(workbook(named("{}"), **{"xl/worksheets/sheet2.xml": title}))
    assert len(read_rows(file, UR).numbers) == 5


@pytest.mark.parametrize(
    "content",
    [
        workbook(named("{}"), **{"xl/workbook.xml": BOMB}),
        workbook(named("{}"), **{"xl/worksheets/sheet2.xml": "<a"}),
        workbook(named("{}"), **{"xl/sharedStrings.xml": "<a/>"}),
        workbook(named("{}"))[:900],
        workbook(named("{}")).replace(b"sheet1", b"sheet3"),
        b"PK\x03\x04",
    ],
)
def test_a_workbook_that_is_damaged_is_refused(tmp_path, content):
    file = tmp_path / "joints.xlsx"
    file.write_bytes(content)
    with pytest.raises(mukca.MukcaError, match=r"joints\.xlsx: a spreadsheet or archive.*as CSV"):
        read_rows(file, UR)


def test_a_message_that_was_torn_off_has_no_stamp(tmp_path):
    """Its line is left out, or refused; no more."""
    head, *lines = LOOKS["rostopic echo -p"].splitlines()
    (tmp_path / "joints.csv").write_text("\n".join([head, *lines[:3], "17"]))
    numbers = read_rows(tmp_path / "joints.csv", UR).numbers
    assert np.abs(np.array(numbers) - Q[:3]).max() < 1e-12

"""Tables as trackers, motion capture and laboratories export them: read, or by what is said."""

import re
import shlex

import numpy as np
import pytest
from foreign_tables import text_of

import mukca

RNG = np.random.default_rng(8)
UR10 = mukca.load_robot("ur10")
Q = RNG.uniform(-2, 2, (14, 6)).round(6)
XYZ = RNG.uniform(-0.9, 0.9, (14, 3)).round(6)
TURNS = RNG.normal(size=(14, 4))
TURNS /= np.linalg.norm(TURNS, axis=1)[:, None]
"""Quaternions, scalar last."""
x, y, z, w = TURNS.T
R = np.stack(
    [
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    ],
    axis=1,
)
DEGREES, MM = np.rad2deg(Q), 1e3 * XYZ
NUMBERS = np.c_[DEGREES, MM]
ROWS = [f"r{i}{j}" for i in "123" for j in "123"]


def table(joint, place, rows=NUMBERS, separator=",", point="."):
    header = [*(joint.format(k) for k in range(1, 7)), *(place.format(a) for a in "XYZ")]
    return text_of(header, [*rows], separator, point)


def qualisys(line, rows, names=""):
    facts = "NO_OF_FRAMES\t14\nNO_OF_CAMERAS\t8\nTIME_STAMP\t2024-01-02, 10:11:12\t8182.1\n"
    return f"{facts}{line}\n{names}" + text_of([], [*rows], "\t")


BY_COLUMNS = R.reshape(-1, 3, 3).transpose(0, 2, 1).reshape(-1, 9)
BODY = "tool X\ttool Y\ttool Z\tRoll\tPitch\tYaw\tResidual\t" + "\t".join(
    f"Rot[{k}]" for k in range(9)
)
OPTITRACK = """Format Version,1.23,Take Name,T,Capture Frame Rate,120.0,Length Units,Millimeters,A,B

,Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body
,Name,tool,tool,tool,tool,tool,tool,tool,tool
,ID,1,1,1,1,1,1,1,1
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,
"""
VICON = "Trajectories\n100\n,,tool:m1,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n"
SPATIAL_ANALYZER = (
    "// A file of SpatialAnalyzer\n// Collection, Group, Target, X (mm), Y (mm), Z (mm)\n"
)
HOMOGENEOUS = np.concatenate([R.reshape(-1, 3, 3), XYZ[:, :, None]], axis=2).reshape(-1, 12)
COUNTED = np.c_[range(14), np.arange(14) / 100]
POINTS = {
    "German": table("Achse {} [Grad]", "{}-Ist [mm]", separator=";", point=","),
    "German sentences, days": text_of(
        [
            "Tag",
            *(f"Gelenkwinkel {k} in Grad" for k in range(1, 7)),
            *(f"{a} in mm" for a in "XYZ"),
        ],
        [*np.c_[np.arange(14) // 5 + 1, NUMBERS]],
    ),
    "French": table("Axe {} (degrés)", "{} mesuré (mm)"),
    "Italian": table("Giunto {} [gradi]", "{} misurata [mm]"),
    "Spanish": table("Articulación {} (grados)", "{} medida (mm)"),
    "indices": table("θ₁ (°)".replace("₁", "{}"), "{}_m (mm)"),
    "a note among rows": table("A{} [deg]", "{} [mm]").replace("\n", "\n\npause,,,,,,,,\n", 5),
    "units of groups": "Messung\n,Winkel [°],,,,,,Ort [mm],,\nNr,1,2,3,4,5,6,X,Y,Z\n"
    + text_of([], [*np.c_[range(14), NUMBERS]]),
    "titles": "FARO\nDevice: S6;;;\nDate;2023-05-01\n\n"
    + table("J{} (deg)", "{} (mm)", separator=";"),
    "only numbers": text_of([], [*NUMBERS]),
    "numbered rows": text_of([], [*np.c_[range(1, 15), NUMBERS]], " "),
    "facts above": "run,3,,,,,,,\n" + table("J{} [deg]", "{} [mm]"),
    "notes of Matlab": "% degrees, mm\n" + text_of([], [*NUMBERS], "  "),
    "no units": table("J{}", "{}"),
    "a pendant's names without units": text_of([*"SLURBTXYZ"], [*NUMBERS]),
    "names of nobody": table("AX{}", "{}M"),
    "commanded": table("j{}_cmd", "{}"),
    "targets beside": text_of(
        [*(f"J{k}" for k in range(1, 7)), "X_nom", "Y_nom", "Z_nom", "X_meas", "Y_meas", "Z_meas"],
        [*np.c_[DEGREES, MM.round(), MM]],
    ),
}
PAIRS = {
    "SpatialAnalyzer": SPATIAL_ANALYZER
    + text_of([], [["A", "M", f"p{i}", *p] for i, p in enumerate(MM)]),
    "SpatialAnalyzer without names": text_of(
        [], [[f"A::M::p{i}", *p] for i, p in enumerate(MM)], " "
    ),
    "Qualisys, names of markers": qualisys("MARKER_NAMES\ttool", rows=MM),
    "Qualisys, times": qualisys("MARKER_NAMES\ttool", rows=np.c_[COUNTED, MM]),
    "Qualisys, names of columns": qualisys(
        "MARKER_NAMES\ttool", rows=MM, names="tool X\ttool Y\ttool Z\n"
    ),
    "Vicon": VICON + text_of([], [*np.c_[range(14), np.zeros(14), MM]]),
}
POSES = {
    "Qualisys, a body": qualisys(
        "BODY_NAMES\ttool", rows=np.c_[MM, TURNS, BY_COLUMNS], names=f"{BODY}\n"
    ),
    "OptiTrack": OPTITRACK + text_of([], [*np.c_[COUNTED, TURNS, MM, w]]),
    "homogeneous matrix": text_of([f"T{i}{j}" for i in "123" for j in "1234"], [*HOMOGENEOUS]),
    "homogeneous matrix from 0": text_of(
        [f"m{i}{j}" for i in "0123" for j in "0123"],
        [[*row, 0, 0, 0, 1] for row in HOMOGENEOUS],
    ),
    "normal, orientation, approach": text_of(
        [a + b for a in "noap" for b in "xyz"], [*np.c_[BY_COLUMNS, XYZ]]
    ),
    "homogeneous matrix without names": text_of([], [*HOMOGENEOUS]),
    "quaternion without names": text_of([], [*np.c_[XYZ, TURNS]]),
    "quaternion from 0": text_of(
        ["x", "y", "z", "q0", "q1", "q2", "q3"], [*np.c_[XYZ, TURNS[:, [3, 0, 1, 2]]]]
    ),
}


def read(path, columns=()):
    (placement,) = mukca.read_placements(path, columns=columns)
    return placement.for_joints(UR10.joint_names)


def is_read(placement, turns=False):
    samples = placement.samples
    assert np.abs(placement.positions - Q).max() < 1e-6
    assert np.abs(np.array([s.point for s in samples]) - XYZ).max() < 1e-6
    if turns:
        products = np.sum(TURNS * np.array([s.orientation for s in samples]), axis=1)
        assert np.abs(products).min() > 1 - 1e-6


def read_as_told(path, refused, turns=False):
    """By names, or by what is said where names do not tell."""
    try:
        placement = read(path)
        is_read(placement, turns)
        return placement
    except (mukca.MukcaError, AssertionError, ValueError, TypeError):
        said = refused("--columns", "check", str(path), "--robot", "ur10", "--flange", "tool0")
    words = re.search(r"--columns ((?: ?'[^']*')+)", said)[1]
    placement = read(path, shlex.split(words))
    is_read(placement, turns)
    return placement


@pytest.mark.parametrize("look", POINTS)
def test_points_of_an_export_are_read(tmp_path, refused, look):
    (tmp_path / "t.csv").write_text(POINTS[look])
    read_as_told(tmp_path / "t.csv", refused)


@pytest.mark.parametrize("look", {**PAIRS, **POSES})
def test_joints_and_an_export_are_read_together(tmp_path, refused, look):
    (tmp_path / "j.csv").write_text(text_of([f"J{k} [deg]" for k in range(1, 7)], [*DEGREES]))
    (tmp_path / "t.tsv").write_text((PAIRS | POSES)[look])
    path = f"{tmp_path}/j.csv+{tmp_path}/t.tsv"
    if look == "quaternion from 0":
        said = " ".join(read(path).remarks)
        assert "as a quaternion; it is read by --columns" in said
        words = re.search(r"--columns (.*)", said)[1].split(" --")[0]
        quoted = re.findall(r"'[^']*'", words)
        is_read(read(path, [word.strip("'") for word in quoted]), turns=True)
        return
    read_as_told(path, refused, look in POSES)


def test_what_a_user_names_is_taken_in_that_order_without_a_remark(tmp_path):
    (tmp_path / "t.csv").write_text(POINTS["no units"])
    words = ["q=J1..6 [deg]", "x=X [mm]", "y=Y [mm]", "z=Z [mm]"]
    placement = read(tmp_path / "t.csv", words)
    is_read(placement)
    assert not placement.remarks


@pytest.mark.parametrize("unit", ["[in]", "(inch)", "[km]"])
def test_a_unit_that_is_none_is_told(tmp_path, unit):
    (tmp_path / "t.csv").write_text(table("J{} [deg]", f"{{}} {unit}"))
    with pytest.raises(
        mukca.MukcaError, match=r"column X has unit '(in|inch|km)'; known are \[m\]"
    ):
        read(tmp_path / "t.csv")


BODY_OF_MARKERS = np.array([[0, 0, 0], [0.05, 0, 0], [0, 0.08, 0], [0.02, 0.01, 0.06]])
MARKERS = XYZ[:, None] + np.einsum("nij,kj->nki", R.reshape(-1, 3, 3), BODY_OF_MARKERS)


def test_named_markers_of_a_body_are_one(tmp_path):
    names = [f"hand:{name} {axis} [mm]" for name in "abcd" for axis in "XYZ"]
    rows = np.c_[DEGREES, 1e3 * MARKERS.reshape(14, -1)]
    (tmp_path / "t.csv").write_text(text_of([*(f"A{k} [deg]" for k in range(1, 7)), *names], rows))
    placement = read(tmp_path / "t.csv")
    assert "4 markers are taken as one rigid body" in " ".join(placement.remarks)
    points = np.array([s.point for s in placement.samples])
    assert np.abs(points - MARKERS.mean(axis=1)).max() < 1e-6


def test_joints_that_a_user_names_stand_beside_markers(tmp_path):
    names = [f"{axis}{k}" for k in range(1, 5) for axis in "xyz"]
    joints = ["turret", *(f"arm{k}" for k in range(1, 6))]
    rows = np.c_[MARKERS.reshape(14, -1), Q]
    (tmp_path / "t.csv").write_text(text_of([*names, *joints], rows))
    placement = read(tmp_path / "t.csv", ["q=turret,arm1..5 [rad]"])
    points = np.array([s.point for s in placement.samples])
    assert np.abs(points - MARKERS.mean(axis=1)).max() < 1e-6
    assert np.abs(placement.positions - Q).max() < 1e-6


def test_a_broken_row_is_no_title(tmp_path):
    """A line of numbers that lacks one is told, not left out."""
    lines = text_of([], [*NUMBERS]).splitlines()
    (tmp_path / "t.csv").write_text("\n".join([lines[0].rpartition(",")[0], *lines[1:]]))
    with pytest.raises(mukca.MukcaError, match=r"t\.csv:\d+: \d columns where \d are expected"):
        read(tmp_path / "t.csv")

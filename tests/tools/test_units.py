"""Units in headers: every reader of angles or lengths knows them, however they are written."""

import numpy as np
import pytest
from foreign_tables import UR

import mukca
from mukca.recorder import POSE_FORMS, read_rows, read_table_placement
from mukca.solver.tables import read_known, read_sockets_at
from mukca.tools.extract import Question, read_log

DEGREES = [
    "{} [deg]",
    "{} (deg)",
    "{}_deg",
    "{}[deg]",
    "{} deg",
    "{} [°]",
    "{} (degrees)",
    "{}_degrees",
]
LENGTHS = {
    **dict.fromkeys(["{} [mm]", "{} (mm)", "{}_mm", "{}[mm]", "{} mm", "{} [millimeters]"], 1e3),
    **dict.fromkeys(["{} [cm]", "{} (cm)", "{}_cm"], 1e2),
    **dict.fromkeys(["{} [m]", "{} (m)", "{}_m"], 1.0),
}
Q = np.random.default_rng(5).uniform(-1.5, 1.5, (12, 6)).round(6)
XYZ = np.random.default_rng(6).uniform(-0.5, 0.5, (12, 3)).round(6)
TURN = (0.1, -0.2, 0.3)
FLANGE = [f"flange_{name}" for name in ("x", "y", "z", "rx", "ry", "rz")]


class Columns:
    """Columns of a table, each in the unit that its header tells."""

    def __init__(self, angle, length):
        self.angle, self.length = angle, length

    def write(self, file, angles=(), q=None, lengths=(), points=None, others=()):
        """Write angles and lengths below their names, and other columns before them."""
        heads = [name for name, _ in others]
        heads += [self.angle.format(name) for name in angles]
        heads += [self.length.format(name) for name in lengths]
        columns = [np.array(values)[:, None].astype(object) for _, values in others]
        degrees = 1.0 if self.angle == "{}" else 180 / np.pi
        columns += [degrees * q] if len(angles) else []
        columns += [LENGTHS.get(self.length, 1.0) * points] if len(lengths) else []
        rows = np.hstack([c.astype(object) for c in columns]).tolist()
        lines = [",".join(heads), *(",".join(map(str, row)) for row in rows)]
        file.write_text("\n".join(lines) + "\n")
        return file


def socket_files(folder, columns):
    columns.write(folder / "hole_0.csv", UR, Q)
    return mukca.read_placements(folder)[0].for_joints(UR).positions, Q


def points(folder, columns):
    columns.write(folder / "points.csv", UR, Q, "xyz", XYZ)
    placement = mukca.read_placements(folder)[0].for_joints(UR)
    return np.c_[placement.positions, [s.point for s in placement.samples]], np.c_[Q, XYZ]


def poses(folder, columns):
    turns = ("roll", "pitch", "yaw")
    q = np.c_[Q, np.tile(TURN, (12, 1))]
    file = columns.write(folder / "poses.csv", (*UR, *turns), q, "xyz", XYZ)
    placement = read_table_placement(file).for_joints(UR)
    read = [(*s.position, *s.turn, *s.point) for s in placement.samples]
    return np.array(read), np.c_[q, XYZ]


def flange_poses(folder, columns):
    turns = np.tile(TURN, (12, 1))
    names = (*FLANGE[3:], "rx", "ry", "rz")
    q = np.c_[turns, turns]
    file = columns.write(folder / "views.csv", names, q, (*FLANGE[:3], *"xyz"), np.c_[XYZ, XYZ])
    placement = read_table_placement(file)
    order = [placement.joint_names.index(name) for name in FLANGE]
    read = [(*np.take(s.position, order), *s.point, *s.turn) for s in placement.samples]
    return np.array(read), np.c_[XYZ, turns, XYZ, turns]


def joint_rows(folder, columns):
    file = columns.write(folder / "joints.csv", UR, Q)
    return np.array(read_rows(file, UR).numbers), Q


def pose_rows(folder, columns):
    turns = np.tile(TURN, (12, 1))
    file = columns.write(folder / "poses.csv", ("rx", "ry", "rz"), turns, "xyz", XYZ)
    return np.array(read_rows(file, (), POSE_FORMS).numbers), np.c_[XYZ, turns]


def touches(folder, columns):
    file = columns.write(folder / "touches.csv", UR, Q, "xyz", XYZ)
    return np.array(read_rows(file, UR, [("x", "y", "z"), ("point",), ()]).numbers), np.c_[Q, XYZ]


def log(folder, columns):
    times = [("time", 0.05 * np.arange(12))]
    file = columns.write(folder / "log.csv", UR, Q, others=times)
    return read_log(Question(file, UR, (False,) * 6)).positions, Q


def log_of_slides(folder, columns):
    times = [("time", 0.05 * np.arange(12))]
    file = columns.write(folder / "log.csv", lengths=UR, points=Q, others=times)
    return read_log(Question(file, UR, (True,) * 6)).positions, Q


def sockets_at(folder, columns):
    names = [("socket", [f"front:{k}" for k in range(12)])]
    names += [("frame", ["table"] * 12)]
    lengths = np.c_[XYZ, np.full(12, 1e-4)]
    file = columns.write(
        folder / "at.csv", lengths=(*"xyz", "deviation"), points=lengths, others=names
    )
    return np.array([(*s.coordinates, s.deviation) for s in read_sockets_at(file)]), lengths


def known(folder, columns):
    ends = [("from", ["front:0"] * 12), ("to", [f"left:{k}" for k in range(12)])]
    lengths = np.abs(XYZ[:, :1]) + 0.1
    file = columns.write(folder / "k.csv", lengths=("distance",), points=lengths, others=ends)
    words = [str(word).partition("=")[2] for word in read_known([file])]
    return np.array([[float(word)] for word in words]), lengths


ANGULAR = [socket_files, points, poses, flange_poses, joint_rows, pose_rows, touches, log]
LINEAR = [points, poses, flange_poses, pose_rows, touches, sockets_at, known, log_of_slides]


@pytest.mark.parametrize("spelling", DEGREES)
@pytest.mark.parametrize("read", ANGULAR)
def test_degrees_are_read_as_their_header_says(tmp_path, read, spelling):
    numbers, expected = read(tmp_path, Columns(spelling, "{}"))
    assert np.abs(numbers - expected).max() < 1e-9


@pytest.mark.parametrize("spelling", LENGTHS)
@pytest.mark.parametrize("read", LINEAR)
def test_lengths_are_read_as_their_header_says(tmp_path, read, spelling):
    numbers, expected = read(tmp_path, Columns("{}", spelling))
    assert np.abs(numbers - expected).max() < 1e-9


def log_by_names(folder, columns):
    file = columns.write(folder / "log.csv", UR, Q, others=[("time", 0.05 * np.arange(12))])
    return read_log(Question(file, UR, (False,) * 6, named=",".join(UR))).positions, Q


@pytest.mark.parametrize("unit", ["rev", "in", "turns"])
@pytest.mark.parametrize("read", [socket_files, joint_rows, touches, log, log_by_names])
def test_joints_in_a_unit_that_is_not_known_are_refused(tmp_path, read, unit):
    with pytest.raises(mukca.MukcaError, match=rf":1: .*(deg.*\b{unit}\b|\b{unit}\b.*deg)"):
        read(tmp_path, Columns(f"{{}} [{unit}]", "{}"))

"""Coordinates of sockets that people write by hand."""

import numpy as np
import pytest
from altered import seats
from cases import by_table

import mukca
from mukca.solver.calibration import CalibrationProblem, SolveOptions, tables_of_sockets
from mukca.solver.identification.data import FrameError, SocketAt, measure
from mukca.solver.tables import in_placements, parse_socket_at, read_sockets_at

HEADER = "frame,socket,x [mm],y [mm],z [m],deviation [mm]"


def write(file, *lines):
    file.write_text("\n".join(lines) + "\n")
    return file


def test_units_stand_in_the_header_and_notes_behind_a_hash(tmp_path):
    file = write(
        tmp_path / "t.csv", "# by hand", HEADER, "", "table, front:1, 50, 0, 0.03, 0.05 # x"
    )
    (found,) = read_sockets_at([file])
    assert (found.frame, found.socket) == ("table", ("front", 1))
    assert found.coordinates == pytest.approx((0.05, 0, 0.03))
    assert found.deviation == pytest.approx(5e-5)
    assert found.where == f"{file}:4"


def test_words_read_back():
    found = parse_socket_at("left:base/session/front:0=0.1,-0.2,0.03+-5e-05")
    assert (found.frame, found.socket) == ("left:base", ("session/front", 0))
    assert str(found) == "left:base/session/front:0=0.1,-0.2,0.03+-5e-05"


@by_table("lines", "words")
def test_what_cannot_be_is_refused_by_line(tmp_path, lines, words):
    with pytest.raises(FrameError, match=words):
        read_sockets_at([write(tmp_path / "t.csv", *lines)])


def test_a_file_that_is_missing_or_no_text_is_named(tmp_path):
    with pytest.raises(FrameError, match=r"none\.csv: cannot be read: No such file"):
        read_sockets_at([tmp_path / "none.csv"])
    (tmp_path / "t.xlsx").write_bytes(b"PK\x03\x04\xff\xfe")
    with pytest.raises(
        FrameError, match=r"t\.xlsx: a spreadsheet or archive, not text; save it as CSV"
    ):
        read_sockets_at([tmp_path / "t.xlsx"])


def test_a_frame_that_two_files_name_is_refused(tmp_path):
    files = [write(tmp_path / f"{n}.csv", HEADER, f"table,{n}:0,0,0,0,1") for n in "ab"]
    with pytest.raises(FrameError, match=r"b.csv: frame 'table' is named twice, .*a.csv"):
        read_sockets_at(files)


def test_a_fit_is_told_of_what_it_is_trained_on_alone():
    found = [parse_socket_at(f"t/{name}:0=0,0,0+-1") for name in ("front", "left")]
    assert in_placements(found, ["s/front"], ["s/left"]) == found[:1]
    with pytest.raises(FrameError, match="no placement is called 'left'; there are: s/front"):
        in_placements(found, ["s/front"], [])


def as_given(points):
    return points


def exchanged(points):
    return points[:, ::-1]


def exchanged_at_one(points):
    return np.array([points[0], points[1, ::-1], points[2]])


def exchanged_bases(points):
    return points[[1, 0, 2]]


def mirrored(points):
    return points * [1, -1, 1]


@pytest.mark.parametrize(
    ("reading", "told"),
    [
        (as_given, ""),
        (exchanged, "its sockets 0 and 1 are exchanged"),
        (exchanged_at_one, "sockets 0 and 1 of placement_1 are exchanged in it"),
        (exchanged_bases, "placement_0 and placement_1 are exchanged in it"),
        (mirrored, "points the other way"),
    ],
)
def test_a_table_that_is_read_another_way_is_told(reading, told):
    """Wherever its frame lies, and by the nominal arm alone."""
    robot = mukca.load_robot("panda")
    truth, placements = mukca.simulate_recordings(robot, 3, seed=4, samples=6)
    points = reading(np.array([seats(truth, placement) for placement in placements]))
    table = (points + np.array([1.0, 2.0, 3.0]))[..., [1, 2, 0]]
    located = [
        SocketAt("table", (placement.name, k), tuple(table[i, k].tolist()), 5e-5, "table.csv")
        for i, placement in enumerate(placements)
        for k in (0, 1)
    ]
    options = SolveOptions(sockets_at=located).validated()
    recorded = [measure(placement, robot, 0.05) for placement in placements]
    problem = CalibrationProblem(robot, recorded, options.load, options=options)
    findings = tables_of_sockets(problem).checks
    assert [finding.code for finding in findings] == ["frame"] * bool(told)
    assert all(told in finding.text for finding in findings)

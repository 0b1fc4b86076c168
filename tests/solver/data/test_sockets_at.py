"""Coordinates of sockets that people write by hand."""

import pytest
from cases import by_table

from mukca.solver.identification.data import FrameError
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

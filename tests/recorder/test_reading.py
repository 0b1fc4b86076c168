"""Reading placements: what is read is what was written, and bad files are told in one line."""

import json
from pathlib import Path

import numpy as np
import pytest
from altered import write_samples
from cases import by_table
from hypothesis import given
from hypothesis import strategies as st
from recorded import write_sockets

import mukca
from mukca.recorder import read_sessions

NAMES = ("j1", "j2", "j3")
HEADER = (
    "event,sample,socket,time,stamp,states,"
    "position.a,position.b,spread.a,spread.b,effort.a,effort.b"
)
GOOD = "capture,1,0,1.0,2.0,300,0.1,0.2,1e-5,1e-5,,"
MORE = "capture,2,1,2.0,3.0,300,0.3,0.4,1e-5,2e-5,1.5,2.5"


def holes(folder, hole_0, hole_1="1,2,3\n4,5,6\n"):
    folder.mkdir(exist_ok=True)
    (folder / "hole_0.csv").write_text(hole_0)
    (folder / "hole_1.csv").write_text(hole_1)
    return folder


def recorded(folder, *lines):
    (folder / "samples.csv").write_text("\n".join(lines) + "\n")
    return folder


def read(folder):
    (placement,) = mukca.read_placements(folder)
    return placement


@pytest.mark.slow
@given(rows=st.lists(st.tuples(*[st.floats(-1e20, 1e20)] * 3), min_size=1, max_size=5))
def test_floats_read_back_exactly(rows, tmp_path_factory):
    text = "\n".join(",".join(map(repr, row)) for row in rows)
    samples = read(holes(tmp_path_factory.mktemp("exact"), text, text)).samples
    assert [sample.position for sample in samples] == [*rows, *rows]


def test_samples_keep_socket_and_line(tmp_path):
    placement = read(holes(tmp_path / "front", "1,2,3\n\n4,5,6\n"))
    assert placement.sockets.tolist() == [0, 0, 1, 1] and placement.positions.shape == (4, 3)
    files = [sample.where.split("front/")[1] for sample in placement.samples]
    assert files == ["hole_0.csv:1", "hole_0.csv:3", "hole_1.csv:1", "hole_1.csv:2"]
    assert placement.name.endswith("/front")
    assert placement.distance is None and placement.joint_names is None
    assert placement.efforts is None


def test_all_files_of_a_socket_are_read(tmp_path):
    (holes(tmp_path, "1,2,3\n") / "hole_01.csv").write_text("7,8,9\n")
    assert sorted(read(tmp_path).positions[:, 0].tolist()) == [1, 1, 4, 7]


def test_a_distance_that_is_said_to_be_measured_may_lack(tmp_path):
    (holes(tmp_path, "1,2,3\n") / "placement.json").write_text('{"distance_measured": true}')
    placement = read(tmp_path)
    assert placement.distance is None and placement.readings == ()


def test_sessions_in_a_folder_that_cannot_be_looked_into_are_none():
    assert read_sessions(Path("x" * 300) / "placement.json") == []


@by_table("first", "second")
def test_columns_go_by_known_names_or_by_order(tmp_path, first, second):
    ordered = read(holes(tmp_path, first, second)).for_joints(NAMES)
    assert ordered.positions.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_efforts_and_spreads_follow_the_chain_s_order_too(tmp_path):
    *_, sample = read(recorded(tmp_path, HEADER, GOOD, MORE)).for_joints(("b", "a")).samples
    assert sample.position == (0.4, 0.3)
    assert sample.effort == (2.5, 1.5) and sample.spread == (2e-5, 1e-5)


@by_table("text", "told")
def test_columns_that_fit_no_chain_are_told(tmp_path, text, told):
    with pytest.raises(mukca.MukcaError, match=told):
        read(holes(tmp_path, text, text)).for_joints(NAMES)


@by_table("text", "told")
def test_bad_files_are_told_with_file_and_line(tmp_path, text, told):
    with pytest.raises(mukca.MukcaError, match=told) as caught:
        read(holes(tmp_path, text))
    assert "hole_0.csv" in str(caught.value)


@by_table("text")
def test_files_of_others_are_read_as_they_meant_them(tmp_path, text):
    placement = read(holes(tmp_path, text, text)).for_joints(NAMES)
    assert placement.positions[0] == pytest.approx([1, 2, 3], abs=1e-12)


def test_a_placement_without_a_sample_is_skipped_beside_others(tmp_path):
    holes(tmp_path / "good", "1,2,3\n")
    (tmp_path / "good/hole_2.csv").write_text("a,b,c\n")
    empty = holes(tmp_path / "begun", "a,b,c\n", "a,b,c\n")
    (placement,) = mukca.read_placements(tmp_path)
    assert placement.sockets.max() == 1 and len(placement.remarks) == 2
    assert "hole_2.csv: only a header" in placement.remarks[0]
    assert "begun/hole_0.csv: only a header" in placement.remarks[1]
    with pytest.raises(mukca.MukcaError, match="only a header"):
        mukca.read_placements(empty)
    (tmp_path / "begun/hole_0.csv").write_text("1,2,x,y\n1,2\n")
    assert len(mukca.read_placements(tmp_path / "good", empty)) == 1  # named, and left out
    with pytest.raises(mukca.MukcaError, match="begun"):
        mukca.read_placements(tmp_path, as_recorded=True)


def test_points_need_no_header(tmp_path):
    (tmp_path / "points.csv").write_text("1,2,3,0.1,0.2,0.3\n")
    placement = read(tmp_path).for_joints(NAMES)
    assert placement.samples[0].position == (1, 2, 3)
    assert placement.samples[0].point == (0.1, 0.2, 0.3)


@pytest.mark.parametrize("name", ["hole_0.csv", "samples.csv"])
def test_a_binary_file_is_told(tmp_path, name):
    (tmp_path / name).write_bytes(b"\xff\xfe\x00\x01\n" * 50)
    with pytest.raises(mukca.MukcaError, match="not a text file"):
        read(tmp_path)


@by_table("text")
def test_other_separators_and_decimal_commas_are_read(tmp_path, text):
    (tmp_path / "hole_0.csv").write_bytes(text.encode())
    placement = read(tmp_path)
    assert placement.positions.tolist() == [[-1.5, 2, 0.3], [4, 5, 6]]
    assert placement.joint_names == (NAMES if "j1" in text else None)


@by_table("text")
def test_a_bad_placement_json_is_told(tmp_path, text):
    folder = holes(tmp_path, "1,2,3\n")
    (folder / "placement.json").write_text(text)
    with pytest.raises(mukca.MukcaError, match=r"placement\.json"):
        read(folder)


def test_a_placement_json_is_read_and_may_say_more(tmp_path):
    folder = holes(tmp_path, "1,2,3\n")
    text = '{"distance": 0.1, "place": "wall", "frame": null, "sessions": 3}'
    (folder / "placement.json").write_text(text)
    placement = read(folder)
    assert (placement.distance, placement.place, placement.frame) == (0.1, "wall", None)


def test_readings_of_a_placement_json_may_be_plain_numbers(tmp_path):
    folder = holes(tmp_path, "1,2,3\n")
    text = '{"distance": 0.05, "readings": [0.05, {"distance": 0.0501}]}'
    (folder / "placement.json").write_text(text)
    assert read(folder).readings == (0.05, 0.0501)
    (folder / "placement.json").write_text(text.replace("0.0501", '"0.2"'))
    with pytest.raises(mukca.MukcaError, match=r"placement.json: distance '0.2': expected a posi"):
        read(folder)


@pytest.mark.parametrize(
    ("key", "near"),
    [("distence", "distance"), ("Payload", "payload"), ("robotname", "robot_name"), ("notes", "")],
)
def test_a_key_that_is_nearly_one_is_told(tmp_path, key, near):
    folder = holes(tmp_path, "1,2,3\n")
    (folder / "placement.json").write_text(json.dumps({"distance": 0.1, key: 0.1}))
    told = f"placement.json: {key} is not read; did you mean {near}?"
    assert [told in remark for remark in read(folder).remarks] == [True] * bool(near)


def test_placements_are_read_by_path_or_by_the_folder_that_holds_them(tmp_path):
    for name in ("right", "left"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "hole_0.csv").write_text("1,2\n3,4\n")
        (tmp_path / name / "hole_1.csv").write_text("5,6\n")
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "monday.txt").write_text("The base stood firm.")
    both = mukca.read_placements(tmp_path)
    assert [placement.path for placement in both] == [tmp_path / "left", tmp_path / "right"]
    assert mukca.read_placements(str(tmp_path / "right"), tmp_path / "left") == both[::-1]
    assert repr(both[0]) == f"Placement('{tmp_path.name}/left': 2 + 1 samples, 2 joints)"
    assert repr(both[0].samples[2]) == "Sample(unnumbered, socket 1: 5.0000, 6.0000)"


def test_paths_without_a_placement_are_told_in_one_line(tmp_path):
    file = tmp_path / "file.csv"
    file.write_text("1,2,3")
    file.with_suffix(".md").write_text("1,2,3")
    (tmp_path / "empty").mkdir()
    for paths, told in (
        ((), "no placement is given"),
        (("nowhere",), "nowhere: no such folder"),
        ((file,), "file.csv: no header tells.*as in --columns 'q=1..3 .rad.'$"),
        ((file.with_suffix(".md"),), "file.md: not a folder, and no table"),
        ((tmp_path / "empty",), "no recording in this folder.* that hold them$"),
        ((tmp_path,), "no recording in this folder.*file.csv is not read.*name .*file.csv itself"),
        ((tmp_path / ("long" * 100),), "cannot be read: File name too long"),
    ):
        with pytest.raises(mukca.MukcaError, match=told):
            mukca.read_placements(*paths)


def test_a_column_that_counts_the_rows_is_suggested_as_no_joint(tmp_path):
    rows = [f"{i};0.{i};-1.{i};51{i}.5;52{i}.5;53{i}.5" for i in range(1, 5)]
    file = tmp_path / "t.csv"
    file.write_text("\n".join(["Punkt;A1;A2;X;Y;Z", *rows]))
    (placement,) = mukca.read_placements(file)
    assert placement.suggestion(2).startswith("--columns 'q=A1,A2 [rad]' 'x=X")


def test_sockets_are_numbered_0_to_999(tmp_path):
    (tmp_path / "hole_99999999999999999999.csv").write_text("1,2,3\n")
    with pytest.raises(mukca.MukcaError, match=r"hole_9+\.csv: sockets have numbers from 0 to 999"):
        mukca.read_placements(tmp_path)


@pytest.mark.parametrize("content", [b"PK\3\4...", b"\xd0\xcf\x11\xe0..."])
def test_a_spreadsheet_is_told_to_be_saved_as_text(tmp_path, content):
    (tmp_path / "hole_0.csv").write_bytes(content)
    with pytest.raises(mukca.MukcaError, match=r"a spreadsheet or archive.*save it as CSV"):
        mukca.read_placements(tmp_path)


@by_table("lines", "told")
def test_a_bad_line_of_a_recording_is_told_with_its_place(tmp_path, lines, told):
    with pytest.raises(mukca.MukcaError, match=told) as caught:
        read(recorded(tmp_path, *lines))
    assert "samples.csv" in str(caught.value)


def test_both_forms_in_one_folder_are_refused(tmp_path):
    recorded(holes(tmp_path, "1,2\n"), HEADER, GOOD)
    with pytest.raises(mukca.MukcaError, match="both"):
        read(tmp_path)


@pytest.mark.parametrize("write", [write_sockets, write_samples])
def test_columns_turn_a_sign_of_samples_in_folders(write, tmp_path):
    _, (recorded,) = mukca.simulate_recordings(mukca.load_robot("panda"), 1, samples=8)
    signs = np.where(np.arange(7) == 1, -1.0, 1.0)
    write(tmp_path / "flip", recorded.with_positions(recorded.positions * signs))
    (read,) = mukca.read_placements(tmp_path / "flip", columns=["q=1,-2,3..7"])
    np.testing.assert_array_equal(read.positions, recorded.positions)
    # a joint by its number in the file's order, wherever it stands
    (read,) = mukca.read_placements(tmp_path / "flip", columns=["q=7,1..6"])
    np.testing.assert_array_equal(
        read.for_joints(mukca.load_robot("panda").joint_names).positions[:, 0],
        recorded.positions[:, 6],
    )


@pytest.mark.parametrize("words", ["q=1..8", "q=1,2,2,4..7", "q=1..7 [deg]", "x=8", "q=elbow"])
def test_columns_that_samples_in_folders_lack_are_refused(words, tmp_path, refused):
    _, (recorded,) = mukca.simulate_recordings(mukca.load_robot("panda"), 1, samples=8)
    write_sockets(tmp_path / "rec", recorded)
    said = refused("--columns", "check", tmp_path / "rec", "--robot", "panda", "--columns", words)
    assert not {*"{}"} & {*said}

"""Reading placements: what is read is what was written, and bad files are told in one line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mukca.recorder import find_placements, read_placement, read_placements
from mukca.recorder.dataset import RecordingError, read_table

NAMES = ("j1", "j2", "j3")


def placement(folder: Path, hole_0: str, hole_1: str = "1,2,3\n4,5,6\n") -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "hole_0.csv").write_text(hole_0)
    (folder / "hole_1.csv").write_text(hole_1)
    return folder


@pytest.mark.slow
@given(
    rows=st.lists(
        st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), min_size=1, max_size=5
    )
)
def test_floats_read_back_exactly(rows: list[tuple[float, ...]], tmp_path_factory) -> None:
    file = tmp_path_factory.mktemp("exact") / "hole_0.csv"
    file.write_text("\n".join(",".join(map(repr, row)) for row in rows))
    assert read_table(file).rows == tuple(rows)


def test_samples_keep_socket_and_line(tmp_path: Path) -> None:
    read = read_placement(placement(tmp_path / "front", "1,2,3\n\n4,5,6\n"))
    assert read.sockets.tolist() == [0, 0, 1, 1]
    assert [s.where.split("front/")[1] for s in read.samples] == [
        "hole_0.csv:1",
        "hole_0.csv:3",
        "hole_1.csv:1",
        "hole_1.csv:2",
    ]
    assert read.name.endswith("/front")
    assert read.distance is None and read.joint_names is None


def test_windows_line_ends_and_byte_order_mark(tmp_path: Path) -> None:
    read = read_placement(placement(tmp_path, "\ufeff1,2,3\r\n4,5,6\r\n"))
    assert read.positions[0].tolist() == [1, 2, 3]


def test_columns_are_matched_by_header(tmp_path: Path) -> None:
    folder = placement(tmp_path, "j3,j1,x,j2\n3,1,9,2\n", "j3,j1,x,j2\n6,4,9,5\n")
    assert read_placement(folder).for_joints(NAMES).positions.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_columns_go_by_order_without_a_known_header(tmp_path: Path) -> None:
    folder = placement(tmp_path, "a,b,c\n1,2,3\n", "a,b,c\n4,5,6\n")
    assert read_placement(folder).for_joints(NAMES).positions.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_a_partial_header_is_refused(tmp_path: Path) -> None:
    folder = placement(tmp_path, "j1,j2,other\n1,2,3\n", "j1,j2,other\n1,2,3\n")
    with pytest.raises(RecordingError, match="missing: j3"):
        read_placement(folder).for_joints(NAMES)


def test_a_wrong_number_of_joints_is_refused(tmp_path: Path) -> None:
    folder = placement(tmp_path, "1,2\n", "1,2\n")
    with pytest.raises(RecordingError, match=r"hole_0\.csv:1: 2 joint positions.*3 actuated"):
        read_placement(folder).for_joints(NAMES)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "empty"),
        ("\n\n", "empty"),
        ("j1,j2,j3\n", "only a header"),
        ("1,2,3\n4,5\n", r":2: 2 columns where 3"),
        ("1,2,3\n4,x,6\n", r":2: column 2 is 'x', not a number"),
        ("1,2,3\n4,,6\n", r":2: column 2 is '', not a number"),
        ("1,2,3\n4,5,nan\n", r":2: column 3 is nan, not a finite number"),
        ("1,2,3\ninf,5,6\n", r":2: column 1 is inf, not a finite"),
        ("1,x,3\n4,5,6\n", r":1: column 2 is 'x', not a number"),
        ("1;2;3\n4,5,6\n", r"hole_0\.csv:2: 1 columns where 3.*separate them all by commas"),
        ("1|2|3\n4|5|6\n", r"hole_0\.csv:1: '1\|2\|3' is neither a number.*by commas"),
        ("[1, 2, 3]\n[4, 5, 6]\n", r":1: column 1 is '\[1', not a number.*by commas"),
        ("'1','2','3'\n'4','5','6'\n", r":1: \"'1'\" is neither a number nor the name"),
        ("1rad,2rad,3rad\n1,2,3\n", r":1: '1rad' is neither a number nor the name of a joint"),
    ],
)
def test_bad_files_are_told_with_file_and_line(tmp_path: Path, text: str, told: str) -> None:
    folder = placement(tmp_path, text)
    with pytest.raises(RecordingError, match=told) as caught:
        read_placement(folder)
    assert "hole_0.csv" in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "-1.5;2;3e-1\n4;5;6\n",
        "-1,5;2;3e-1\n4,0;5;6\n",
        "-1.5\t2\t0.3\n4\t5\t6\n",
        "-1.5 ,2 ,0.3\n4 ,5 ,6\n",
        "-1,5\t2,0\t,3\n4\t5\t6\n",
        "-1.500e+00 2.0e+00 3.0e-01\n4 5 6\n",
        "  -1,5  2,0  0,3\n4 5 6\n",
        "j1;j2;j3\r\n-1,5;2;0,3\r\n4;5;6\r\n",
    ],
)
def test_other_separators_and_decimal_commas_are_read(tmp_path: Path, text: str) -> None:
    (tmp_path / "hole_0.csv").write_bytes(text.encode())
    table = read_table(tmp_path / "hole_0.csv")
    assert table.rows == ((-1.5, 2, 0.3), (4, 5, 6))
    assert table.header == (NAMES if "j1" in text else None)


def test_decimal_commas_between_commas_are_told(tmp_path: Path) -> None:
    folder = placement(tmp_path, "1,5,2,5,3,5\n", "1,5,2,5,3,5\n")
    with pytest.raises(RecordingError, match="look like decimal commas: separate by semicolons"):
        read_placement(folder).for_joints(NAMES)


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    folder = placement(tmp_path, "1,2,3\n")
    (folder / "hole_0.csv").write_bytes(b"\xff\xfe\x00\x01" * 50)
    with pytest.raises(RecordingError, match="not a text file"):
        read_placement(folder)


@pytest.mark.parametrize(
    "text", ["[1]", "{", '{"distance": -1}', '{"distance": "5 cm"}', '{"distance": NaN}']
)
def test_a_bad_distance_is_told(tmp_path: Path, text: str) -> None:
    folder = placement(tmp_path, "1,2,3\n")
    (folder / "placement.json").write_text(text)
    with pytest.raises(RecordingError, match=r"placement\.json"):
        read_placement(folder)


def test_the_distance_is_read(tmp_path: Path) -> None:
    folder = placement(tmp_path, "1,2,3\n")
    (folder / "placement.json").write_text('{"distance": 0.1}')
    assert read_placement(folder).distance == 0.1


def test_a_folder_of_placements_stands_for_all(tmp_path: Path) -> None:
    for name in ("b", "a"):
        placement(tmp_path / name, "1,2,3\n")
    (tmp_path / "notes").mkdir()
    assert [path.name for path in find_placements([tmp_path])] == ["a", "b"]


@pytest.mark.parametrize("make", ["nothing", "file", "empty"])
def test_paths_without_a_placement_are_told(tmp_path: Path, make: str) -> None:
    path = tmp_path / "here"
    if make == "file":
        path.write_text("1,2,3")
    elif make == "empty":
        path.mkdir()
    with pytest.raises(RecordingError, match="here"):
        find_placements([path])


def test_efforts_are_all_or_none(tmp_path: Path) -> None:
    read = read_placement(placement(tmp_path, "1,2,3\n"))
    assert read.efforts is None
    assert np.shape(read.positions) == (3, 3)


def test_placements_are_read_by_path_or_by_the_folder_that_holds_them(tmp_path: Path) -> None:
    for name in ("left", "right"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "hole_0.csv").write_text("1,2\n3,4\n")
        (tmp_path / name / "hole_1.csv").write_text("5,6\n")
    both = read_placements(tmp_path)
    assert [placement.path for placement in both] == [tmp_path / "left", tmp_path / "right"]
    assert read_placements(str(tmp_path / "right"), tmp_path / "left") == both[::-1]
    assert repr(both[0]) == f"Placement('{tmp_path.name}/left': 2 + 1 samples, 2 joints)"
    assert repr(both[0].samples[2]) == "Sample(unnumbered, socket 1: 5.0000, 6.0000)"


def test_paths_without_a_placement_are_told_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no placement is given"):
        read_placements()
    with pytest.raises(RecordingError, match="/nowhere: no such folder"):
        read_placements("/nowhere")
    with pytest.raises(RecordingError, match="no recording in this folder"):
        read_placements(tmp_path)

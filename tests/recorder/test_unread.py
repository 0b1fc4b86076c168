"""What is not read in folders of placements is said, by each verb."""

import pytest
from altered import write_rows
from cases import by_table
from recorded import PLACES, recorded_at

from mukca import read_placements
from mukca.recorder import write_holes


@pytest.fixture(scope="module")
def rows(panda):
    return recorded_at(panda, PLACES["front"])


@pytest.fixture
def beside(rows, panda, tmp_path):
    """Write a file of samples beside a placement that is read, and return the folder of both."""

    def beside(name):
        write_holes(rows, tmp_path / "rec" / "front")
        positions = rows.positions[rows.sockets == 0].tolist()
        write_rows(tmp_path / "rec" / name, positions, panda.joint_names)
        return tmp_path / "rec"

    return beside


@by_table("name", "told")
@pytest.mark.parametrize("verb", ["check", "info"])
def test_a_file_by_another_name_is_told(beside, command, verb, name, told):
    words = ["--robot", "panda", "--distance", "0.05"] * (verb == "check")
    _, out, err = command(verb, beside(name), *words)
    assert "front" in out and err.count(told) == 1 and "Nothing wrong" not in out


def test_files_of_no_samples_are_none_of_these(beside, command):
    folder = beside("notes/readme.txt")
    (folder / "front" / "photo.jpg").touch()
    (folder / "front" / "times.csv").write_text("1,2\n")
    status, _, err = command("info", folder)
    assert (status, err) == (0, "")


def test_held_out_placements_hide_nothing(rows, beside, command):
    folder = beside("left/HOLE_0.CSV")
    write_holes(rows.with_positions(rows.positions + 1e-3), folder / "right")
    words = ["--test", folder / "right", "--robot", "panda", "--method", "paper"]
    _, out, err = command("solve", folder, *words)
    assert (out + err).count("left: HOLE_0.CSV is not read; call it hole_0.csv") == 1


@by_table("name", "told")
def test_a_folder_without_any_placement_names_what_is_there(tmp_path, refused, name, told):
    write_rows(tmp_path / name, [[0.1] * 7] * 2)
    refused(told, "info", tmp_path)


def test_files_of_sockets_keep_the_distance(rows, tmp_path):
    write_holes(rows, tmp_path / "front")
    (read,) = read_placements(tmp_path / "front")
    assert read.distance == rows.distance and not read.distance_assumed

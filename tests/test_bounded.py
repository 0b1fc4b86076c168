"""Files that never end, or are too large: refused before they are read, whoever reads them."""

import os

import pytest

import mukca
from mukca.errors import LARGEST_DOCUMENT, LARGEST_FILE
from mukca.recorder import read_table
from mukca.tools.extract import Question, read_log


def placement(file):
    """Read a recording whose first table is a link to the file."""
    folder = file.with_name("placement")
    folder.mkdir()
    (folder / "hole_0.csv").symlink_to(file)
    (folder / "hole_1.csv").write_text("1,2,3\n")
    return mukca.read_placements(folder)


def metadata(file):
    folder = file.with_name("placement")
    folder.mkdir()
    (folder / "hole_0.csv").write_text("1,2,3\n")
    (folder / "hole_1.csv").write_text("1,2,3\n")
    (folder / "placement.json").symlink_to(file)
    return mukca.read_placements(folder)


def log(file):
    link = file.with_suffix(".csv")
    link.symlink_to(file)
    return read_log(Question(link, ("j1",), (False,)))


READERS = [read_table, placement, metadata, mukca.load_robot, mukca.load_calibration, log]
KINDS = {
    "a pipe": os.mkfifo,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.symlink_to(path.parent),
}


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_file_is_refused_before_it_is_opened(tmp_path, kind, read):
    path = tmp_path / "endless"
    KINDS[kind](path)
    if kind == "a folder" and read is mukca.load_calibration:
        (path / "calibration.json").mkdir()
    with pytest.raises(mukca.MukcaError, match=f"is {kind}"):
        read(path)


@pytest.mark.parametrize("read", READERS)
def test_a_file_that_is_too_large_is_refused_with_both_sizes(tmp_path, read):
    path = tmp_path / "large"
    path.touch()
    document = read in (metadata, mukca.load_robot, mukca.load_calibration)
    largest = LARGEST_DOCUMENT if document else LARGEST_FILE
    os.truncate(path, 2 * largest)
    said = f"holds {2e-6 * largest:.1f} MB; at most {1e-6 * largest:.0f} MB are read"
    with pytest.raises(mukca.MukcaError, match=said):
        read(path)


@pytest.mark.parametrize("read", [metadata, mukca.load_calibration])
def test_a_document_that_is_nested_too_deeply_is_refused(tmp_path, read):
    path = tmp_path / "deep"
    path.write_text("[" * 200_000)
    with pytest.raises(mukca.MukcaError, match="nested too deeply"):
        read(path)


@pytest.mark.parametrize("end", ["\n", "\r"])
def test_a_line_that_is_too_long_is_refused_before_it_is_taken_apart(tmp_path, end):
    file = tmp_path / "hole_0.csv"
    file.write_text(end.join(["0.1,0.2", "9" * 1_500_000 + ",1", "0.1,0.2"]))
    with pytest.raises(mukca.MukcaError, match=r"hole_0.csv:2: a line of 1.5 MB; at most 1 MB"):
        read_table(file)
    file.rename(tmp_path / "samples.csv")
    with pytest.raises(mukca.MukcaError, match=r"samples.csv:2: a line of 1.5 MB"):
        mukca.read_placements(tmp_path)


def test_a_log_in_the_place_of_samples_is_told(tmp_path):
    (tmp_path / "hole_0.csv").write_text("0.1,0.2\n" * 100_101)
    with pytest.raises(mukca.MukcaError, match=r"100,101 lines; a line is a sample.*mukca extract"):
        mukca.read_placements(tmp_path)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_a_table_of_too_many_columns_is_refused_with_their_number(tmp_path, separator):
    file = tmp_path / "wide.csv"
    file.write_text(separator.join(["0.5"] * 10_001) + "\n")
    with pytest.raises(mukca.MukcaError, match=r"wide.csv:1: 10,001 columns; at most 10,000"):
        read_table(file)
    file.write_text(separator.join(["0.5"] * 10_000) + "\n")
    assert len(read_table(file).rows[0]) == 10_000


@pytest.mark.parametrize("word", ["x" * 1_000_000, "x y " * 250_000])
def test_a_message_shortens_what_it_quotes(tmp_path, word):
    error = str(mukca.MukcaError(f"a.csv:7: {word}: not a number"))
    assert error.startswith("a.csv:7: x") and error.endswith(": not a number")
    assert len(error) <= 4000

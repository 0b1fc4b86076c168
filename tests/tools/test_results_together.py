"""A set of results is one thing: no reader takes files of two calibrations for one."""

import json
import subprocess
import sys
from html import escape
from pathlib import Path
from xml.etree import ElementTree

import pytest
from msgspec.structs import replace
from stored import STORED

import mukca
from mukca.solver.calibration import Calibration, MultiRobotCalibration
from mukca.solver.results import ARMS_FORMAT, ArmsDocument, BaseToBase

SET = STORED / "1.0" / "calibrated"
WRITER = Path(__file__).parents[1] / "write_faults.py"
ARMS = ArmsDocument(
    format=ARMS_FORMAT,
    robots=("left", "right"),
    between={
        "left_to_right": BaseToBase(
            xyz=(1.0, 0.0, 0.0),
            rpy=(0.0, 0.0, 0.0),
            xyz_deviation=None,
            turn_deviation=None,
            tool_deviation=None,
            shared_sockets=4,
            text="",
        )
    },
    frames=(),
)
READERS = ("report", "validate", "export", "poses", "command")


def read(command, reader, folder, out):
    """Run a verb on a calibration; return its status, and all that it says."""
    placement = STORED / "1.0" / "front"
    pose = out.with_suffix(".csv")
    pose.write_text("x,y,z\n0.4,0,0.4\n")
    words = {
        "report": ["report", folder, "--out", out / "report"],
        "validate": ["validate", folder, placement],
        "export": ["export", folder, "--to", "urdf", "--out", out / "exported.urdf", "--force"],
        "poses": ["poses", folder, placement / "samples.csv"],
        "command": ["command", folder, pose],
    }
    status, said, error = command(*words[reader])
    return status, said + error


@pytest.fixture(scope="module", params=["1.0", "present"])
def faults(request, tmp_path_factory):
    """What each fault left of a set of results, and what the writer said; the sets' folder."""
    folder = tmp_path_factory.mktemp("faults")
    old = SET
    if request.param == "present":
        old = folder / "old"
        calibration = mukca.load_calibration(SET)
        calibration.save(old)
        mukca.write_report(calibration, old)
    words = [sys.executable, str(WRITER), str(old), str(folder)]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    rows = list(map(json.loads, done.stdout.splitlines()))
    assert {row["kind"] for row in rows if row["mixed"]} > {"kill", "EIO"}
    assert {row["status"] for row in rows} == {9, 2}
    return folder, rows


def test_whoever_reads_a_set_that_a_fault_mixed_says_which_file_is_another(
    faults, command, tmp_path
):
    folder, rows = faults
    for name, mixed in {row["folder"]: row["mixed"] for row in rows}.items():
        for reader in READERS:
            status, said = read(command, reader, folder / name, tmp_path / name)
            if mixed:
                assert status == 2 and "calibrated.urdf: not the one" in said, (reader, said)
                assert "USE IT" not in said and said.count("\n") == 1
            else:
                assert status != 2 and "not the one" not in said, (reader, said)


def test_a_fault_says_what_is_new_and_what_is_old(faults):
    _, rows = faults
    for row in rows:
        if row["kind"] == "kill":
            continue
        assert row["beside"] == [], row
        _, _, words = row["said"].partition("cannot be written: ")
        state, _, reason = words.rpartition("; reason: ")
        assert reason[0].isupper(), row
        if not row["new"]:
            assert state == "nothing was changed"
            continue
        new, _, before = state.removeprefix("new: ").partition("; as before: ")
        old = set(row["old"])
        written, kept = ({Path(f).name for f in files.split(", ")} for files in (new, before))
        assert written - old == set(row["new"])
        assert old - written <= kept - {"none"}  # a file of both may be alike in both


@pytest.fixture
def written(tmp_path):
    """A set of results of this version."""
    mukca.load_calibration(SET).save(tmp_path / "set")
    return tmp_path / "set"


def test_a_urdf_that_was_edited_is_told_by_all_readers(written, command, tmp_path):
    urdf = written / "calibrated.urdf"
    urdf.write_text(urdf.read_text().replace("</robot>", "<link name='x'/></robot>"))
    for reader in READERS:
        status, said = read(command, reader, written, tmp_path / "out")
        assert status == 2 and f"{urdf}: not the one that calibration.json" in said, reader
    with pytest.raises(mukca.MukcaError, match="not the one that calibration"):
        mukca.load_calibration(written)
    status, _, error = command("solve", STORED / "1.0" / "front", "--robot", "panda", "--prior",
                               written / "calibration.json")  # fmt: skip
    assert status == 2 and "not the one" in error


def test_a_calibration_alone_is_enough_and_the_report_tells_that_its_urdf_is_missing(
    written, command, tmp_path
):
    (written / "calibrated.urdf").unlink()
    for reader in READERS:
        status, said = read(command, reader, written, tmp_path / "out")
        assert status != 2, (reader, said)
        assert ("calibrated.urdf: missing" in said) == (reader == "report")


def test_what_was_found_later_is_written_with_its_page_at_once(written, command, tmp_path):
    """A page that cannot be written leaves no other file, either."""
    out = tmp_path / "out"
    (out / "report.html").mkdir(parents=True)
    words = (written, STORED / "1.0" / "left", "--out", out, "--force")
    status, _, error = command("rezero", *words)
    assert status == 2 and "report.html: is no file" in error
    assert [file.name for file in out.iterdir()] == ["report.html"]


def test_several_arms_are_one_set(tmp_path):
    single = mukca.load_calibration(SET)
    arms = MultiRobotCalibration({"left": single, "right": single}, ARMS)
    out = tmp_path / "out"
    arms.save(out)
    assert sorted(mukca.load_cell(out)) == ["left", "right"]
    with pytest.raises(mukca.MukcaError, match=r"several robots; mukca.load_cell .* left, right"):
        mukca.load_calibration(out)
    with pytest.raises(mukca.MukcaError, match=r"single robot; mukca\.load_cal"):
        mukca.load_cell(SET)
    settings = {**single.document.settings, "zeros": True}
    other = Calibration(replace(single.document, settings=settings))
    other.save(out / "right", force=True)
    assert mukca.load_calibration(out / "right").document.settings["zeros"]
    with pytest.raises(mukca.MukcaError, match=r"right/calibration.json: not the one that arms"):
        mukca.load_cell(out)


def test_a_notebook_shows_the_verdict_and_the_errors():
    single = mukca.load_calibration(SET)
    page = single._repr_html_()
    ElementTree.fromstring(f"<div>{page}</div>")
    assert escape(single.verdict.answer[0]) in page and single.errors[0].name in page


def test_a_base_stands_where_the_document_says_in_each_frame_that_there_is():
    single = mukca.load_calibration(SET)
    arms = MultiRobotCalibration({"left": single, "right": single}, ARMS)
    assert arms.base_in("right", "left")[:3, 3].tolist() == [1.0, 0.0, 0.0]
    with pytest.raises(mukca.MukcaError, match=r"'table': .*; there are: left, left/flange, right"):
        arms.base_in("right", "table")

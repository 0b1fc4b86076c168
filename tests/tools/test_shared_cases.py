"""Inputs on which the program was once wrong: each is named by file and line, with its cure.

The table has a folder, the words typed, the exit status, and what is said. Other tests write such
inputs by themselves; these come beside the project, and are skipped where they do not.
"""

import shlex

import pytest
from cases import by_table
from project import ROOT

pytestmark = pytest.mark.slow

CASES = ROOT.parent / "shared" / "cases"
HARDLY_SAID = {"calibrations", "foreign_controller_accepted"}
"""Folders of no command: what others use, and a script whose test is in test_command.py."""


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    return tmp_path_factory.mktemp("out")


def in_cases(folder):
    if not CASES.exists():
        pytest.skip(f"{CASES} is not there")
    return CASES / folder


@by_table("folder", "words", "status", "said")
def test_what_went_wrong_once_is_named_with_its_cure(
    command, out, monkeypatch, folder, words, status, said
):
    monkeypatch.setenv("COLUMNS", "200")  # tables are not folded then
    pytest.importorskip("rosbags", reason="the extra bags is not installed")
    pytest.importorskip("pyarrow", reason="the extra lerobot is not installed")
    places = {"HERE": in_cases(folder), "CAL": CASES / "calibrations", "OUT": out}
    for word, path in places.items():
        words = words.replace(word, shlex.quote(str(path)))
    found, shown, told = command(*shlex.split(words))
    assert found == status, told
    for sentence in said:
        assert (shown + told).count(sentence) >= 1, shown + told


def test_every_folder_has_a_row():
    folders = [readme.parent for readme in in_cases("").rglob("README.txt")]
    rows = test_what_went_wrong_once_is_named_with_its_cure.pytestmark[0].args[1]
    tested = {row[0] for row in rows} | HARDLY_SAID
    assert {str(folder.relative_to(CASES)) for folder in folders} == tested

"""What verbs say on one screen: 24 lines of 80 columns, the answer first."""

import re
from pathlib import Path

import pytest
from kept import NUMBER, compare

SCREENS = Path(__file__).with_name("screens")


def lines_of(text):
    """Lines as a terminal of 80 columns breaks them."""
    return [part for line in text.splitlines() for part in re.findall(r".{1,80}", line) or [""]]


@pytest.fixture
def screen(command):
    def screen(*words):
        status, out, err = command(*words)
        return status, out, lines_of(out + err)

    return screen


def test_a_calibration_of_real_recordings_is_one_screen(recordings, screen, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = recordings / "panda_3"
    words = ("solve", folder / "frontcenter", "--test", folder, "--robot", folder / "nominal.urdf")
    words = (*map(str, words), "--distance", "0.05", "--out", "calibrated")
    status, out, lines = screen(*words)
    assert status == 0 and len(lines) <= 24
    assert out.startswith("Distances in the workspace were wrong by ")
    assert out.splitlines()[1].startswith("USE IT: ")


@pytest.mark.slow
def test_an_answer_comes_first_on_one_screen(session, screen, tmp_path):
    """``MUKCA_KEEP_PAGES=1`` writes the screens anew; numbers are not compared."""
    front, left, right = (str(session / name) for name in ("front", "left", "right"))
    out = str(tmp_path / "calibrated")
    for verb, *words in (
        ("check", front, left, "--robot", "panda"),
        ("solve", front, "--test", left, "--robot", "panda", "--out", out),
        ("validate", out, right),
    ):
        _, said, lines = screen(verb, *words)
        assert len(lines) <= 24, said
        rows = [NUMBER.sub("#", line.replace(out, "OUT")) for line in said.splitlines()]
        compare(SCREENS / f"{verb}.txt", [re.sub(" +", " ", row).rstrip() for row in rows])

"""`mukca report` as a user meets it: what it writes, refuses, and prints."""

import json
import os
import re
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow


@pytest.fixture
def run(command):
    return partial(command, "report")


@pytest.fixture
def copy(calibrated, tmp_path):
    return Path(shutil.copytree(calibrated, tmp_path / "copy"))


def test_solve_writes_the_same_report(run, copy):
    before = (copy / "report.html").read_bytes()
    status, out, _ = run(str(copy / "calibration.json"))
    assert status == 0 and "up to date" in out
    assert (copy / "report.html").read_bytes() == before


def test_another_report_is_overwritten_only_by_force(run, copy):
    words = (str(copy / "calibration.json"), "--tolerance-mm", "1")
    before = (copy / "report.html").read_bytes()
    status, _, err = run(*words)
    assert status == 2 and "--force" in err and err.count("\n") == 1
    assert (copy / "report.html").read_bytes() == before
    status, out, _ = run(*words, "--force")
    assert status == 0 and "within 1 mm?" in out
    assert (copy / "report.html").read_bytes() != before


def test_json_is_the_report(run, copy):
    _, out, err = run(str(copy / "calibration.json"), "--json")
    assert json.loads(out) == json.loads((copy / "report.json").read_text())
    assert "Verdict" in err


@pytest.mark.skipif(sys.platform != "linux", reason="screens are told by the environment")
def test_open_shows_the_page_where_there_is_a_screen(copy, tmp_path):
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    browser.write_text(f'#!/bin/sh\nprintf %s "$1" >{seen}\n')
    browser.chmod(0o755)
    screens = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")
    bare = {name: value for name, value in os.environ.items() if name not in screens}
    words = [sys.executable, "-m", "mukca", "report", str(copy / "calibration.json"), "--open"]
    said = subprocess.run(words, env=bare, capture_output=True, text=True, check=False)
    assert f"copy {copy}/report.html" in said.stdout and not seen.exists()
    shown = subprocess.run(words, env={**bare, "BROWSER": f"{browser} %s"}, check=False)
    assert shown.returncode == said.returncode
    assert seen.read_text() == (copy / "report.html").as_uri()


def test_known_distances_come_from_a_file_too(run, copy, tmp_path):
    lines = tmp_path / "known.txt"
    lines.write_text("# measured with a caliper\nfront:0-left:0=0.43+-0.0001  # long one\n\n")
    run(str(copy / "calibration.json"), "--known", str(lines), "--force")
    (row,) = json.loads((copy / "report.json").read_text())["between"]
    assert row["distance"] == 0.43 and row["standard_deviation"] == 1e-4


def test_a_pipe_gets_text_and_a_terminal_curves(run, copy, monkeypatch):
    _, pipe, _ = run(str(copy / "calibration.json"))
    assert "\x1b" not in pipe and "▁" not in pipe
    for words in ("PASS", "front", "left", "Use:", "Next:", "Data:", "limit on"):
        assert words in pipe
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setenv("FORCE_COLOR", "1")
    _, terminal, _ = run(str(copy / "calibration.json"))
    assert re.search("[▁▂▃▄▅▆▇]+█", terminal) and "\x1b" in terminal

"""What the pages say, word for word: reports and a comparison."""

import shutil

import pytest
from altered import turned
from kept import says

from mukca.tools.cli import main

pytestmark = pytest.mark.slow


def test_the_report_of_the_papers_method(calibrated):
    says("paper", (calibrated / "report.html").read_text())


def test_the_report_of_the_default_method(auto):
    says("auto", (auto / "report.html").read_text())


def test_the_comparison(auto, calibrated, tmp_path):
    files = [str(folder / "calibration.json") for folder in (calibrated, auto)]
    assert main(["compare", *files, "--out", str(tmp_path / "out")]) == 0
    says("comparison", (tmp_path / "out/compare.html").read_text())


def test_the_report_of_two_arms(session, tmp_path):
    """The right arm is the left one, standing at the same sockets with its base turned."""
    for arm in ("left", "right"):
        for name in ("front", "left"):
            shutil.copytree(session / name, tmp_path / "arms" / arm / name)
    turned(tmp_path / "arms/right", 0, 0.3)
    folders = [f"{arm}:{tmp_path / 'arms' / arm}" for arm in ("left", "right")]
    robots = ["--robot", "left=panda", "--robot", "right=panda"]
    without = ["--without", "compliance", "tilt", "transmission", "joint-noise"]
    main(["solve", *folders, *robots, *without, "--out", str(tmp_path / "out")])
    says("arms", (tmp_path / "out/right/report.html").read_text())

"""Every benchmark and picture still finds what it needs; people look at what they make."""

import runpy
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPTS = sorted((ROOT / "benchmarks").glob("*.py"))
PICTURES = sorted((ROOT / "docs/images").glob("*.py"))


def test_there_are_some():
    assert len(SCRIPTS) >= 7


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_its_imports_and_options_hold(script, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [script.name, "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(script), run_name="__main__")
    assert ended.value.code == 0
    assert "usage" in capsys.readouterr().out


@pytest.mark.parametrize("script", PICTURES, ids=lambda script: script.stem)
def test_the_imports_of_a_picture_hold(script):
    assert "main" in runpy.run_path(str(script), run_name="picture")

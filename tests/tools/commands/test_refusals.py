"""What `mukca` refuses, each by one line: refusals.txt has the commands, and what is told."""

import shlex
from pathlib import Path

import pytest
from stored import STORED

LINES = Path(__file__).with_name("refusals.txt").read_text().splitlines()
COMMANDS = [line for line in LINES if line.startswith("mukca ")]
TOLD = [line.strip() for line in LINES if line.startswith("    ")]


@pytest.mark.slow
@pytest.mark.parametrize(("typed", "told"), [*zip(COMMANDS, TOLD, strict=True)])
def test_it_is_told_in_one_line_and_nothing_is_written(
    typed, told, refused, session, tmp_path, monkeypatch
):
    """In the folder of three recordings; OUT is not there, KEYS is a script of keys."""
    monkeypatch.chdir(session)
    keys = tmp_path / "keys"
    keys.write_text("a q")
    _, *words = shlex.split(typed)
    out = tmp_path / "out"
    folder = STORED / "1.0"
    calibrations = {"CALIBRATION": str(folder / "calibrated"), "CALIBRATIONS": str(folder)}
    stands_for = {"OUT": str(out), "KEYS": str(keys), **calibrations}
    error = refused(told, *(stands_for.get(word, word) for word in words))
    assert error.startswith("mukca") and not out.exists()

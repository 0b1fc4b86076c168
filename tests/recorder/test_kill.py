"""``kill -9`` at random moments during captures, twenty times."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow


def test_what_the_screen_counted_is_in_the_file(tmp_path):
    program = Path(__file__).with_name("killed_sessions.py")
    words = [sys.executable, str(program), str(tmp_path / "front"), "12"]
    environment = {**os.environ, "PYTHONPATH": str(program.parents[1])}
    done = subprocess.run(words, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "12 kills" in done.stdout

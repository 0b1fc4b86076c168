"""The program as a whole: how it ends at Ctrl-C, and at a defect of its own."""

import os
import re
import subprocess
import sys

import pytest

import mukca

PROGRAM = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
{0}
from mukca.__main__ import run
sys.argv[0] = "mukca"
sys.exit(run())
"""
DEFECT = """
import functools
from mukca.tools.cli.commands import robots
whole = robots.run_robots
@functools.wraps(whole)
def run_robots(options, terminal):
    return 1 / 0
robots.run_robots = run_robots
"""
INTERRUPTED = """
class Loading:
    def find_spec(self, name, path=None, target=None):
        if name == {0!r}:
            try:
                os.kill(os.getpid(), signal.SIGINT)
                signal.sigtimedwait([], 1.0)
            except KeyboardInterrupt as error:
                raise {1}
sys.meta_path.insert(0, Loading())
"""


def run_program(code, *words, **environment):
    command = [sys.executable, "-c", PROGRAM.format(code), *words]
    environment = {k: v for k, v in os.environ.items() if k != "MUKCA_TRACEBACK"} | environment
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_a_defect_is_one_line_and_a_report(tmp_path):
    done = run_program(DEFECT, "robots", "--json", TMPDIR=str(tmp_path))
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (70, "", 1)
    (report,) = tmp_path.iterdir()
    assert re.match(r"mukca robots: .*ZeroDivisionError.*ours to mend", done.stderr)
    assert str(report) in done.stderr
    text = report.read_text()
    for part in (
        f"mukca {mukca.__version__}",
        "mukca robots --json",
        "in run_robots",
        "division by",
    ):
        assert part in text
    nowhere = run_program(DEFECT + "import tempfile; tempfile.tempdir = '/proc/none'", "robots")
    assert (nowhere.returncode, nowhere.stderr.count("\n")) == (70, 1)
    assert "no report could be written" in nowhere.stderr


def test_whoever_mends_it_sees_the_traceback():
    done = run_program(DEFECT, "robots", MUKCA_TRACEBACK="1")
    assert done.returncode == 1 and "Traceback" in done.stderr


@pytest.mark.parametrize("module", ["argparse", "mukca.tools.cli.commands.check", "numpy"])
@pytest.mark.parametrize("error", ["", "ImportError('not loaded') from error"])
def test_an_interruption_while_modules_are_loaded_is_no_traceback(module, error):
    """Where a compiled module is interrupted, another error comes out of its import."""
    done = run_program(INTERRUPTED.format(module, error), "check", "nowhere", "--robot", "panda")
    assert done.returncode == 130 and done.stderr.count("\n") <= 1, done.stderr
    assert done.stderr in ("", "mukca check: interrupted\n")

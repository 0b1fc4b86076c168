"""`mukca stream` and `mukca emulate` as people and scripts use them."""

import io
import json
import os
import re
import shlex
import subprocess
from contextlib import contextmanager

import pyte
import pytest
from emulation import emulated
from emulator_programs import emulated_program
from terminal_session import MUKCA, TerminalSession

from mukca.tools.cli import main

pytestmark = pytest.mark.slow


@pytest.fixture
def stream(capsys):
    """Run the command in this process, and so in virtual time; return what it writes."""

    def run(*words):
        assert main(["stream", *words]) == 0
        return capsys.readouterr()

    return run


def test_json_is_one_object_a_state(tmp_path, stream):
    with emulated("franka", tmp_path) as emulation:
        driver = ("--driver", f"franka:{emulation.address}")
        lines = stream(*driver, "--json", "--count", "50").out.splitlines()
        emulation.stop()
        sent = emulation.sent()
    states = [json.loads(line) for line in lines]
    assert len(states) == 50
    for state in states:
        assert state["position"] == sent[round(state["stamp"] * 1000)]["position"]
        assert (state["missed"], state["rejected"], state["drops"]) == (0, 0, 0)
        assert state["status"] == "guiding"


def test_a_pipe_gets_a_line_a_second_and_a_last_one(tmp_path, stream):
    with emulated("ur", tmp_path, "--noise", "0", "--hold", "99") as emulation:
        out = stream("--driver", f"ur:{emulation.address}", "--seconds", "2.5").out
        emulation.stop()
        degrees = [57.29577951308232 * angle for angle in emulation.sent()[1]["position"]]
    lines = out.splitlines()
    assert len(lines) == 3
    for line in lines:
        assert [float(word) for word in line.split()[:6]] == pytest.approx(degrees, abs=1e-3)
        assert "500 Hz" in line and "missed 0" in line and "running, normal" in line
    assert "\x1b" not in out


class Glass(io.StringIO):
    """Passes for a terminal, and keeps what it showed each time that something was drawn."""

    def __init__(self, columns):
        super().__init__()
        self.screen = pyte.Screen(columns, 24)
        self.stream = pyte.Stream(self.screen)
        self.shown = []

    def isatty(self):
        return True

    def write(self, text):
        self.stream.feed(text.replace("\n", "\r\n"))
        self.shown.append("\n".join(line.rstrip() for line in self.screen.display))
        return len(text)


@pytest.fixture
def screens(monkeypatch):
    """Run the command with a terminal that it believes in; return all that it showed."""

    def run(*words, columns=80):
        glass = Glass(columns)
        monkeypatch.setattr("sys.stdout", glass)
        for name, value in (("TERM", "xterm"), ("COLUMNS", str(columns)), ("LINES", "24")):
            monkeypatch.setenv(name, value)
        assert main(["stream", *words]) == 0
        return glass.shown

    return run


def test_the_screen_shows_angles_rate_gaps_and_a_drop(tmp_path, screens):
    faults = ("--fault", "drop:0.1@0+2", "--fault", "hangup@3+1")
    with emulated("franka", tmp_path, *faults) as emulation:
        shown = screens("--driver", f"franka:{emulation.address}", "--seconds", "8")
    assert all(word in shown[20] for word in ("joint7", "deg", "N m", "Hz", "guiding"))
    lost = next(number for number, screen in enumerate(shown) if "drops 1" in screen)
    missed = re.search(r"missed (\d+)", shown[lost])
    assert missed and int(missed[1]) > 50
    assert any("closed" in screen for screen in shown[lost:])
    assert "Hz" in shown[-1] and "closed" not in shown[-1]


@pytest.mark.parametrize("columns", [80, 50])
def test_the_screen_tells_all_of_a_trouble(tmp_path, columns, screens):
    """However long it is, and that no state comes any more."""
    told = ("\n0 Hz", "no state", "Desk", "programming", "silent")
    with emulated("franka", tmp_path, "--fault", "silent@1") as emulation:
        driver = ("--driver", f"franka:{emulation.address}")
        shown = screens(*driver, "--seconds", "4", columns=columns)
    assert any(all(word in screen for word in told) for screen in shown), shown[-1]


def test_a_real_terminal_shows_the_screen_until_ctrl_c(tmp_path):
    """Two programs, in real time."""
    with emulated_program("franka", tmp_path) as emulation:
        command = [*MUKCA, "stream", "--driver", f"franka:{emulation.address}"]
        with TerminalSession(command) as terminal:
            terminal.wait_for("joint7", "deg", "N m", "Hz", "guiding")
            terminal.press("\x03")
            assert terminal.wait() == 130


def test_a_drop_is_told_on_standard_error(tmp_path, stream):
    with emulated("ur", tmp_path, "--fault", "hangup@1+0.5") as emulation:
        told = stream("--driver", f"ur:{emulation.address}", "--json", "--count", "900")
    assert json.loads(told.out.splitlines()[-1])["drops"] == 1
    assert "warning: the robot at" in told.err and "ended the connection" in told.err
    assert "warning: states come again" in told.err


@contextmanager
def piped(folder, *words):
    """Run a verb between pipes, with nothing set but where programs and packages are."""
    places = ("PATH", "PYTHONPATH")
    environment = {name: os.environ[name] for name in places if name in os.environ}
    environment["HOME"] = str(folder)
    pipes = dict.fromkeys(("stdin", "stdout"), subprocess.PIPE)
    with subprocess.Popen([*MUKCA, *words], env=environment, text=True, **pipes) as process:
        try:
            yield process
        finally:
            process.terminate()


def test_an_emulator_tells_how_to_read_it_and_whoever_does_gets_each_line_at_once(tmp_path):
    """Through pipes, of programs that go on."""
    with piped(tmp_path, "emulate", "kinova") as emulator:
        lines = [emulator.stdout.readline() for _ in range(3)]
        assert lines[0] == "Emulating kinova, version serial.\n"
        command = shlex.split(lines[1].partition("Read it with: mukca ")[2])
        for options in ([], ["--json"]):
            with piped(tmp_path, *command, *options) as stream:
                assert stream.stdout.readline().strip()
                assert stream.poll() is None
    assert emulator.returncode == 0

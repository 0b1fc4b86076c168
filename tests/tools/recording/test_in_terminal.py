"""The recorder in a real terminal: a session by keys, and every way in which it can end."""

import os
import signal
import termios
import time

import pytest
from plugins import lay_out
from record_commands import PANDA_HOME, assert_true, capture, command, configurations, fast
from terminal_session import PATIENCE, TerminalSession

import mukca

pytestmark = [pytest.mark.slow, pytest.mark.waits]


def test_a_whole_session_by_keys(hand, tmp_path):
    out = tmp_path / "data/front"
    with TerminalSession(command(hand, out)) as terminal:
        terminal.wait_for("SOCKET 0", "sockets 50 mm", "panda_joint7", "0:  0/30", "1:  0/30")
        capture(terminal, " ", "captured sample 1: 1 in socket 0", "0:  1/30")
        await_next_rest(terminal)
        captured = ("captured sample 2: 2 in socket 0", "0:  2/30")
        capture(terminal, "aa", *captured, "! refused: nearly the same configuration as sample 2")
        terminal.press("u")
        terminal.wait_for("took back sample 2 of socket 0", "0:  1/30")
        terminal.press("s")
        terminal.wait_for("SOCKET 1", "socket 1 is active")
        await_next_rest(terminal)
        capture(terminal, " ", "captured sample 3: 1 in socket 1", "1:  1/30")
        terminal.press("0")
        terminal.wait_for("SOCKET 0")
        terminal.press("7")
        terminal.wait_for("! there is no socket 7")
        terminal.press("?")
        terminal.wait_for("undo the last capture", gone=["panda_joint7"])
        terminal.press("?")
        terminal.wait_for("panda_joint7")
        terminal.press("m51\r")
        terminal.wait_for("the sockets are 51 mm apart, before 50", "sockets 51 mm")
        assert terminal.settings != terminal.before
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("in socket 1 (1 taken back)")
        assert terminal.settings == terminal.before
        assert b"\x1b[?1049l" in terminal.output and b"\x1b[?25h" in terminal.output
    assert (out / "samples.csv").read_text().count("\ncapture") == 3
    assert [(s.number, s.socket) for s in mukca.read_placements(out)[0].samples] == [(1, 0), (3, 1)]
    assert_true(mukca.read_placements(out)[0].positions, configurations(40), 300)


def await_next_rest(terminal):
    terminal.wait_for("MOVE")
    terminal.wait_for("PRESS: space captures")


def test_the_screen_is_readable_without_colour(hand, tmp_path):
    words = command(hand, tmp_path / "front")
    with TerminalSession(words, environment={"NO_COLOR": "1"}) as terminal:
        terminal.wait_for("SOCKET 0", "PRESS: space captures")
        terminal.press("q")
        assert terminal.wait() == 0
        colours = [f"\x1b[{code}m".encode() for code in (*range(30, 38), *range(40, 48))]
        assert not any(colour in terminal.output for colour in colours)
        assert b"\x1b[38;" not in terminal.output and b"\x1b[48;" not in terminal.output


def test_the_screen_follows_the_terminal_s_size(hand, tmp_path):
    stale = {"COLUMNS": "80", "LINES": "24"}  # as some shells export them
    with TerminalSession(command(hand, tmp_path / "front"), environment=stale) as terminal:
        for columns, rows in ((80, 24), (120, 40), (60, 16), (80, 24)):
            terminal.resize(columns, rows)
            deadline = time.monotonic() + PATIENCE
            shown = terminal.screen.display
            while not (
                any("SOCKET 0" in row for row in shown[:5]) and "space capture" in shown[rows - 1]
            ):
                assert time.monotonic() < deadline, terminal.text
                time.sleep(0.05)
                shown = terminal.screen.display
            assert max(len(line.rstrip()) for line in shown) > columns - 15
        terminal.resize(40, 12)
        terminal.wait_for("SOCKET 0", "The whole screen needs 60 x 14")


def test_a_recorder_that_was_stopped_has_its_terminal_again(hand, tmp_path):
    """As by ``kill -TSTP`` and ``fg``: the shell had the terminal meanwhile."""
    with TerminalSession(command(hand, tmp_path / "front")) as terminal:
        terminal.wait_for("SOCKET 0", "panda_joint7")
        mode = terminal.settings
        terminal.process.send_signal(signal.SIGSTOP)
        time.sleep(0.5)
        termios.tcsetattr(terminal.slave, termios.TCSANOW, terminal.before)
        os.write(terminal.slave, b"\x1b[?1049l\x1b[8;1Hsomething from the shell")
        terminal.wait_for("something from the shell")
        terminal.process.send_signal(signal.SIGCONT)
        terminal.wait_for("panda_joint7", gone=["something from the shell"])
        assert terminal.settings == mode
        terminal.press("q")
        assert terminal.wait() == 0
        assert terminal.settings == terminal.before


def test_it_is_said_aloud_by_what_the_system_has(hand, tmp_path):
    programs, said = tmp_path / "programs", tmp_path / "said"
    programs.mkdir()
    speaker = programs / "espeak-ng"
    speaker.write_text(f'#!/bin/sh\necho "$1" >> {said}\n')
    speaker.chmod(0o755)
    words = command(hand, tmp_path / "front", "--say")
    with TerminalSession(words, environment={"PATH": str(tmp_path)}) as terminal:
        terminal.wait_for("--say needs one of spd-say, espeak-ng, espeak, say")
        assert terminal.wait() == 2
    with TerminalSession(words, environment={"PATH": f"{programs}:/bin"}) as terminal:
        capture(terminal, " ", "captured sample 1")
        terminal.press("9")
        terminal.wait_for("there is no socket 9")
        terminal.press("q")
        assert terminal.wait() == 0
    assert "got 1" in said.read_text() and "there is no socket 9" in said.read_text()


@pytest.mark.parametrize(
    ("end", "status"),
    [("closed", 129), ("SIGHUP", 129), ("SIGTERM", 143), ("SIGQUIT", 131), ("Ctrl-C", 130)],
)
def test_every_end_saves_and_restores(hand, tmp_path, end, status):
    out = tmp_path / "front"
    with TerminalSession(command(hand, out), columns=160) as terminal:
        capture(terminal, "a", "captured sample 1")
        if end == "Ctrl-C":
            terminal.press("\x03")
        elif end == "closed":
            terminal.hang_up()
        else:
            terminal.process.send_signal(getattr(signal, end))
        assert terminal.wait() == status
        if end != "closed":
            terminal.wait_for("samples.csv: 1 in socket 0, 0 in socket 1")
            assert terminal.settings == terminal.before
            screen = terminal.output.rstrip()
            assert screen.rfind(b"\x1b[?1049l") > screen.rfind(b"SOCKET 0")
    assert len(mukca.read_placements(out)[0].samples) == 1


PLUGIN = """
import time
import mukca


class Arm(mukca.Driver):
    joint_names = [f"joint{i}" for i in range(7)]

    def __init__(self, *arguments):
        pass

    def read(self, timeout):
        time.sleep(timeout)
        return mukca.JointState(1.0, ("unexpected",) * 7)

    def close(self):
        pass


class Slow(Arm):
    def __init__(self, *arguments):
        try:
            time.sleep(3600)
        except KeyboardInterrupt:
            time.sleep(3600)
"""


@pytest.fixture
def plugged(tmp_path):
    """An environment with somebody's drivers."""
    lay_out(tmp_path, "plugin-arm", PLUGIN, {"arm": "Arm", "slow": "Slow"})
    return {"PYTHONPATH": f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}


def test_an_unexpected_error_restores_the_terminal(hand, tmp_path, plugged):
    words = command(hand, tmp_path / "front", "--driver", "arm")
    with TerminalSession(words, environment=plugged) as terminal:
        assert terminal.wait() == 1
        terminal.wait_for("TypeError")
        assert terminal.settings == terminal.before
        assert b"\x1b[?1049l" in terminal.output


def test_a_full_disk_refuses_and_leaves_a_valid_file(hand, tmp_path, scripted):
    out = tmp_path / "front"
    words = [*fast(hand, out), "--distance", "0.05"]
    keys = tmp_path / "keys.txt"
    keys.write_text("a*14 q")
    words += ["--keys", str(keys)]
    with TerminalSession(words, columns=120, limit_file_size=4096) as terminal:
        terminal.wait_for("refused", "samples.csv cannot be written to: File too large")
        assert terminal.wait() == 1
        counted = int(terminal.text.split("samples.csv: ")[-1].split(" in socket 0")[0])
    assert 3 < counted < 14
    assert len(mukca.read_placements(out)[0].samples) == counted
    assert (out / "samples.csv").stat().st_size <= 4096
    more = scripted(out, "a q")
    assert more.status == 0, more.errors
    assert len(mukca.read_placements(out)[0].samples) == counted + 1


def test_a_disk_that_is_full_of_states_is_told_at_once(hand, tmp_path):
    out = tmp_path / "front"
    words = command(hand, out, "--keep-stream", mock="&rate=1000")
    with TerminalSession(words, columns=120, limit_file_size=8192) as terminal:
        terminal.wait_for("! states_1.stream: no more states are kept: File too large")
        capture(terminal, "a", "captured sample 1")
        terminal.press("q")
        assert terminal.wait() == 0


@pytest.mark.parametrize("busy", ["loading ...", "connecting to slow"])
def test_ctrl_c_ends_the_program_while_it_loads(hand, tmp_path, plugged, busy):
    """Even where a driver swallows the exception, or a library never comes."""
    if busy == "loading ...":
        (tmp_path / "casadi.py").write_text("import time; time.sleep(60)")
    words = command(hand, tmp_path / "front", "--driver", "slow")
    with TerminalSession(words, environment=plugged) as terminal:
        terminal.wait_for(busy)
        time.sleep(0.5)
        terminal.press("\x03")
        assert terminal.wait() == 130
        terminal.wait_for("interrupted")


def test_a_simple_terminal_shows_what_to_do(tmp_path):
    still = tmp_path / "hand.csv"
    still.write_text(",".join(map(repr, PANDA_HOME)))
    words = command(still, tmp_path / "front")
    with TerminalSession(words, environment={"TERM": "dumb"}) as terminal:
        terminal.wait_for("PRESS: space captures sample 1")
        terminal.press(" ")
        terminal.wait_for("captured sample 1", "NEXT POSE")
        terminal.press("q")
        assert terminal.wait() == 0
        assert b"\x1b" not in terminal.output and b"\a" in terminal.output


def test_a_folders_name_steers_no_terminal(hand, tmp_path):
    out = tmp_path / "front\x1b]0;mine\x07\x1b]52;c;ZWNobw==\x07\u009b2J"
    with TerminalSession(command(hand, out), columns=200) as terminal:
        terminal.wait_for("SOCKET 0", "front?]0;mine")
        terminal.press("q")
        assert terminal.wait() == 0
        assert b"\x1b[" in terminal.output
        for sequence in (b"\x1b]", b"\xc2\x9b"):
            assert sequence not in terminal.output

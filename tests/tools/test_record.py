"""The recorder in a real terminal: a session by keys, and every way in which it can end."""

import json
import math
import os
import random
import shlex
import signal
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from terminal_session import MUKCA, TerminalSession
from virtual_time import VirtualTime

from mukca.recorder.dataset import Placement, read_placement
from mukca.recorder.samples import read_samples
from mukca.solver.robot.urdf import shipped_robots
from mukca.tools.cli import main

PANDA_HOME = (0.0, -0.3, 0.0, -2.0, 0.0, 1.8, 0.7)


def configurations(count: int, seed: int = 0) -> list[list[float]]:
    """Configurations of a Panda, within its limits and well apart."""
    generator = random.Random(seed)
    return [[q + generator.uniform(-0.6, 0.6) for q in PANDA_HOME] for _ in range(count)]


@pytest.fixture
def hand(tmp_path: Path) -> Path:
    """Where a hand leads the arm: 40 configurations."""
    file = tmp_path / "hand.csv"
    file.write_text("\n".join(",".join(map(repr, q)) for q in configurations(40)))
    return file


def command(hand: Path, out: Path, *more: str, mock: str = "") -> list[str]:
    driver = f"mock:{hand}?rate=1000&hold=2.5&move=0.7{mock}"
    return [*MUKCA, "record", "--robot", "panda", "--driver", driver, "--out", str(out), *more]


@dataclass
class Done:
    """What a command came to."""

    status: int
    output: str
    errors: str


@pytest.fixture
def scripted(
    hand: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], virtual_time: VirtualTime
):
    """Run a session by a key script, in virtual time."""

    def run(out: Path, keys: str, *more: str, hand: Path = hand) -> Done:
        script = tmp_path / "keys.txt"
        script.write_text(keys)
        words = [*fast(hand, out), "--keys", str(script), *more]
        status = main(words[len(MUKCA) :])
        read = capsys.readouterr()
        return Done(status, read.out, read.err)

    return run


def fast(hand: Path, out: Path) -> list[str]:
    driver = f"mock:{hand}?rate=250&speed=8&hold=0.65&move=0.6"
    return [*MUKCA, "record", "--robot", "panda", "--driver", driver, "--out", str(out)]


@pytest.mark.slow
@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (200, 50)])
def test_a_whole_session_by_keys(hand: Path, tmp_path: Path, columns: int, rows: int) -> None:
    out = tmp_path / "data/front"
    with TerminalSession(command(hand, out), columns=columns, rows=rows) as terminal:
        terminal.wait_for("SOCKET 0", "sockets 50 mm", "panda_joint7", "0:  0/30", "1:  0/30")
        capture(terminal, " ", "captured sample 1: 1 in socket 0", "0:  1/30")
        await_next_rest(terminal)
        capture(terminal, "a", "captured sample 2: 2 in socket 0", "0:  2/30")
        terminal.press("a")
        terminal.wait_for("! refused: nearly the same configuration as sample 2")
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
        assert terminal.settings != terminal.before
        terminal.press("q")
        assert terminal.wait() == 0
        terminal.wait_for("1 in socket 0, 1 in socket 1 (1 taken back)")
        assert terminal.settings == terminal.before
        assert b"\x1b[?1049l" in terminal.output and b"\x1b[?25h" in terminal.output
    taken = read_samples(out / "samples.csv").samples
    assert [sample.socket for sample in taken] == [0, 0, 1]
    assert_true(np.array([sample.position for sample in taken]), configurations(40), 300)
    assert [s.number for s in read_placement(out).samples] == [1, 3]


def capture(terminal: TerminalSession, key: str, *shown: str) -> None:
    """Press a key once the arm has been still for longer than a window."""
    terminal.wait_for("PRESS: space captures")
    time.sleep(0.5)
    terminal.press(key)
    terminal.wait_for(*shown)


def await_next_rest(terminal: TerminalSession) -> None:
    terminal.wait_for("MOVE")
    terminal.wait_for("PRESS: space captures")


def assert_true(positions: np.ndarray, truth: list[list[float]], states: int) -> None:
    """Each position is one of the true ones, within six deviations of the averaged noise."""
    away = np.abs(positions[:, None, :] - np.array(truth)[None]).max(axis=2).min(axis=1)
    assert np.all(away < 6 * 2e-5 / math.sqrt(states))


def test_the_screen_is_readable_without_colour(hand: Path, tmp_path: Path) -> None:
    words = command(hand, tmp_path / "front")
    with TerminalSession(words, environment={"NO_COLOR": "1"}) as terminal:
        terminal.wait_for("SOCKET 0", "PRESS: space captures")
        terminal.press("q")
        assert terminal.wait() == 0
        colours = [f"\x1b[{code}m".encode() for code in (*range(30, 38), *range(40, 48))]
        assert not any(colour in terminal.output for colour in colours)
        assert b"\x1b[38;" not in terminal.output and b"\x1b[48;" not in terminal.output


@pytest.mark.slow
def test_the_screen_follows_the_terminal_s_size(hand: Path, tmp_path: Path) -> None:
    stale = {"COLUMNS": "80", "LINES": "24"}  # as some shells export them
    with TerminalSession(command(hand, tmp_path / "front"), environment=stale) as terminal:
        for columns, rows in ((80, 24), (120, 40), (60, 16), (80, 24)):
            terminal.resize(columns, rows)
            deadline = time.monotonic() + 20
            shown = terminal.screen.display
            while not (
                any("SOCKET 0" in row for row in shown[:5]) and "space capture" in shown[rows - 1]
            ):
                assert time.monotonic() < deadline, terminal.text
                time.sleep(0.05)
                shown = terminal.screen.display
            assert max(len(line.rstrip()) for line in shown) > columns - 15
        terminal.resize(20, 5)
        terminal.wait_for("needs 60 x 14")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("end", "status"), [("SIGHUP", 129), ("SIGTERM", 143), ("SIGQUIT", 131), ("Ctrl-C", 130)]
)
def test_every_end_saves_and_restores(hand: Path, tmp_path: Path, end: str, status: int) -> None:
    out = tmp_path / "front"
    with TerminalSession(command(hand, out)) as terminal:
        capture(terminal, "a", "captured sample 1")
        if end == "Ctrl-C":
            terminal.press("\x03")
        else:
            terminal.process.send_signal(getattr(signal, end))
        assert terminal.wait() == status
        terminal.wait_for("samples.csv: 1 in socket 0, 0 in socket 1")
        assert terminal.settings == terminal.before
        assert terminal.output.rstrip().rfind(b"\x1b[?1049l") > terminal.output.rfind(b"SOCKET 0")
    assert len(read_placement(out).samples) == 1


@pytest.mark.slow
def test_a_closed_terminal_ends_the_session(hand: Path, tmp_path: Path) -> None:
    out = tmp_path / "front"
    with TerminalSession(command(hand, out)) as terminal:
        capture(terminal, "a", "captured sample 1")
        terminal.hang_up()
        assert terminal.wait() == 129
    assert len(read_placement(out).samples) == 1


def test_an_unexpected_error_restores_the_terminal(hand: Path, tmp_path: Path) -> None:
    broken = (
        "import sys, mukca.recorder.record as r\n"
        "def fail(self): raise RuntimeError('unexpected')\n"
        "r.Recorder._draw = fail\n"
        "from mukca.tools.cli import main\n"
        "sys.exit(main())\n"
    )
    words = [MUKCA[0], "-c", broken, *command(hand, tmp_path / "front")[len(MUKCA) :]]
    with TerminalSession(words) as terminal:
        assert terminal.wait() == 1
        terminal.wait_for("unexpected")
        assert terminal.settings == terminal.before
        assert b"\x1b[?1049l" in terminal.output


@pytest.mark.slow
def test_a_lost_stream_is_told_and_comes_back(hand: Path, tmp_path: Path) -> None:
    out = tmp_path / "front"
    with TerminalSession(command(hand, out, mock="&fault=drop@3+3")) as terminal:
        terminal.wait_for("PRESS: space captures")
        terminal.wait_for("! the stream is silent: the simulated arm", "WAIT")
        terminal.press("a")
        terminal.wait_for("! refused: the stream is silent")
        terminal.wait_for("the stream is back after", "connection lost 1x")
        capture(terminal, "a", "captured sample 1")
        terminal.press("q")
        assert terminal.wait() == 0
    assert len(read_placement(out).samples) == 1


@pytest.mark.slow
def test_a_full_disk_refuses_and_leaves_a_valid_file(hand: Path, tmp_path: Path, scripted) -> None:
    out = tmp_path / "front"
    words = fast(hand, out)
    keys = tmp_path / "keys.txt"
    keys.write_text("a*14 q")
    words += ["--keys", str(keys)]
    with TerminalSession(words, columns=120, limit_file_size=4096) as terminal:
        terminal.wait_for("refused", "samples.csv cannot be written to: File too large")
        assert terminal.wait() == 1
        counted = int(terminal.text.split("samples.csv: ")[-1].split(" in socket 0")[0])
    assert 3 < counted < 14
    assert len(read_placement(out).samples) == counted
    assert (out / "samples.csv").stat().st_size <= 4096
    more = scripted(out, "a q")
    assert more.status == 0, more.errors
    assert len(read_placement(out).samples) == counted + 1


def test_a_script_gives_the_same_file_every_time(tmp_path: Path, scripted) -> None:
    keys = "a*3 s a*2 u a  # one is taken back\n0 a q"
    first = scripted(tmp_path / "first", keys)
    assert first.status == 0, first.errors
    assert scripted(tmp_path / "second", keys).status == 0
    a, b = read_placement(tmp_path / "first"), read_placement(tmp_path / "second")
    assert np.array_equal(a.positions, b.positions)
    assert a.sockets.tolist() == [0, 0, 0, 1, 1, 0]
    assert_true(a.positions, configurations(40), 75)


@pytest.mark.usefixtures("virtual_time")
def test_a_script_that_waits_in_vain_fails(tmp_path: Path) -> None:
    hand, keys = tmp_path / "hand.csv", tmp_path / "keys.txt"
    hand.write_text(",".join(map(repr, PANDA_HOME)))
    keys.write_text("a a q")
    driver = f"mock:{hand}?rate=250&hold=0.65&move=0.6"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(tmp_path / "front")]
    assert main([*words, "--keys", str(keys)]) == 1
    assert len(read_placement(tmp_path / "front").samples) == 1


def test_refused_captures_of_a_script_fail_it(tmp_path: Path, scripted) -> None:
    done = scripted(tmp_path / "front", "a !a q")
    assert done.status == 1
    assert "! refused: nearly the same configuration as sample 1" in done.output
    assert "1 captures were refused" in done.output


def test_the_same_out_continues(tmp_path: Path, scripted) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a*2 s a q").status == 0
    again = scripted(out, "u a*2 q")
    assert again.status == 0
    assert "continues a recording of 3 samples" in again.output
    assert read_placement(out).sockets.tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (["--distance", "0.1"], "info --set-distance 0.1"),
        (["--robot", "fr3"], "recorded with robot"),
        (["--sockets", "3"], "recorded with sockets 2, not 3"),
    ],
)
def test_another_robot_or_base_does_not_continue(
    tmp_path: Path, scripted, change: list[str], told: str
) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a q").status == 0
    before = (out / "samples.csv").read_bytes()
    done = scripted(out, "a q", *change)
    assert done.status == 2
    assert told in done.errors and done.errors.count("\n") == 1
    assert (out / "samples.csv").read_bytes() == before


def test_a_recording_is_continued_with_its_own_distance(tmp_path: Path, scripted) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a q", "--distance", "0.0501").status == 0
    assert scripted(out, "a q").status == 0
    assert read_placement(out).distance == 0.0501


def test_a_distance_is_corrected_and_what_it_was_stays_known(
    tmp_path: Path, scripted, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a q").status == 0
    assert main(["info", str(out), "--set-distance", "0.0502"]) == 0
    assert "50.2 mm" in capsys.readouterr().out
    metadata = json.loads((out / "placement.json").read_text())
    assert metadata["distance"] == 0.0502
    assert metadata["changes"][0]["distance"] == [0.05, 0.0502]
    assert scripted(out, "a q").status == 0


def test_a_recording_is_continued_in_the_socket_where_the_ball_was(
    tmp_path: Path, scripted
) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a*2 s q").status == 0
    assert scripted(out, "a q").status == 0
    assert read_placement(out).sockets.tolist() == [0, 0, 1]


def test_a_folder_of_placements_is_not_recorded_into(tmp_path: Path, scripted) -> None:
    assert scripted(tmp_path / "data/front", "a q").status == 0
    done = scripted(tmp_path / "data", "a q")
    assert done.status == 2 and "holds placements (front)" in done.errors
    assert not (tmp_path / "data/samples.csv").exists()


def test_marks_on_earlier_samples_count_and_stay_in_the_file(tmp_path: Path, scripted) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a*3 u r delete=1 relabel=2:1 q").status == 0
    assert [s.number for s in read_placement(out).samples] == [2, 3]
    assert read_placement(out).sockets.tolist() == [1, 0]
    events = [line.split(",")[0] for line in (out / "samples.csv").read_text().splitlines()[1:]]
    assert events == [*["capture"] * 3, "undo", "redo", "undo", "relabel"]
    again = scripted(out, "r delete=9 relabel=1:7 a q")
    assert len(read_placement(out).samples) == 4
    assert "there is no sample 9" in again.output and "there is no socket 7" in again.output


def test_the_closing_words_run_as_they_are_printed(
    session: Path, tmp_path: Path, scripted, monkeypatch: pytest.MonkeyPatch
) -> None:
    urdf = tmp_path / "arm.urdf"
    text = shipped_robots()["panda"].read_text()
    urdf.write_text(text)
    monkeypatch.chdir(tmp_path)
    ball = ["--flange", "panda_link8", "--tip", "knob", "--ball", "0.0", "0.0", "0.05"]
    words = ["a*3 s a*3 q", "--robot", str(urdf), *ball]
    done = scripted(Path("my data/front"), *words, hand=session / "front")
    assert done.status == 0, done.errors
    commands = [line.split(": ", 1)[1] for line in done.output.splitlines() if ": mukca " in line]
    assert [shlex.split(line)[1] for line in commands] == ["check", "solve", "record"]
    assert shlex.split(commands[2])[-1] == "my data/front-2"
    for line in commands[:2]:
        assert main(shlex.split(line)[1:]) in (0, 1), line


def test_ctrl_c_ends_the_program_while_it_loads(hand: Path, tmp_path: Path) -> None:
    """Even where something that is being imported swallows the exception."""
    loading = (
        "import sys, time, mukca.tools.commands.record as r\n"
        "def slow(arguments):\n"
        "    try: time.sleep(60)\n"
        "    except KeyboardInterrupt: time.sleep(60)\n"
        "r.robot_of = slow\n"
        "from mukca.tools.cli import main\n"
        "sys.exit(main())\n"
    )
    words = [MUKCA[0], "-c", loading, *command(hand, tmp_path / "front")[len(MUKCA) :]]
    with TerminalSession(words) as terminal:
        terminal.wait_for("loading ...")
        time.sleep(0.5)
        terminal.press("\x03")
        assert terminal.wait(20) == 130
        terminal.wait_for("interrupted")


def test_what_is_continued_is_asked_about(hand: Path, tmp_path: Path, scripted) -> None:
    out = tmp_path / "front"
    assert scripted(out, "a*2 s a q").status == 0
    with TerminalSession(command(hand, out)) as terminal:
        terminal.wait_for("GO ON?", "2 in socket 0, 1 in socket 1", "Has the base not moved")
        terminal.press("a")
        terminal.wait_for("GO ON?")
        terminal.press("n")
        terminal.wait_for("front-2", "0:  0/30")
        capture(terminal, "a", "captured sample 1")
        terminal.press("q")
        assert terminal.wait() == 0
    assert len(read_placement(out).samples) == 3
    assert len(read_placement(tmp_path / "front-2").samples) == 1


def test_a_simple_terminal_shows_what_to_do(tmp_path: Path) -> None:
    still = tmp_path / "hand.csv"
    still.write_text(",".join(map(repr, PANDA_HOME)))
    words = command(still, tmp_path / "front")
    with TerminalSession(words, environment={"TERM": "dumb"}) as terminal:
        terminal.wait_for("PRESS: space captures sample 1")
        terminal.press(" ")
        terminal.wait_for("captured sample 1", "NEXT POSE")
        terminal.press("q")
        assert terminal.wait() == 0


def test_two_recorders_cannot_share_a_folder(hand: Path, tmp_path: Path, scripted) -> None:
    out = tmp_path / "front"
    with TerminalSession(command(hand, out)) as terminal:
        terminal.wait_for("SOCKET 0")
        done = scripted(out, "a q")
        assert done.status == 2
        assert "another mukca record is writing there" in done.errors


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--driver", "nonesuch:1"], "no driver is called 'nonesuch'"),
        (["--driver", "mock:/nowhere"], "/nowhere: cannot be read"),
        (["--window", "0"], "--window 0: expected"),
        (["--distance", "nan"], "--distance nan: expected"),
        (["--keys", "/nowhere"], "--keys /nowhere: No such file"),
        (["--robot", "ur5e"], "the recording has 7 joints, but the model has 6"),
    ],
)
def test_bad_usage_is_one_line(tmp_path: Path, scripted, more: list[str], told: str) -> None:
    done = scripted(tmp_path / "front", "q", *more)
    assert done.status == 2
    assert told in done.errors and done.errors.count("\n") == 1
    assert not (tmp_path / "front").exists()


def test_neither_keys_nor_a_terminal_is_told(hand: Path, tmp_path: Path) -> None:
    words = fast(hand, tmp_path / "front")
    done = subprocess.run(
        words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "standard input holds no keys; run it in a terminal" in done.stderr


@pytest.mark.slow
def test_a_closed_standard_input_is_told(hand: Path, tmp_path: Path) -> None:
    """As under some service managers; a key script needs none."""
    words = fast(hand, tmp_path / "front")
    script = tmp_path / "keys.txt"
    script.write_text("a q")
    shell = ["sh", "-c", 'exec "$0" "$@" <&-']
    done = subprocess.run([*shell, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert "run it in a terminal, or use --keys FILE" in done.stderr
    words += ["--keys", str(script)]
    done = subprocess.run([*shell, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "1 in socket 0" in done.stdout


def test_a_word_that_is_no_key_is_told(tmp_path: Path, scripted) -> None:
    done = scripted(tmp_path / "front", "a x q")
    assert done.status == 2
    assert "'x' is no word of a key script" in done.errors


@pytest.mark.slow
def test_scripted_sessions_calibrate_to_the_truth(
    session: Path, tmp_path: Path, scripted, capsys: pytest.CaptureFixture[str]
) -> None:
    """What was recorded through the recorder solves as well as the true configurations do."""
    for name in ("front", "left"):
        done = scripted(tmp_path / name, "a*12 s a*12 q", hand=session / name)
        assert done.status == 0, done.output
        assert_true(read_placement(tmp_path / name).positions, truth(session / name), 75)
    errors = {}
    for folder in (tmp_path, session):
        words = ["solve", str(folder / "front"), "--test", str(folder / "left")]
        assert main([*words, "--robot", "panda", "--json"]) == 0
        errors[folder] = json.loads(capsys.readouterr().out)["summary"]["test"]
    nominal, found, true = (
        errors[folder][model]["mean_absolute_error"]
        for folder, model in (
            (tmp_path, "nominal"),
            (tmp_path, "calibrated"),
            (session, "calibrated"),
        )
    )
    assert nominal > 1e-3 > 5 * found
    assert found == pytest.approx(true, abs=5e-6)


def truth(folder: Path) -> list[list[float]]:
    placement: Placement = read_placement(folder)
    return placement.positions.tolist()


def test_keys_can_be_piped(hand: Path, tmp_path: Path) -> None:
    out = tmp_path / "front"
    done = subprocess.run(
        fast(hand, out), input="a*2 s a", capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert "1 in socket 1" in done.stdout and "\x1b" not in done.stdout
    assert read_placement(out).sockets.tolist() == [0, 0, 1]


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").exists(), reason="needs /proc")
def test_a_thousand_states_a_second_reach_the_screen(hand: Path, tmp_path: Path) -> None:
    """A soak in small: the mock forgets what is not read in time, and forgets nothing."""
    words = command(hand, tmp_path / "front", mock="&buffer=1")
    with TerminalSession(words) as terminal:
        terminal.wait_for("PRESS: space captures")
        process = terminal.process.pid
        frames, begun, used = count_frames(terminal), time.monotonic(), cpu_seconds(process)
        time.sleep(6.0)
        elapsed = time.monotonic() - begun
        drawn, used = count_frames(terminal) - frames, cpu_seconds(process) - used
        terminal.wait_for("missed 0")
        assert drawn / elapsed >= 5
        assert used / elapsed < 0.9


def count_frames(terminal: TerminalSession) -> int:
    """Every drawing changes the line with the stream's age."""
    return terminal.output.count(b"last state")


def cpu_seconds(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_two_minutes_tell_whether_to_calibrate(session: Path, tmp_path: Path, scripted) -> None:
    done = scripted(tmp_path / "quick", "a*10 q", "--quick", hand=session / "front")
    assert done.status == 0, done.errors
    assert "By its model the ball scatters by" in done.output
    assert "worth calibrating" in done.output and "mukca solve" not in done.output
    few = scripted(tmp_path / "few", "a*3 q", "--quick", hand=session / "front")
    assert few.status == 0 and "Too few poses to tell" in few.output


def test_two_minutes_tell_whether_a_calibration_holds(
    session: Path, tmp_path: Path, scripted, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "calibrated"
    words = ["solve", str(session / "front"), "--test", str(session / "left"), "--method", "paper"]
    assert main([*words, "--robot", "panda", "--out", str(out)]) == 0
    capsys.readouterr()
    file = str(out / "calibration.json")
    more = ["a*10 q", "--quick", "--calibration", file]
    done = scripted(tmp_path / "quick", *more, hand=session / "right")
    assert done.status == 0 and "Still valid" in done.output, done.output
    moved = read_placement(session / "right")
    rows = [s.position for s in moved.samples if s.socket == 0]
    shifted = tmp_path / "hand.csv"
    shifted.write_text("\n".join(",".join(map(str, (*q[:3], q[3] + 0.008, *q[4:]))) for q in rows))
    done = scripted(tmp_path / "later", *more, hand=shifted)
    assert done.status == 1 and "likeliest cause: panda_joint4" in done.output, done.output
    assert scripted(tmp_path / "x", "q", "--calibration", file).status == 2


def test_a_page_for_others_is_warned_of_and_one_that_cannot_be_is_told(
    tmp_path: Path, scripted
) -> None:
    seen = scripted(tmp_path / "front", "a q", "--page", "--page-host", "127.0.0.2")
    assert seen.status == 0 and "page: http://127.0.0.2:" in seen.output
    assert "! whoever knows this address can watch" in seen.output
    done = scripted(tmp_path / "left", "a q", "--page", "--page-host", "203.0.113.1")
    assert done.status == 2 and "no page can be served there" in done.errors
    assert done.errors.count("\n") == 1

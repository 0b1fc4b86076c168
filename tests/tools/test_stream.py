"""`mukca stream` and `mukca emulate` as people and scripts use them."""

import json
import re
import subprocess
import time

import pytest
from emulation import emulated_program
from terminal_session import MUKCA, TerminalSession

from mukca.tools.cli import main
from mukca.tools.meter import Meter


def stream(*words, status=0):
    done = subprocess.run([*MUKCA, "stream", *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == status, done.stderr
    return done


def test_json_is_one_object_a_state(tmp_path):
    with emulated_program("franka", tmp_path) as emulation:
        driver = ("--driver", f"franka:{emulation.address}")
        lines = stream(*driver, "--json", "--count", "50").stdout.splitlines()
        emulation.stop()
        sent = emulation.sent()
    states = [json.loads(line) for line in lines]
    assert len(states) == 50
    for state in states:
        assert state["position"] == sent[round(state["stamp"] * 1000)]["position"]
        assert (state["missed"], state["rejected"], state["drops"]) == (0, 0, 0)
        assert state["status"] == "guiding"


def test_a_pipe_gets_a_line_a_second_and_a_last_one(tmp_path):
    with emulated_program("ur", tmp_path, "--noise", "0", "--hold", "99") as emulation:
        done = stream("--driver", f"ur:{emulation.address}", "--seconds", "2.5")
        emulation.stop()
        degrees = [57.29577951308232 * angle for angle in emulation.sent()[1]["position"]]
    lines = done.stdout.splitlines()
    assert len(lines) == 3
    for line in lines:
        assert [float(word) for word in line.split()[:6]] == pytest.approx(degrees, abs=1e-3)
        assert "Hz" in line and "missed 0" in line and "running, normal" in line
    assert "\x1b" not in done.stdout


def test_the_screen_shows_angles_rate_gaps_and_a_drop(tmp_path):
    faults = ("--fault", "drop:0.1@0+2", "--fault", "hangup@3+1")
    with emulated_program("franka", tmp_path, *faults) as emulation:
        command = [*MUKCA, "stream", "--driver", f"franka:{emulation.address}"]
        with TerminalSession(command) as terminal:
            terminal.wait_for("joint7", "deg", "N m", "Hz", "guiding")
            terminal.wait_for("drops 1")
            missed = re.search(r"missed (\d+)", terminal.text)
            assert missed and int(missed[1]) > 50
            end = time.monotonic() + 60
            while "Hz" not in terminal.text or "closed" in terminal.text:
                assert time.monotonic() < end, terminal.text
                time.sleep(0.1)
            terminal.press("\x03")
            assert terminal.process.wait(30) == 130


@pytest.mark.parametrize("columns", [80, 50])
def test_the_screen_tells_all_of_a_trouble(tmp_path, columns):
    """However long it is, and that no state comes any more."""
    with emulated_program("franka", tmp_path, "--fault", "silent@1") as emulation:
        command = [*MUKCA, "stream", "--driver", f"franka:{emulation.address}"]
        with TerminalSession(command, columns=columns) as terminal:
            terminal.wait_for("\n0 Hz", "no state", "Desk", "programming", "silent")
            terminal.press("\x03")
            assert terminal.process.wait(30) == 130


def test_a_drop_is_told_on_standard_error(tmp_path):
    with emulated_program("ur", tmp_path, "--fault", "hangup@1+0.5") as emulation:
        driver = ("--driver", f"ur:{emulation.address}")
        done = stream(*driver, "--json", "--count", "900")
    assert json.loads(done.stdout.splitlines()[-1])["drops"] == 1
    assert "warning: the robot at" in done.stderr and "ended the connection" in done.stderr
    assert "warning: states come again" in done.stderr


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["stream", "--driver", "nothing:x"], "no driver is called 'nothing'; there are: franka"),
        (["stream", "--driver", "franka:127.0.0.1:9"], "refused the connection: activate FCI"),
        (["stream", "--driver", "franka"], "a host is missing"),
        (["stream", "--driver", "ur:127.0.0.1:9", "--count", "0"], "refused"),
        (["emulate", "franka", "--version", "99"], "no version 99; one of: 5, 3, 4"),
        (["emulate", "ur", "--fault", "explode"], "the kind one of drop"),
        (
            ["emulate", "piper", "--fault", "version"],
            "no fault 'version' at piper; there are: drop",
        ),
        (["emulate", "ur", "--fault", "commanding@3"], "no fault 'commanding' at ur"),
        (["emulate", "kinova", "--address", "x"], "leave --address out"),
        (["emulate", "ur", "--fault", "drop:2"], "the share is from 0 to 1"),
        (["emulate", "ur", "--fault", "drop@soon"], "KIND[:SHARE][@START[+DURATION]]"),
        (["emulate", "ur", "--rate", "0"], "--rate and --move are positive"),
        (["emulate", "ur", "--address", "8.8.8.8"], "cannot listen"),
        (["emulate", "ur", "--journal", "/nowhere/j"], "/nowhere/j: cannot be written"),
    ],
)
def test_bad_usage_is_one_line(words, told, capsys):
    assert main(words) == 2
    errors = capsys.readouterr().err
    assert told in errors
    assert errors.count("\n") == 1


def test_an_emulator_of_another_arms_recording(tmp_path, session):
    words = ["emulate", "ur", "--recording", str(session / "front")]
    done = subprocess.run([*MUKCA, *words], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "7 joints, but this controller's arm has 6" in done.stderr


def test_an_emulator_tells_how_to_read_it():
    process = subprocess.Popen([*MUKCA, "emulate", "kinova"], stdout=subprocess.PIPE, text=True)
    assert process.stdout
    lines = [process.stdout.readline() for _ in range(3)]
    process.terminate()
    assert process.wait(30) == 0
    process.stdout.close()
    assert lines[0] == "Emulating kinova, version serial.\n"
    assert "mukca stream --driver 'kinova:serial:///dev/pts/" in lines[1]


def test_the_meter():
    meter = Meter()
    assert meter.read().rate == 0
    for number in range(3001):
        meter.add(number * 0.001 + (0.004 if number % 50 == 0 else 0), waited=True)
    reading = meter.read()
    assert reading.rate == pytest.approx(1000, rel=0.01)
    assert reading.interval == pytest.approx(0.001)
    assert reading.worst_interval == pytest.approx(0.005, abs=1e-4)


def test_the_meter_leaves_out_states_that_were_waiting():
    """Two that came while a screen was drawn say nothing about the stream."""
    meter = Meter()
    for number in range(100):
        meter.add(number * 0.001, waited=True)
    for arrival in (0.150, 0.1501, 0.1502):
        meter.add(arrival, waited=False)
    meter.add(0.151, waited=True)
    assert meter.read().worst_interval == pytest.approx(0.001)

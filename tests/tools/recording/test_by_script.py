"""Sessions without a person: key scripts, pipes, wrong usage, and two minutes with ten poses."""

import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from altered import write_rows
from cases import by_table
from record_commands import PANDA_HOME, assert_true, configurations, fast, read
from terminal_session import PATIENCE

import mukca
from mukca.tools.cli import main

pytestmark = pytest.mark.slow


def test_a_script_gives_the_same_file_every_time(tmp_path, scripted):
    keys = "a*3 s a*2 u a  # one is taken back\n0 a q"
    first = scripted(tmp_path / "first", keys)
    assert first.status == 0, first.errors
    assert scripted(tmp_path / "second", keys).status == 0
    a, b = read(tmp_path / "first"), read(tmp_path / "second")
    assert np.array_equal(a.positions, b.positions)
    assert a.sockets.tolist() == [0, 0, 0, 1, 1, 0]
    assert_true(a.positions, configurations(40), 75)


@pytest.mark.usefixtures("virtual_time")
def test_a_script_that_waits_in_vain_fails(tmp_path):
    hand, keys = tmp_path / "hand.csv", tmp_path / "keys.txt"
    hand.write_text(",".join(map(repr, PANDA_HOME)))
    keys.write_text("a a q")
    driver = f"mock:{hand}?rate=250&hold=0.65&move=0.6"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(tmp_path / "front")]
    assert main([*words, "--keys", str(keys)]) == 1
    assert len(read(tmp_path / "front").samples) == 1


def test_a_refused_script_leaves_no_placement_behind(tmp_path, scripted):
    done = scripted(tmp_path / "data/front", "a b q")
    assert done.status == 2 and "'b' is no word of a key script" in done.errors
    assert "connecting" not in done.output and not (tmp_path / "data").exists()
    assert scripted(tmp_path / "front", "a q").status == 0
    before = (tmp_path / "front/samples.csv").read_bytes()
    assert scripted(tmp_path / "front", "a b q").status == 2
    assert (tmp_path / "front/samples.csv").read_bytes() == before


@by_table("keys", "told")
def test_refused_captures_of_a_script_fail_it(tmp_path, scripted, keys, told):
    done = scripted(tmp_path / "front", keys)
    assert done.status == 1, done.output
    assert "! refused: " in done.output and told in done.output
    assert "Refused: 1 capture\n" in done.output


def test_the_closing_words_run_as_they_are_printed(session, tmp_path, scripted, monkeypatch):
    urdf = tmp_path / "arm.urdf"
    (shipped,) = Path(mukca.__file__).parent.glob("solver/**/panda.urdf")
    urdf.write_bytes(shipped.read_bytes())
    monkeypatch.chdir(tmp_path)
    ball = ["--flange", "panda_link8", "--tip", "knob", "--ball", "0.0", "0.0", "0.05"]
    words = ["a*3 s a*3 q", "--distance", "0.05", "--robot", str(urdf), *ball]
    done = scripted(Path("my data/front"), *words, hand=session / "front")
    assert done.status == 0, done.errors
    commands = [line.split(": ", 1)[1] for line in done.output.splitlines() if ": mukca " in line]
    assert [shlex.split(line)[1] for line in commands] == ["check", "solve", "record"]
    assert shlex.split(commands[2])[-1] == "my data/front-2"
    assert "--distance 0.05" in commands[2]
    for line in commands[:2]:
        assert main(shlex.split(line)[1:]) in (0, 1, 3), line


def test_neither_keys_nor_a_terminal_is_told(hand, tmp_path):
    words = fast(hand, tmp_path / "front")
    done = subprocess.run(
        words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "standard input holds no keys; run it in a terminal" in done.stderr


def test_a_closed_standard_input_is_told(hand, tmp_path):
    """As under some service managers; a key script needs none."""
    words = fast(hand, tmp_path / "front")
    script = tmp_path / "keys.txt"
    script.write_text("a q")
    shell = ["sh", "-c", 'exec "$0" "$@" <&-']
    done = subprocess.run([*shell, *words], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    assert "run it in a terminal, or use --keys FILE" in done.stderr
    words += ["--keys", str(script)]
    done = subprocess.run([*shell, *words], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0 and "1 in socket 0" in done.stdout


def test_keys_can_be_piped(hand, tmp_path):
    out = tmp_path / "front"
    done = subprocess.run(
        fast(hand, out), input="a*2 s a", capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr
    assert "1 in socket 1" in done.stdout and "\x1b" not in done.stdout
    assert read(out).sockets.tolist() == [0, 0, 1]


def turned_hand(folder, angle, out):
    """Where a hand leads an arm to socket 0 whose fourth joint reads so much more."""
    rows = [s.position for s in read(folder).samples if s.socket == 0]
    return write_rows(out / "hand.csv", [(*q[:3], q[3] + angle, *q[4:]) for q in rows])


def test_two_minutes_tell_whether_to_calibrate(session, tmp_path, scripted):
    done = scripted(tmp_path / "quick", "a*10 q", "--quick", hand=session / "front")
    assert done.status == 0, done.errors
    assert "By its model the ball scatters by" in done.output
    assert "that is the target: q to finish" in done.output
    assert "worth calibrating" in done.output and "mukca solve" not in done.output
    few = scripted(tmp_path / "few", "a*3 q", "--quick", hand=session / "front")
    assert few.status == 3 and "Too few poses to tell" in few.output
    other = ["a*10 q", "--quick", "--robot", "iiwa14"]
    done = scripted(tmp_path / "other", *other, hand=session / "front")
    assert done.status == 1 and "This moves like a " in done.output
    off = turned_hand(session / "front", 0.15, tmp_path)
    done = scripted(tmp_path / "off", "a*10 q", "--quick", hand=off)
    assert done.status == 1 and "Verdict: FAIL" in done.output, done.output


def test_two_minutes_tell_whether_a_calibration_holds(session, tmp_path, scripted, capsys):
    out = tmp_path / "calibrated"
    words = ["solve", str(session / "front"), "--test", str(session / "left"), "--method", "paper"]
    assert main([*words, "--robot", "panda", "--out", str(out)]) == 0
    capsys.readouterr()
    file = str(out / "calibration.json")
    more = ["a*10 q", "--quick", "--calibration", file]
    done = scripted(tmp_path / "quick", *more, hand=session / "right")
    assert done.status == 0 and "still valid" in done.output, done.output
    assert "would not show in such samples: panda_joint1, panda_joint7;" in done.output
    shifted = turned_hand(session / "right", 0.008, tmp_path)
    done = scripted(tmp_path / "later", *more, hand=shifted)
    assert done.status == 1 and "nearest cause panda_joint4" in done.output, done.output
    none = scripted(tmp_path / "none", "q", "--calibration", file)
    assert none.status == 3 and "Too few poses to tell" in none.output


def test_a_page_for_others_is_warned_of_and_one_that_cannot_be_is_told(tmp_path, scripted):
    seen = scripted(tmp_path / "front", "a q", "--page", "--page-host", "127.0.0.2")
    assert seen.status == 0 and "page: http://127.0.0.2:" in seen.output
    assert "! whoever knows this address can watch" in seen.output
    done = scripted(tmp_path / "left", "a q", "--page", "--page-host", "203.0.113.1")
    assert done.status == 2 and "no page can be served there" in done.errors
    assert done.errors.count("\n") == 1

"""Habits that people bring from other programs: help VERB, -q, -v, --json, one file of a lab."""

import json
import shlex
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from mukca.tools import cli
from mukca.tools.cli import VERBS, Terminal, console, option_names
from mukca.tools.cli.commands import main

WORDS = "--robot panda --distance 0.05"


@pytest.fixture
def lab(session, tmp_path, monkeypatch):
    """A folder with recordings, and a function that writes the file of options above them."""
    monkeypatch.chdir(tmp_path)
    Path("data").mkdir()
    for name in ("front", "left"):
        Path("data", name).symlink_to(session / name)

    def write(*lines):
        Path("data/mukca.toml").write_text("\n".join(lines))

    return write


def test_help_of_a_verb_is_its_help(command):
    assert command("help", "solve") == command("solve", "--help")
    assert command("help") == command("--help")


def test_every_verb_with_a_result_has_json():
    without = [verb for verb, about in VERBS.items() if "--json" not in option_names(about.options)]
    assert without == ["record"]  # whose result is the recording


def test_quiet_is_silent_and_verbose_says_more(session, command):
    words = ("solve", session / "front", *WORDS.split(), "--method", "paper")
    status, out, _ = command(*words)
    assert command(*words, "-q")[:2] == (status, "")
    verbose = command(*words, "-v")
    assert len(verbose[1]) > len(out)
    quiet = command(*words, "-q", "--json")
    assert json.loads(quiet[1])["robot"] == "panda"


def test_work_that_takes_long_says_how_far_it_is(monkeypatch, capsys):
    monkeypatch.setattr(console, "SILENCE", 0.2)
    terminal = Terminal()
    with terminal.at_work("mukca fleet"), terminal.progress(3) as done:
        done("fit")
        done("check")
        time.sleep(0.5)
    assert "mukca fleet: at work for 0 s, at step 2 of 3: check\n" in capsys.readouterr().err
    with Terminal(quiet=True).at_work("mukca fleet"):
        time.sleep(0.3)
    with Terminal(verbose=True).progress() as done:
        done("fit")
    assert capsys.readouterr().err == "step 1: fit\n"


def test_each_verb_that_computes_breaks_its_silence(monkeypatch, capsys):
    monkeypatch.setattr(console, "SILENCE", 0.2)
    monkeypatch.setattr(cli, "read_options", lambda _: None)
    for name, count in (("handeye", 2), ("record", 0)):
        verb = SimpleNamespace(name=name, run=lambda *_: time.sleep(0.5))
        monkeypatch.setattr(main, "verb_of", lambda _, verb=verb: verb)
        main.run_verb(SimpleNamespace(verb=name), Terminal())
        assert capsys.readouterr().err.count(f"mukca {name}: at work") == count


def test_a_number_of_another_country_or_unit_is_met_with_the_right_one(refused, session):
    front = session / "front"
    refused("did you mean 0.05?", "check", front, "--robot", "panda", "--distance", "50")
    refused("as in 50.1mm", "check", front, "--robot", "panda", "--distance", "50.1xx")
    for typed, meant in (("0,05", "0.05"), ("50,5mm", "50.5mm")):
        words = ("check", front, "--robot", "panda", "--distance", typed)
        refused(f"did you mean '{meant}'?", *words)
    refused("did you mean 0.1?", "plan", "--robot", "panda", "--distance", "100")


def test_what_is_to_be_used_ends_with_zero_if_asked(session, command):
    words = ("solve", session / "front", *WORDS.split())
    status, out, _ = command(*words)
    assert status and "USE IT" in out
    assert command(*words, "--exit-zero")[0] == 0
    bad = (*words[:-1], "0.08")
    assert command(*bad, "--exit-zero")[0] == command(*bad)[0] != 0


def test_a_lab_types_its_arm_once(lab, command):
    typed = command("check", "data/front", *shlex.split(WORDS))
    lab('robot = "panda"', "distance = 0.05")
    for folder in ("data/front", "data"):  # beside, and above
        status, out, err = command("check", folder)
        assert err.splitlines()[0].endswith("mukca.toml: --robot=panda --distance=0.05")
    assert command("check", "data/front")[:2] == typed[:2] and status == typed[0] and out
    refusal = command("check", "data/front", "--robot", "ur5e")[2]
    assert "--robot=" not in refusal and "--distance=0.05" in refusal  # typed words count more


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("robto = 'panda'", "no key is called robto; did you mean robot?"),
        ("out = 'here'", "no key is called out; keys: robot"),
        ("robot = {a = 1}", "robot: expected a number, a text, or a list of them"),
        ("distance = 50", "did you mean 0.05?"),
        ("distance", "mukca.toml: "),
    ],
)
def test_a_file_of_options_that_cannot_be_is_told(lab, command, line, told):
    lab(line)
    words = () if line.startswith("robot") else ("--robot", "panda")
    status, out, err = command("check", "data/front", *words)
    assert (status, out) == (2, "") and told in err.splitlines()[-1]


def test_verbs_that_read_no_recordings_read_no_file_of_options(lab, command):
    lab('robot = "nobody"', "distance = 7")
    assert (
        command("print-parts", "--out", "data/parts", "--mount", "none", "--format", "stl")[0] == 0
    )

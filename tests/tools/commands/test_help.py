"""The help of the verbs: each option has a text, each text an option; long ones are cut short."""

import io
import os
import pydoc
import re
import subprocess
import sys
from contextlib import redirect_stdout, suppress
from dataclasses import replace
from pathlib import Path
from typing import get_type_hints

import pytest
from cases import by_table
from kept import compare

import mukca
from mukca.recorder import SOCKETS
from mukca.recorder.stream import STILL
from mukca.solver.assessment.verdict import STAMPS
from mukca.solver.calibration import OPTION_TABLE, CalibrateOptions, SolveOptions
from mukca.tools.cli import VERBS, main
from mukca.tools.recording import RecordOptions

SCREENS = Path(__file__).with_name("screens")


def shown(*words):
    with redirect_stdout(io.StringIO()) as out, suppress(SystemExit):
        main([*words])
    return out.getvalue()


@pytest.mark.parametrize("verb", [*VERBS, "simulate insertion", "simulate drawing"])
def test_each_option_says_what_it_is(verb):
    """What stands beside an option, or below it, is its text."""
    words = [*verb.split(), "--help" if " " in verb else "--help-all"]
    entries = re.findall(r"(?m)^  (--\w.*(?:\n {4,}.*)*)", shown(*words).partition("\nexample")[0])
    texts = [[*re.split(r" {2,}|\n +", entry, maxsplit=1), ""][1] for entry in entries]
    assert entries and [e for e, text in zip(entries, texts, strict=True) if len(text) < 4] == []


def test_the_verbs_stand_by_what_people_do(monkeypatch):
    """``MUKCA_KEEP_PAGES=1`` writes the screen anew."""
    monkeypatch.setenv("COLUMNS", "80")
    assert main([]) == 0
    compare(SCREENS / "help.txt", shown().splitlines())
    assert shown("--help") == shown()
    assert [verb for verb in VERBS if f"\n  {verb} " not in shown()] == []


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_shows_what_people_use_and_two_examples(verb):
    """Ten options at most beside those for help, and how many more there are."""
    short, whole = shown(verb, "--help"), shown(verb, "--help-all")
    names, more = (
        {*re.findall(r"(?m)^  (--[\w-]+)", text)} - {"--help-all"} for text in (short, whole)
    )
    assert len(names) <= 10 and names <= more
    assert 1 <= len(re.findall(r"(?m)^  mukca ", short)) <= 2
    hidden = len(more - names)
    noun = "option," if hidden == 1 else "options,"
    assert (f"{hidden} more {noun}" in short) == (hidden > 0)


def test_the_help_of_solve_has_each_verdict_with_its_status():
    statuses = re.search(r"Exit status 1: (.*) 3: (.*)", shown("solve", "--help-all"))
    for (status, kind), title in STAMPS.items():
        if status != "pass" and kind != "not_validated":  # of samples recorded later
            assert title in statuses[1 if status == "fail" else 2]


def test_the_help_of_record_has_the_defaults_that_hold():
    options = RecordOptions(driver="mock", out=Path("new"), robot="panda")
    words = " ".join(shown("record", "--help-all").split())
    assert f"1 to 10 (default: {SOCKETS})" in words
    assert f"samples for each socket (default: {options.samples})" in words
    assert f"is not still (default: {STILL}, or" in words
    assert f"take {replace(options, calibration=Path('arm')).samples} samples in each" in words


@by_table("line", "words")
def test_tab_completes_what_was_begun(tmp_path, line, words):
    pytest.importorskip("argcomplete")
    out = tmp_path / "words"
    shell = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(out),
    }
    shell |= {"COMP_LINE": line, "COMP_POINT": str(len(line))}
    subprocess.run([sys.executable, "-m", "mukca"], env=os.environ | shell, check=False)
    assert out.read_text().split() == words


def test_help_and_types_tell_the_options_that_there_are():
    keywords, fields = get_type_hints(CalibrateOptions), get_type_hints(SolveOptions)
    assert keywords == fields
    shown = pydoc.plain(pydoc.render_doc(mukca.calibrate))
    of_methods = re.split(r"Of\s+(?:both|``)", shown)[1:]
    for method, words in zip((None, "auto", "paper"), of_methods, strict=True):
        options = [name for name, option in OPTION_TABLE.items() if option.method == method]
        names = words.partition(":")[2].partition(".")[0]
        assert re.findall(r"\w+", names) == options
    assert "\n    Calibrate a robot from recordings.\n" in shown

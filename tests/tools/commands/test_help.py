"""The help of the verbs: each option has a text, each text an option; long ones are cut short."""

import io
import re
from contextlib import redirect_stdout, suppress
from pathlib import Path

import pytest
from kept import compare

import mukca.tools.cli
from mukca.tools.cli import VERBS, main

TEXTS = Path(mukca.tools.cli.__file__).with_name("options.txt").read_text().split("\n")
SCREENS = Path(__file__).with_name("screens")


def shown(*words):
    with redirect_stdout(io.StringIO()) as out, suppress(SystemExit):
        main([*words])
    return out.getvalue()


def test_each_text_is_of_an_option_that_there_is():
    text = "".join(shown(verb, "--help-all") for verb in VERBS)
    text += "".join(shown("simulate", kind, "--help") for kind in ("insertion", "drawing"))
    heads = [line.partition(":")[0].split() for line in TEXTS if line and line[0] not in " #["]
    lost = [
        name
        for name, *metavar in heads
        if f"--{name.replace('_', '-')}" not in text and " ".join(metavar) not in text
    ]
    assert len(heads) > 150 and lost == []


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
    assert (f"{hidden} more option" in short) == (hidden > 0)

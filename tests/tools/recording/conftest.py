"""A hand that leads the arm, and sessions by a key script."""

import pytest
from altered import write_rows
from record_commands import Done, configurations, fast
from terminal_session import MUKCA

from mukca.tools.cli import main


@pytest.fixture(autouse=True)
def state_folder(tmp_path, monkeypatch):
    """The page keeps its address there."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def hand(tmp_path):
    """Where a hand leads the arm: 40 configurations."""
    return write_rows(tmp_path / "hand.csv", configurations(40))


@pytest.fixture
def scripted(hand, tmp_path, capsys, virtual_time):
    """Run a session by a key script, in virtual time."""

    def run(out, keys, *more, hand=hand):
        script = tmp_path / "keys.txt"
        script.write_text(keys)
        words = [*fast(hand, out), "--keys", str(script), *more]
        status = main(words[len(MUKCA) :])
        read = capsys.readouterr()
        return Done(status, read.out, read.err)

    return run

"""A hand that leads the arm, and sessions by a key script."""

from pathlib import Path

import pytest
from record_commands import Done, configurations, fast
from terminal_session import MUKCA
from virtual_time import VirtualTime

from mukca.tools.cli import main


@pytest.fixture
def hand(tmp_path: Path) -> Path:
    """Where a hand leads the arm: 40 configurations."""
    file = tmp_path / "hand.csv"
    file.write_text("\n".join(",".join(map(repr, q)) for q in configurations(40)))
    return file


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

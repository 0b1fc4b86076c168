"""A recording with its stream kept: extract finds in it what was captured."""

from pathlib import Path

import numpy as np
import pytest

from mukca.recorder import read_placement
from mukca.tools.cli import main


@pytest.mark.slow
def test_what_was_captured_can_be_looked_at_again(
    extract, session, tmp_path: Path, virtual_time
) -> None:
    keys, out = tmp_path / "keys", tmp_path / "front"
    keys.write_text("a*12 s a*12 q")
    driver = f"mock:{session / 'front'}?rate=100&hold=1&move=0.8"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out)]
    assert main([*words, "--keys", str(keys), "--keep-stream"]) == 0
    assert {file.name for file in out.iterdir()} >= {"samples.csv", "states_1.stream"}
    status, _, err = extract(out, "--robot", "panda", "--out", tmp_path / "again")
    assert status == 0, err
    captured, found = read_placement(out), read_placement(tmp_path / "again" / "placement_1")
    assert found.sockets.tolist() == captured.sockets.tolist()
    # each the mean of some 30 states with 2e-5 rad of noise
    assert np.abs(found.positions - captured.positions).max() < 5 * 2e-5 / np.sqrt(15)

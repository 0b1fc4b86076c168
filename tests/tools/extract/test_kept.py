"""A recording with its stream kept: extract finds in it what was captured."""

import numpy as np
import pytest

import mukca
from mukca.tools.cli import main


@pytest.mark.slow
def test_what_was_captured_can_be_looked_at_again(
    extract, refused, session, tmp_path, virtual_time
):
    keys, out = tmp_path / "keys", tmp_path / "front"
    keys.write_text("a*12 s a*12 q")
    driver = f"mock:{session / 'front'}?rate=100&hold=1&move=0.8"
    words = ["record", "--robot", "panda", "--driver", driver, "--out", str(out)]
    assert main([*words, "--keys", str(keys), "--keep-stream"]) == 0
    assert {file.name for file in out.iterdir()} >= {"samples.csv", "states_1.stream"}
    status, _, err = extract(out, "--robot", "panda", "--out", tmp_path / "again")
    assert status == 0, err
    captured, found = mukca.read_placements(out)[0], mukca.read_placements(tmp_path / "again")[0]
    assert found.sockets.tolist() == captured.sockets.tolist()
    # each the mean of some 30 states with 2e-5 rad of noise
    assert np.abs(found.positions - captured.positions).max() < 5 * 2e-5 / np.sqrt(15)
    refused("it has panda_joint1", "extract", out / "states_1.stream", "--robot", "ur5e")
    (out / "states_1.stream").write_bytes(b"something else\n")
    refused("not a stream of states", "extract", out, "--robot", "panda")

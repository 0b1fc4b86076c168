"""Payloads that differ from placement to placement."""

import json
from dataclasses import replace

import numpy as np
import pytest
from altered import moved, write_samples
from imagined import held_out
from recorded import recorded_with_loads

import mukca
from mukca import MukcaError

UNBENT = ("tilt", "transmission", "curves")
"""Effects that this arm does not have."""
MASSES = {"bare": 0.0, "loaded": 4.0, "other": 2.0}


@pytest.fixture(scope="module")
def placements():
    """Placements of an arm that bends, each recorded with another mass at the ball."""
    placements = recorded_with_loads(mukca.load_robot("panda"), MASSES.values(), 1e-4, 15)
    pairs = zip(MASSES, placements, strict=True)
    return [replace(placement, name=f"s/{name}", place=name) for name, placement in pairs]


@pytest.mark.slow
def test_one_fit_holds_different_loads_and_predicts_another(placements, tmp_path, command, refused):
    robot, (bare, loaded, other) = mukca.load_robot("panda"), placements
    stated = [f"{name}={mass}" for name, mass in MASSES.items()]
    found, unsaid = (
        mukca.calibrate(robot, [bare, loaded], [other], payload=payload, without=UNBENT)
        for payload in (stated, None)
    )
    assert held_out(found) < 1e-4 < held_out(unsaid)
    found.save(tmp_path / "cal")
    again = mukca.load_calibration(tmp_path / "cal")
    masses = {row.name: row.payload for row in again.document.data}
    assert masses == {"s/bare": 0.0, "s/loaded": 4.0, "s/other": 2.0}
    assert again.document.load.payload == 0.0
    assert not mukca.what_changed(again, replace(other, payload=2.0)).changed
    assert mukca.what_changed(again, other).changed
    off = moved(other, other.positions - 5e-3 * np.eye(7)[3])
    cause = mukca.what_changed(again, replace(off, payload=2.0)).cause
    assert cause is not None and cause.error < 1e-4
    write_samples(tmp_path / "later", other)
    later, calibrated = str(tmp_path / "later"), str(tmp_path / "cal")
    validate, check = ("validate", calibrated, later), ("check", later, "--calibration", calibrated)
    for words, mass in ((validate, "later=2"), (check, "2")):
        said = command(*words, "--payload", mass, "--json")[1]
        assert json.loads(said)["likeliest"] == "nothing", words
    refused("kitchen=2", *validate, "--payload", "kitchen=2")


def test_a_placement_states_its_own_payload(placements, tmp_path):
    write_samples(tmp_path / "front", placements[0])
    file = tmp_path / "front" / "placement.json"
    keys = json.loads(file.read_text()) if file.is_file() else {}
    file.write_text(json.dumps({**keys, "payload": 1.5}))
    (front,) = mukca.read_placements(tmp_path / "front")
    assert front.payload == 1.5
    file.write_text(json.dumps({**keys, "payload": "heavy"}))
    with pytest.raises(MukcaError, match="payload 'heavy': expected kilograms"):
        mukca.read_placements(tmp_path / "front")

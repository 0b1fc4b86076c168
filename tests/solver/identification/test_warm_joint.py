"""A joint that gives way more when it is warm: an effect of temperature, as the recipe says."""

import numpy as np
import pytest

import mukca
from mukca.recorder import Placement
from mukca.solver.identification.data import measure
from mukca.solver.identification.effects import (
    EFFECTS,
    EXTENSIONS,
    OWN,
    Display,
    Effect,
    add_effect,
)

WARMTH = Effect(
    name="warmth",
    extension="warmth",
    unit="rad/(N m K)",
    axes={"warmth": OWN},
    derivatives=lambda samples: -samples.torques * samples.temperature,
    typical_shift=3e-4,
    non_negative=True,
    shown=Display(
        "urad/(N m K)",
        1e6,
        usual_turn=200.0,
        usual_words="warm joints under 10 N m, 20 K on",
        heading="warm joints",
        by_joint=True,
    ),
)
OPTIONS = {"samples": 30, "seed": 3, "warmth": 8e-6, "warming": 20.0}


@pytest.fixture(scope="module")
def table():
    """The table with the effect, for as long as it is tried."""
    effects = [*EFFECTS.values()]
    add_effect(WARMTH)
    yield
    EFFECTS.clear()
    for effect in effects:
        add_effect(effect)


@pytest.fixture(scope="module")
def simulated(panda, table):
    return mukca.simulate_recordings(panda, 3, **OPTIONS)


def test_a_simulated_arm_turns_by_it_and_each_sample_keeps_its_temperature(panda, simulated):
    _, placements = simulated
    _, cold = mukca.simulate_recordings(panda, 3, **OPTIONS | {"warming": 0.0})
    turns = np.abs(placements[0].positions - cold[0].positions)
    assert turns[0].max() == 0 and turns[-1].max() > 3e-4
    temperatures = [sample.temperature for sample in placements[0].samples]
    assert temperatures == pytest.approx(np.linspace(0, 20, 60))
    assert cold[0].samples[-1].temperature is None


@pytest.mark.slow
def test_it_is_recovered_and_shown(panda, simulated, tmp_path):
    truth, (*train, held_out) = simulated
    others = [name for name in EXTENSIONS if name != "warmth"]
    calibration = mukca.calibrate(panda, train, test=held_out, without=others)
    rows = {row.name: row for row in calibration.document.coefficients}
    names = WARMTH.coefficient_names(panda.joint_names)
    for name, value in zip(names, truth.deflection.coefficients[0].tolist(), strict=True):
        row = rows[name]
        assert abs(row.value - value) < 3 * max(row.standard_deviation, 1e-8), name
    known = [row for row in rows.values() if row.value > 5 * row.standard_deviation > 0]
    assert len(known) >= 2
    mukca.write_report(calibration, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "warm joints, urad/(N m K)" in page
    saved = mukca.load_calibration(calibration.save(tmp_path / "out")["calibration"])
    last = saved.document.data[0].samples[-1]
    assert last.temperature == pytest.approx(20.0)


def test_arrays_keep_their_temperatures_from_the_first_sample_on(panda, simulated):
    placement = simulated[1][0]
    T = np.linspace(295.0, 305.0, 60)
    own = Placement.of_arrays("own", placement.positions, placement.sockets, temperatures=T)
    assert measure(own, panda, 0.05).clocks[:, 2] == pytest.approx(T - 295.0)
    with pytest.raises(mukca.MukcaError, match=r"temperatures of \(59,\)"):
        Placement.of_arrays("own", placement.positions, placement.sockets, temperatures=T[1:])

"""Faults of a simulated session: each word of a cause makes one, as large as its size says."""

import numpy as np
import pytest

import mukca
from mukca.solver.diagnostics import FLAWS
from mukca.solver.identification.robot import BallModel
from mukca.tools.simulation import Session, SessionFault


@pytest.fixture(scope="module")
def session(panda):
    """Return a placement of a sound arm, its sockets as fitted."""
    _, (sound,) = mukca.simulate_recordings(panda, 1, samples=12, seed=1)
    q, sockets = sound.positions, sound.sockets
    balls = BallModel(panda, []).points(np.zeros(0), q)
    centres = np.array([balls[sockets == k].mean(axis=0) for k in (0, 1)])
    return Session(panda, q, sockets, centres, np.random.default_rng(1))


@pytest.mark.parametrize("word", FLAWS)
def test_every_word_of_a_cause_is_a_fault_with_its_unit(word):
    unit = FLAWS[word][0].unit
    assert SessionFault.parse(f"{word}:3{unit}" if unit else word)


def test_a_base_that_sags_moves_the_ball_by_its_size_at_most(session):
    shifts = SessionFault.parse("sag:3mm").shift(session)
    assert np.linalg.norm(shifts, axis=1).max() == pytest.approx(3e-3)


def test_a_gain_reads_a_joint_amid_the_chain_too_much_by_its_share(session):
    model = BallModel(session.robot, [])
    slopes = model.linearise(model.nominal, session.positions).by_joints[:, :, 3]
    moved = 0.03 * np.abs(session.positions[:, 3]) * np.linalg.norm(slopes, axis=1)
    shifts = SessionFault.parse("gain:3%").shift(session)
    assert np.linalg.norm(shifts, axis=1) == pytest.approx(moved, rel=0.02)


@pytest.mark.parametrize("word", ["length", "angle"])
def test_a_flaw_of_the_model_grows_with_its_size(session, word):
    unit = FLAWS[word][0].unit
    once, twice = (SessionFault.parse(f"{word}:{n}{unit}").shift(session) for n in (1, 2))
    sizes = [np.linalg.norm(shifts, axis=1) for shifts in (once, twice)]
    assert 2 * sizes[0] == pytest.approx(sizes[1]) and sizes[0].max() > 0


@pytest.mark.parametrize(
    ("offset", "told"), [(-1e-6, "add 0.00 deg"), (1e-6, "add 0.00 deg"), (-0.01, "add -0.57 deg")]
)
def test_a_size_that_rounds_to_zero_has_no_sign(offset, told):
    kind = FLAWS["zero"][0]
    assert told in kind.text({"joint": "panda_joint4", "offset": offset})

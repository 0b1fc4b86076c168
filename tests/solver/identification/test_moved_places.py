"""Places that moved while they were recorded: told by the evidence, and held by the model."""

from dataclasses import replace

import numpy as np
import pytest
from altered import seats, write_rows, write_samples
from cases import by_table
from recorded import RIGID
from worlds import realistic_flaws

import mukca
from mukca.recorder import Sample
from mukca.solver.identification.robot import workspace
from mukca.tools.simulation import (
    Session,
    SessionFault,
    perturb,
    reachable_bases,
    record,
    truth_of,
    with_faults,
)

pytestmark = pytest.mark.slow

IN_TURN = [*range(6), *range(12, 18), *range(6, 12), *range(18, 24)]


def recorded(panda, fault, order=IN_TURN):
    """Return the truth, and 12 + 12 samples in an order, with a fault."""
    truth, (placement,) = mukca.simulate_recordings(panda, 1, samples=12, seed=3)
    q, sockets = placement.positions[list(order)], placement.sockets[list(order)]
    session = Session(panda, q, sockets, seats(truth, placement), np.random.default_rng(1))
    found = SessionFault.parse(fault)
    q = with_faults(session, [found] if found else [])
    samples = (
        Sample(tuple(row), k, number=i, time=20.0 * i)
        for i, (row, k) in enumerate(zip(q.tolist(), sockets.tolist(), strict=True), 1)
    )
    return truth, replace(placement, samples=tuple(samples))


def error(truth, found, q):
    lengths = [
        np.linalg.norm(p[1:] - p[:-1], axis=1) for p in (truth.ball(q), found.calibrated.ball(q))
    ]
    return float(np.mean(np.abs(lengths[1] - lengths[0])))


def told(found):
    return [d.text for d in found.document.checks or () if d.code == "movement"]


@by_table("fault", "words")
def test_a_base_that_moves_is_told_and_taken_into_account(panda, fault, words):
    truth, placement = recorded(panda, fault)
    found = mukca.calibrate(panda, placement, **RIGID)
    (text,) = told(found)
    assert words in text
    q = np.random.default_rng(0).uniform(-1, 1, (50, 7)) - [0, 0, 0, 1.5, 0, -1.5, 0]
    without = mukca.calibrate(panda, placement, as_recorded=True, **RIGID)
    assert not told(without)
    assert error(truth, found, q) < 0.7 * error(truth, without, q)
    silent = replace(
        placement, samples=tuple(replace(s, number=0, time=None) for s in placement.samples)
    )
    by_order = mukca.calibrate(panda, silent, **RIGID)
    assert told(by_order) and error(truth, by_order, q) < 0.7 * error(truth, without, q)
    assert found.errors.summary.train.calibrated.mean_absolute_error < 2e-4


def test_a_base_that_falls_back_is_told_and_its_samples_count(panda):
    """Their weights alone would leave them out."""
    _, placement = recorded(panda, "base@10+3:3mm")
    found = mukca.calibrate(panda, placement, **RIGID)
    (text,) = told(found)
    assert "from sample 10 to sample 12 only" in text
    without = mukca.calibrate(panda, placement, as_recorded=True, **RIGID)
    errors = [of.errors.summary.train.calibrated.mean_absolute_error for of in (found, without)]
    assert errors[0] < 2e-4 < errors[1]
    moved = [s for s in found.document.data[0].samples if np.linalg.norm(s.moved) > 2.5e-3]
    assert len(moved) == 3


def test_a_base_that_stands_still_and_blocks_in_a_row_tell_of_no_step(panda):
    assert not told(mukca.calibrate(panda, recorded(panda, "none")[1], **RIGID))
    _, blocks = recorded(panda, "base@13:0.5mm", range(24))
    in_a_row = told(mukca.calibrate(panda, blocks, **RIGID))
    assert not any("change of socket" in text for text in in_a_row)


def test_files_of_sockets_say_which_was_taken_to_be_first(panda):
    _, placement = recorded(panda, "drift:2mm", range(24))
    samples = [replace(s, number=0, time=None) for s in placement.samples]
    found = mukca.calibrate(panda, replace(placement, samples=tuple(samples)), **RIGID)
    assert all("recorded first" in text for text in told(found))
    assert told(found)
    (timed,) = told(mukca.calibrate(panda, placement, **RIGID))
    assert "recorded first" not in timed


def test_a_conversion_makes_no_order_up_and_keeps_one_that_is_known(panda, tmp_path, command):
    """The base moved while socket 1, which was first, was recorded: both orders are weighed."""
    _, placement = recorded(panda, "base@6:3mm", [*range(12, 24), *range(12)])
    folders = [tmp_path / name for name in ("timed", "holes", "samples", "again", "copy")]
    write_samples(folders[0], placement)
    steps = (0, 1, "holes"), (1, 2, "samples"), (2, 3, "holes"), (0, 4, "samples")
    for i, j, form in steps:
        assert command("convert", folders[i], "--to", form, "--out", folders[j])[0] == 0
    timed, holes, samples, again, copy = (
        mukca.calibrate(panda, mukca.read_placements(folder), **RIGID) for folder in folders
    )
    for found in (samples, again):
        assert np.array_equal(found.calibrated.values, holes.calibrated.values)
        assert ["recorded first" in text for text in told(found)] == [True]
    assert np.array_equal(copy.calibrated.values, timed.calibrated.values)
    assert not any("recorded first" in text for text in told(copy))


@pytest.mark.parametrize("moved", [2e-3, 25e-3])
def test_a_ball_put_on_anew_is_that_of_the_last_of_two_placements(panda, moved):
    truth, placements = mukca.simulate_recordings(panda, 2, samples=12, seed=3)
    first, last = placements
    q, sockets = first.positions, first.sockets
    session = Session(panda, q, sockets, seats(truth, first), np.random.default_rng(1))
    fault = SessionFault("bent", 1, size=moved)
    bent = first.with_positions(with_faults(session, [fault]))
    found = mukca.calibrate(panda, [bent, last], **RIGID)
    (text,) = told(found)
    assert f"elsewhere on its flange from {last.name} on" in text
    q = np.random.default_rng(0).uniform(-1, 1, (50, 7)) - [0, 0, 0, 1.5, 0, -1.5, 0]
    without = mukca.calibrate(panda, [bent, last], as_recorded=True, **RIGID)
    assert error(truth, found, q) < 0.6 * error(truth, without, q)


def test_an_encoder_replaced_between_two_placements_is_told(panda):
    _, (first, last) = mukca.simulate_recordings(panda, 2, samples=12, seed=3)
    q = last.positions + np.deg2rad(0.3) * np.eye(7)[3]
    (text,) = told(mukca.calibrate(panda, [first, last.with_positions(q)], **RIGID))
    assert "panda_joint4 reads 0.3" in text and f"from {last.name} on" in text


def test_an_encoder_replaced_on_an_arm_of_servos_is_no_ball_a_metre_away():
    robot = mukca.load_robot("so101")
    generator = np.random.default_rng([0, 77])
    arm = perturb(robot, generator, 2e-3, 5e-3)
    flaws = realistic_flaws(robot, generator)
    first, last = (
        record(arm, base, generator, samples=20, imperfection=flaws)
        for base in reachable_bases(arm, generator, 2)
    )
    q = first.positions + np.deg2rad(3) * np.eye(5)[2]
    found = mukca.calibrate(robot, [first.with_positions(q), last], no_proof=True)
    (text,) = told(found)
    assert "elbow_flex reads 2.98" in text and "deg less" in text and f"from {last.name} on" in text
    truth = truth_of(robot, arm, flaws.deflection)
    assert error(truth, found, workspace(robot, 100)) < 2e-3


def test_a_saved_calibration_knows_how_its_places_moved(panda, tmp_path):
    found = mukca.calibrate(panda, recorded(panda, "base@13:5mm")[1], **RIGID)
    found.save(tmp_path / "saved")
    again = mukca.load_calibration(tmp_path / "saved" / "calibration.json")
    assert told(again) == told(found)
    assert max(np.linalg.norm(s.moved) for s in again.document.data[0].samples) > 4.5e-3
    verdict = " ".join(row.text for row in (*again.verdict.limits, *again.verdict.reasons))
    assert "something moved at" in verdict


def test_an_instrument_that_follows_the_temperature(panda, tmp_path):
    truth, _ = mukca.simulate_recordings(panda, 1, seed=3)
    rng = np.random.default_rng(2)
    q = rng.uniform(-1, 1, (60, 7)) - [0, 0, 0, 1.5, 0, -1.5, 0]
    warm = 21 + np.sin(np.linspace(0, 4, 60)) + rng.normal(0, 0.02, 60)
    balls = truth.ball(q) + np.outer(warm - 21, [3e-4, 0, -2e-4]) + rng.normal(0, 2e-5, (60, 3))
    names = (*panda.joint_names, "x", "y", "z", "temperature [C]")
    write_rows(tmp_path / "points.csv", np.column_stack([q, balls, warm]).tolist(), names)
    points = mukca.read_placements(tmp_path)
    (text,) = told(mukca.calibrate(panda, points, **RIGID))
    assert "temperature" in text

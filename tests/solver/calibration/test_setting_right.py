"""Decisions, and what differs, are made and said; --as-recorded does none of it."""

from dataclasses import replace

import numpy as np
import pytest
from altered import moved as changed
from altered import write_samples
from calibrated_arm import balls_of
from recorded import RIGID, recorded_at

import mukca

PLACES = {"front": (0.5, 0.0, 0.1), "left": (0.3, 0.45, 0.1)}


def solved(robot, *data, **options):
    """A calibration that tries no effect: faults are set right before any is tried."""
    return mukca.calibrate(robot, *data, **(RIGID | options))


@pytest.fixture(scope="module")
def placements(true_panda):
    return [_recorded(true_panda, name, place) for name, place in PLACES.items()]


def _recorded(arm, name, place, seed=1):
    placement = recorded_at(arm, place, seed, name, samples=12)
    rows = [s for i in range(12) for s in placement.samples[i::12]]
    samples = tuple(replace(s, number=i, place=0) for i, s in enumerate(rows, start=1))
    return replace(placement, samples=samples)


@pytest.fixture(scope="module")
def moved(true_panda, placements):
    """The placements, whose bases moved by 4 mm before sample 15."""
    return [
        replace(one, samples=(*one.samples[:14], *_shifted(true_panda, one).samples[14:]))
        for one in placements
    ]


def _shifted(arm, placement):
    place = np.array(PLACES[placement.name]) + np.array([0.004, 0.0, 0.0])
    return _recorded(arm, placement.name, place)


@pytest.fixture(scope="module")
def sound(panda, placements):
    """The calibration by one of the placements, held out the other."""
    return solved(panda, placements[0], placements[1])


def remarks(found):
    return [check for check in found.document.checks if check.code == "set_right"]


def differences(found):
    return [check.text for check in found.document.checks if check.code == "movement"]


def test_a_move_is_an_unknown_of_the_fit_and_nothing_is_cut(panda, moved):
    found = solved(panda, moved[0], moved[1])
    names = {row.name: row for row in found.document.placements}
    assert {name: row.samples for name, row in names.items()} == {
        "front": (12, 12),
        "left": (12, 12),
    }
    (told,) = differences(found)
    assert "moved by 4.0" in told and "sample 15" in told
    train = names["front"].calibrated
    assert train.mean_absolute_error < 4e-4 and abs(train.distance_error) < 2e-4
    sizes = [np.linalg.norm(sample.moved) for sample in found.document.data[0].samples]
    assert max(sizes) == pytest.approx(4e-3, abs=3e-4)
    codes = [check.code for check in found.document.checks if "front" in check.where]
    assert codes == ["movement"]  # one line for one cause


def test_a_move_of_what_is_held_out_counts_in_its_errors(panda, moved):
    found = solved(panda, moved[0], moved[1])
    assert found.document.summary.test.calibrated.mean_absolute_error > 1e-3
    (told,) = [check for check in found.document.checks if check.where.startswith("left")]
    assert told.code == "moved" and "only the test used this placement" in told.advice
    assert "corrects" not in told.advice  # nothing is fitted to it


def test_as_recorded_sets_nothing_right(panda, moved):
    found = solved(panda, moved[0], moved[1], as_recorded=True)
    assert not remarks(found) and not differences(found)
    assert found.document.summary.train.calibrated.mean_absolute_error > 1e-3


def test_a_ball_that_never_changed_its_socket_tells_of_the_shape(panda, true_panda, placements):
    """One socket alone does not say how large the arm is: another placement has to."""
    front, left = placements
    again = _recorded(true_panda, "front", PLACES["front"], 2)
    twice = [replace(s, socket=1) for s in again.samples if s.socket == 0]
    first = [s for s in front.samples if s.socket == 0]
    rows = [s for pair in zip(first, twice, strict=False) for s in pair]
    one = replace(front, samples=tuple(replace(s, number=i) for i, s in enumerate(rows, start=1)))
    found = solved(panda, [one, left], _recorded(true_panda, "left", PLACES["left"], 3))
    row = found.document.placements[0]
    assert row.samples == (24,) and found.verdict.use
    assert "all samples count for socket 0" in str(remarks(found)[0])
    alone = solved(panda, one, left)
    assert not remarks(alone) and not alone.verdict.use


def test_samples_of_another_socket_are_taken_so(panda, placements):
    samples = [replace(s, socket=1) if s.number in (3, 5) else s for s in placements[0].samples]
    wrong = replace(placements[0], samples=tuple(samples))
    found = solved(panda, wrong, placements[1])
    assert found.document.placements[0].samples == (12, 12)
    assert all("counted for that socket" in one.advice for one in remarks(found)) and remarks(found)


def test_placements_of_one_name_are_told_apart(panda, placements, tmp_path):
    first, second = (replace(one, name="front") for one in placements)
    found = solved(panda, first, second, leave_out=["front (2):0:1"])
    assert found.document.placements[1].samples == (11, 12)
    assert [row.name for row in found.document.placements] == ["front", "front (2)"]
    for day, one in zip("ab", placements, strict=True):
        write_samples(tmp_path / day / "rec" / "front", one)
    folders = [tmp_path / day / "rec" / "front" for day in "ab"]
    names = [one.name for one in mukca.read_placements(*folders)]
    assert names == ["a/rec/front", "b/rec/front"]
    with pytest.raises(mukca.MukcaError, match="front is ambiguous; there are: "):
        solved(panda, mukca.read_placements(*folders), leave_out=["front:0:2"])
    ways = (folders[0], folders[0] / ".." / "front")
    twice = [mukca.read_placements(way)[0] for way in ways]
    with pytest.raises(mukca.MukcaError, match="the same placement"):  # and not ambiguous
        solved(panda, twice, leave_out=["front:0:1"])
    found = solved(panda, *(mukca.read_placements(folder) for folder in folders))
    assert [row.name for row in found.document.placements] == names


def test_what_is_left_out_by_hand(panda, placements):
    found = solved(panda, placements, leave_out=["left", "front:0:1,5-9"])
    (row,) = found.document.placements
    assert (row.name, row.samples) == ("front", (8, 12))
    kept = {sample.number for sample in found.document.data[0].samples}
    assert not kept & {1, 5, 7, 9} and {3, 6} <= kept
    with pytest.raises(mukca.MukcaError, match="no samples 2 in socket 0"):
        solved(panda, placements, leave_out=["front:0:2"])


def test_a_placement_with_too_few_samples_is_left_out_beside_others(panda, placements):
    short = replace(placements[1], samples=placements[1].samples[:2])
    found = solved(panda, [placements[0], short])
    assert [row.name for row in found.document.placements] == ["front"]
    assert any("left" in words and "is left out" in words for words in found.document.warnings)
    for more in ([short], [placements[0], short]):
        with pytest.raises(mukca.MukcaError, match="at least 2 are needed"):
            solved(panda, more, as_recorded=True)


def test_a_zero_that_slipped_is_an_unknown_of_the_fit(panda, placements):
    late = np.arange(24) >= 16
    q = placements[0].positions + np.outer(late, np.deg2rad(0.5) * np.eye(7)[3])
    after = changed(placements[1], placements[1].positions + np.deg2rad(0.5) * np.eye(7)[3])
    found = solved(panda, changed(placements[0], q), after)
    assert found.document.placements[0].samples == (12, 12)
    (told,) = differences(found)
    assert "panda_joint4 reads 0.5" in told and "sample 17" in told
    assert found.document.summary.test.calibrated.mean_absolute_error < 5e-4


def test_a_zero_that_slipped_far_between_the_sockets(panda, placements):
    samples = tuple(sorted(placements[0].samples, key=lambda s: s.socket))
    front = replace(placements[0], samples=samples)
    q = front.positions + np.outer(front.sockets, np.deg2rad(3) * np.eye(7)[3])
    found = solved(panda, changed(front, q), placements[1])
    assert found.document.placements[0].samples == (12, 12)
    assert "panda_joint4" in str(found.document.checks)


def _by_socket(placement):
    """Samples of socket 0 first, as a session records them that changes the socket once."""
    samples = sorted(placement.samples, key=lambda sample: sample.socket)
    numbered = (replace(sample, number=i) for i, sample in enumerate(samples, start=1))
    return replace(placement, samples=tuple(numbered))


def test_a_known_distance_of_a_base_that_moved(panda, true_panda, placements):
    """The base moves before sample 6, and socket 1 has no sample before it."""
    front = _by_socket(placements[0])
    after = _by_socket(_shifted(true_panda, placements[0]))
    moved = replace(front, samples=(*front.samples[:5], *after.samples[5:]))
    found = solved(panda, [moved, placements[1]], known=["front:1-left:0=0.4857+-0.005"])
    (told,) = differences(found)
    assert "sample 6" in told
    assert found.document.summary.train.calibrated.mean_absolute_error < 4e-4


def test_advice_says_which_solve_has_an_unknown(panda, moved):
    for options, words in (
        ({"method": "paper", "without": ()}, "solve --method auto corrects"),
        ({"as_recorded": True}, "solve by default corrects"),
    ):
        found = solved(panda, moved[0], **options)
        told = [check.advice for check in found.document.checks if check.code == "moved"]
        assert told and words in told[0]


def drifted(placement):
    """The base turns steadily about the first joint, which moves the ball by some 2 mm."""
    q = placement.positions
    return changed(placement, q + 4e-3 * np.outer(np.arange(len(q)) / len(q), np.eye(7)[0]))


def test_a_held_out_placement_is_judged_with_its_drift(panda, placements, sound):
    document = solved(panda, placements[0], drifted(placements[1])).document
    told = next(check for check in document.checks if "drifted" in check.text)
    assert (told.code, told.where) == (
        "drift",
        "left",
    ) and "only the test used this placement" in told.advice
    steady, moved = (
        one.summary.test.calibrated.mean_absolute_error for one in (sound.document, document)
    )
    assert moved > 2 * steady


def test_a_drift_has_an_unknown_in_the_fit_where_samples_have_no_times(panda, placements):
    """Sockets in files of their own are in the order of the files."""
    rows = sorted(placements[0].samples, key=lambda sample: sample.socket)
    samples = tuple(replace(s, number=0, place=i) for i, s in enumerate(rows, start=1))
    front = drifted(replace(placements[0], samples=samples))
    found, kept = (solved(panda, front, placements[1], as_recorded=kept) for kept in (False, True))
    assert ["drifted" in text for text in differences(found)] == [True]
    sizes = [abs(calibration.document.scale.value) for calibration in (found, kept)]
    assert sizes[0] < 5e-3 < sizes[1]


def test_a_gain_has_an_unknown_in_the_fit(panda, true_panda, placements, sound):
    """A joint that reads 2 % too much is right once its position is corrected."""
    factor = 1 + 0.02 * np.eye(7)[3]
    read = [changed(placement, placement.positions * factor) for placement in placements]
    found = solved(panda, read)
    gains = found.document.deflection["gain"]
    assert gains == pytest.approx(1 / factor - 1, abs=2e-3)
    (told,) = [check for check in found.document.checks if check.code == "gain"]
    assert told.level == "warning" and "mukca command corrects" in told.advice
    q = placements[0].positions
    assert np.ptp(found.ball(q * factor) - balls_of(true_panda, q), axis=0).max() < 1.5e-3
    kept = solved(panda, read, as_recorded=True).document
    assert "gain" not in kept.deflection
    assert [check.level for check in kept.checks if check.code == "gain"] == ["error"]
    assert "gain" not in sound.document.deflection

"""Zeros of joints found with the calibrated chain held."""

import json
from dataclasses import replace

import numpy as np
import pytest
from altered import moved, write_samples

import mukca
from mukca import MukcaError

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("offsets", [{}, {3: 5e-3}, {1: -0.08, 4: 4e-3}])
def test_the_evidence_names_the_joints_whose_zeros_changed(simulated, offsets):
    found = mukca.rezero(simulated.calibration, simulated.read(offsets))
    assert [one.joint for one in found.changed] == [f"panda_joint{j + 1}" for j in offsets]
    assert repr(found).splitlines() == list(found.text)
    for zero, offset in zip(found.changed, offsets.values(), strict=True):
        assert abs(zero.offset - offset) < 4 * zero.standard_deviation < 2e-3


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rounded", [False, True])
def test_scatter_of_all_joints_is_no_zero(simulated, rounded, seed):
    """3 mrad of noise, or whole degrees: no joint is named, nor a zero written."""
    since = simulated.read({})
    q = since.positions
    noisy = q + 3e-3 * np.random.default_rng(seed).normal(size=q.shape)
    coarse = np.deg2rad(np.rad2deg(q + 1e-3 * seed).round())
    found = mukca.rezero(simulated.calibration, moved(since, coarse if rounded else noisy))
    assert not found.changed and not found.decided
    assert "All joints scatter alike" in " ".join(found.brief)


def test_a_zero_that_such_samples_cannot_tell_is_named_and_not_found(simulated):
    found = mukca.rezero(simulated.calibration, simulated.read({}), ["panda_joint1"])
    assert not found.changed
    assert "panda_joint1" in found.untold[0] and "--stood" in found.untold[0]


def test_another_arms_samples_and_too_few_are_refused(simulated):
    _, (other,) = mukca.simulate_recordings(mukca.load_robot("panda"), 1, seed=77, samples=8)
    for joints in ([], ["panda_joint4"]):
        with pytest.raises(MukcaError, match="another arm's calibration"):
            mukca.rezero(simulated.calibration, other, joints)
    since = simulated.read({3: 5e-3})
    mixed = np.random.default_rng(0).permuted(since.positions, axis=0)
    astray = mukca.Placement.of_arrays("astray", mixed, since.sockets)
    with pytest.raises(MukcaError, match="another arm's calibration"):
        mukca.rezero(simulated.calibration, astray)
    q = since.positions[[0, 1, 8, 9]]
    few = mukca.Placement.of_arrays("few", q, [0, 0, 1, 1], distance=0.05)
    with pytest.raises(MukcaError, match="4 samples for 7 zeros and 2 sockets"):
        mukca.rezero(simulated.calibration, few)
    q = since.positions[[0] * 12] + np.linspace(0, 1e-3, 12)[:, None]
    alike = mukca.Placement.of_arrays("alike", q, [0] * 6 + [1] * 6)
    assert not any(zero.told for zero in mukca.rezero(simulated.calibration, alike).joints)


def test_more_samples_are_not_asked_for_where_the_distance_is_another(simulated):
    """As of files that say none, where the base is not the paper's."""
    found = mukca.rezero(simulated.calibration, simulated.read({}), distance=0.1)
    assert not found.decided and not found.changed
    (line,) = (line for line in found.text if "No zeros explain it" in line)
    assert "is --distance right" in line
    assert not any("record more samples" in line for line in found.text)


def test_where_the_base_still_stands_one_socket_tells_the_first_joint(simulated):
    trained = simulated.calibration.document.data[0]
    q = np.array([s.position for s in trained.samples if s.socket == 0][:8])
    q[:, 0] -= 3e-3
    since = mukca.Placement.of_arrays("since", q, [0] * 8)
    found = mukca.rezero(simulated.calibration, since, stood=trained.name)
    assert [one.joint for one in found.changed] == ["panda_joint1"]
    assert found.changed[0].offset == pytest.approx(3e-3, abs=5e-4)


def test_a_calibration_with_new_zeros_fits_old_samples_and_new_ones(simulated, tmp_path):
    since, old = simulated.read({3: 5e-3}), simulated.calibration
    mukca.rezero(old, since).save(tmp_path / "new")
    new = mukca.load_calibration(tmp_path / "new")
    before, after = (c.validate(since).summary.test for c in (old, new))
    assert after.calibrated.mean_absolute_error < 0.2 * before.calibrated.mean_absolute_error
    # what it was trained on is kept in the new readings' terms, and is as right as before
    rows = np.array([s.position for s in new.document.data[0].samples])
    assert new.ball(rows) == pytest.approx(
        old.ball([s.position for s in old.document.data[0].samples]), abs=3e-4
    )
    assert not mukca.rezero(new, since).changed
    # recordings of before are known as what it was trained on, in the old readings, too
    first = old.document.data[0].placement(old.robot.joint_names)
    kept, then = new.validate(first), old.validate(first)
    assert kept.summary.train is not None and kept.summary.test is None
    assert kept[0].loaded.mean_absolute_error == pytest.approx(
        then[0].loaded.mean_absolute_error, abs=1e-4
    )
    assert any("before zeros changed" in one for one in mukca.what_changed(new, first).warnings)
    again = mukca.rezero(new, simulated.read({3: 8e-3}))
    assert again.changed[0].offset == pytest.approx(3e-3, abs=4e-4)


def test_zeros_of_a_servo_arm_that_was_never_calibrated():
    robot = mukca.load_robot("so101")
    small = {"translation": 1e-4, "rotation": 3e-4, "noise": 5e-5}
    _, (recorded,) = mukca.simulate_recordings(robot, 1, seed=1, samples=12, **small)
    q = recorded.positions
    q[:, 2] -= 0.03
    since = mukca.Placement.of_arrays("since", q, recorded.sockets, distance=0.05)
    found = mukca.rezero(robot, since, [robot.joint_names[2]])
    assert found.changed[0].offset == pytest.approx(0.03, abs=4e-3)
    assert found.urdf() != robot.text.data


def nominal(name, seed, rotation, offsets, samples=8):
    """Return a nominal robot, and samples of an arm that is off by so much, zeros lost beside."""
    robot = mukca.load_robot(name)
    errors = {"translation": 0.4 * rotation, "rotation": rotation}
    _, (recorded,) = mukca.simulate_recordings(robot, 1, seed=seed, samples=samples, **errors)
    q = recorded.positions
    for joint, offset in offsets.items():
        q[:, joint] -= offset
    return robot, mukca.Placement.of_arrays("since", q, recorded.sockets, distance=0.05)


@pytest.mark.parametrize(("name", "seed"), [("panda", 4), ("panda", 5), ("ur5e", 0), ("xarm6", 1)])
def test_a_model_that_is_off_shows_no_zeros_and_is_not_made_worse(name, seed):
    """Its lengths and angles explain the samples as well; the zeros' deviations say so."""
    robot, since = nominal(name, seed, 5e-3, {})
    found = mukca.rezero(robot, since)
    assert found.other and not found.changed
    assert max(zero.changed for zero in found.joints) < 0.5
    assert all(zero.standard_deviation > 4e-3 for zero in found.joints)
    assert any("nominal model's own errors look like" in line for line in found.text)
    assert not any("record more samples" in line for line in found.text)
    named = mukca.rezero(robot, since, [robot.joint_names[3]]).joints[3]
    assert abs(named.offset) < 3 * named.standard_deviation


@pytest.mark.parametrize("rotation", [3e-4, 1.5e-3])
def test_a_lost_zero_far_beyond_the_errors_of_a_model_is_named(rotation):
    offsets = {1: -0.05, 2: 0.03}
    found = mukca.rezero(*nominal("panda", 4, rotation, offsets))
    assert [zero.joint for zero in found.changed] == ["panda_joint2", "panda_joint3"]
    for zero, offset in zip(found.changed, offsets.values(), strict=True):
        assert abs(zero.offset - offset) < 3 * zero.standard_deviation < 1.2e-2
    assert found.other == (rotation > 1e-3)


def test_the_tour_of_a_model_that_is_off_ends_with_what_would_work(tmp_path, command):
    _, since = nominal("panda", 4, 5e-3, {}, samples=24)
    write_samples(tmp_path / "front", since)
    words = ("rezero", "panda", tmp_path / "front", "--distance", "0.05")
    status, out, _ = command(*words, "--out", tmp_path / "new")
    assert status == 3 and "No zero is shown" in out and "first by mukca solve" in out
    arm, model = mukca.load_robot(tmp_path / "new" / "calibrated.urdf"), mukca.load_robot("panda")
    assert arm.origins == pytest.approx(model.origins, abs=1e-12)


def test_the_command_says_and_writes_what_was_found(simulated, cal, tmp_path, command, refused):
    write_samples(tmp_path / "since", simulated.read({3: 5e-3}))
    words = ("rezero", cal, tmp_path / "since")
    status, out, _ = command(*words, "--json", "--out", tmp_path / "new")
    assert status == 0 and json.loads(out)["changed"] == ["panda_joint4"]
    assert (tmp_path / "new" / "calibrated.urdf").exists()
    status, out, _ = command(*words, "--joint", "panda_joint1")
    assert status == 3 and "cannot show the zero of panda_joint1" in out
    refused("--joint elbow: the joints are panda_joint1", *words, "--joint", "elbow")
    told = "is it another arm's calibration or model"
    refused(told, "rezero", "iiwa14", tmp_path / "since")
    refused("kitchen", *words, "--stood", "kitchen")


def test_a_few_free_numbers_of_a_calibrated_urdf_are_told_what_they_hold(simulated, tmp_path):
    outputs = simulated.calibration.save(tmp_path / "cal")
    free = {"free": ["panda_joint4.yaw"]}
    since = simulated.read({3: 5e-3})
    held = mukca.calibrate(mukca.load_robot(outputs["urdf"]), since, **free)
    assert any("mukca rezero" in line for line in held.document.warnings)
    nominal = mukca.calibrate(mukca.load_robot("panda"), since, **free)
    assert not any("mukca rezero" in line for line in nominal.document.warnings)


def test_samples_that_were_trained_on_are_not_counted_twice(simulated, tmp_path):
    cal = simulated.calibration
    first, since = cal.document.data[0], simulated.read({3: 5e-3})
    own = first.placement(cal.robot.joint_names)
    found, alone = (mukca.rezero(cal, data) for data in ([own, since], since))
    assert found.joints == alone.joints
    assert f"{own.name}: trained on, and left out" in found.text
    again = mukca.rezero(cal, own)
    assert not again.decided and not again.changed and "cannot show a later change" in again.text[0]
    with pytest.raises(MukcaError, match="no sample is new"):
        again.save(tmp_path / "new")


@pytest.mark.parametrize(("unchanged", "decided"), [(0.05, False), (0.17, False), (0.6, True)])
def test_below_even_odds_it_is_not_said_that_no_zero_changed(simulated, unchanged, decided):
    found = replace(mukca.rezero(simulated.calibration, simulated.read({})), unchanged=unchanged)
    assert found.decided == decided
    assert any("cannot show which" in line for line in found.text) != decided
    assert any("No zero changed" in line for line in found.text) == decided


def test_an_odd_sample_counts_as_the_tails_of_the_calibrations_errors_say(simulated, tmp_path):
    simulated.calibration.save(tmp_path / "cal")
    file = tmp_path / "cal" / "calibration.json"
    q = simulated.later.positions.copy()
    q[3, 1] += 1e-3
    odd = mukca.Placement.of_arrays("odd", q, simulated.later.sockets, distance=0.05)
    written, pulled = json.loads(file.read_text()), list[float]()
    for nu in (5.0, 60.0):
        for noise in written["posterior"]["noises"].values():
            noise[2] = nu
        file.write_text(json.dumps(written))
        calibration = mukca.load_calibration(file)
        without, found = (
            mukca.rezero(calibration, one, ["panda_joint2"]).joints[1].offset
            for one in (simulated.later, odd)
        )
        pulled.append(abs(found - without))
    assert pulled[0] < 0.8 * pulled[1]

"""What changed since a calibration, by the evidence."""

import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from altered import with_errors, write_samples
from msgspec import structs
from recorded import RIGID, write_sockets

import mukca
from mukca import Calibration
from mukca.recorder import Placement, Sample
from mukca.solver.diagnostics import inspect_all
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import turn, workspace


@pytest.mark.parametrize(("offsets", "likeliest"), [({}, "nothing"), ({3: 3e-3}, "panda_joint4")])
def test_nothing_and_a_joint_are_told_apart(simulated, offsets, likeliest):
    found = mukca.what_changed(simulated.calibration, simulated.read(offsets))
    assert found.likeliest == likeliest and found.probabilities[likeliest] > 0.6
    assert sum(found.probabilities.values()) == pytest.approx(1)
    assert found.verdict.exit_status == (1 if offsets else 0)
    assert repr(found) == "\n".join((found.text, *found.odds, *found.not_shown))


@pytest.mark.parametrize(("offset", "likeliest"), [(0.0, "nothing"), (3e-3, "panda_joint4")])
def test_measured_points_tell_the_joint_too(simulated, offset, likeliest):
    """Wherever the instrument stands, and its target sits; joint 1 turns as the instrument does."""
    arm = simulated.with_tip(simulated.truth.model.origins(simulated.truth.values)[-1, :3] + 4e-3)
    q, noise = workspace(arm, 24), np.random.default_rng(4).normal(0, 3e-5, (24, 3))
    balls = replace(simulated.truth, robot=arm, values=np.zeros(0), parameters=()).ball(q)
    y = (balls + noise) @ turn(np.array([0.3, 2.0, -0.4])) + 1.0
    names = arm.joint_names
    read = q - offset * np.eye(len(names))[3]
    rows = zip(read.tolist(), y.tolist(), strict=True)
    samples = [Sample(tuple(a), 0, point=tuple(b)) for a, b in rows]
    points = Placement("points", tuple(samples), names)
    found = mukca.what_changed(simulated.calibration, points)
    assert found.likeliest == likeliest and found.changed == (found.verdict.status == "fail")
    if offset:
        assert found.cause.offset == pytest.approx(offset, abs=2e-4)
        assert "mukca solve points --robot" in found.text and "--zeros" in found.text
    else:
        assert found.untold[0] == "panda_joint1" and "place of the instr" in found.not_shown[0]


def test_a_change_is_named_though_each_is_less_probable_than_none(simulated):
    found = mukca.what_changed(simulated.calibration, simulated.read({}))
    odds = {"nothing": 0.4, "panda_joint4": 0.35, "tool": 0.25}
    found = replace(found, probabilities=odds)
    assert found.changed and found.likeliest == "panda_joint4"


def test_joints_whose_change_would_not_show_are_named(simulated):
    """The first one's, unless the base stands where it stood; rezero names the same."""
    since = simulated.read({0: 5e-3})
    found = mukca.what_changed(simulated.calibration, since)
    names = [one.joint for one in mukca.rezero(simulated.calibration, since).joints if not one.told]
    assert found.likeliest == "nothing" and list(found.untold) == names and names[0].endswith("1")
    assert f"would not show in such samples: {names[0]}" in found.not_shown[0]
    other = mukca.what_changed(simulated.calibration, simulated.read({3: 3e-3}))
    assert other.not_shown == ()


def test_several_zeros_at_once_are_left_to_rezero(simulated):
    """Which finds them, while no single joint is named."""
    since = simulated.read({1: 4e-3, 5: -6e-3})
    found = mukca.what_changed(simulated.calibration, since)
    assert found.likeliest == "everything" and "mukca rezero says" in found.text
    assert len(mukca.rezero(simulated.calibration, since).changed) == 2


def test_a_tool_that_was_moved_is_told(simulated):
    arm = simulated.with_tip(simulated.truth.model.origins(simulated.truth.values)[-1, :3] + 4e-3)
    found = mukca.what_changed(simulated.calibration, simulated.recorded_by(arm))
    assert found.likeliest == "tool"
    assert "mukca tool" in found.text


@pytest.mark.parametrize(("j", "offset"), [(3, 2e-3), (5, 7e-4)], ids=["certain", "likely"])
def test_a_joint_that_moved_never_passes(simulated, j, offset):
    """Neither by a held-out error that was large already, nor within a wide limit."""
    old = simulated.calibration
    large = with_errors(old.validate(simulated.read({})).summary.test, 5e-3)
    summaries = structs.replace(old.document.summary, test=large)
    loose = Calibration(structs.replace(old.document, summary=summaries), old.calibrated, "")
    since, joint = simulated.read({j: offset}), f"panda_joint{j + 1}"
    for calibration, most in ((old, None), (loose, None), (loose, 1e-2)):
        found = mukca.what_changed(calibration, since, repeatability=most)
        assert found.verdict.exit_status == 1 and found.cause.joint == joint
        assert re.search(r"with \+0\.\d\d deg added to what it reads", found.cause.text(""))


@pytest.mark.slow
def test_an_arm_that_bends_is_judged_as_when_it_was_calibrated():
    """No rigid URDF keeps its limits, more placements or not; corrected joint positions do."""
    robot, bends = mukca.load_robot("panda"), {"compliance": 3e-4, "tilt": 1.5e-4}
    _, (*train, test, since) = mukca.simulate_recordings(robot, 4, seed=2, samples=16, **bends)
    calibration = mukca.calibrate(robot, train, test=[test])
    made = calibration.verdict
    assert (made.title, made.use) == ("BETTER", True)
    found = mukca.what_changed(calibration, since)
    assert found.likeliest == "nothing" and found.verdict.title == "BETTER"
    assert "only corrected joint positions keep its limits: mean held-out error" in found.text
    assert "mukca command" in found.text and "more placements" not in found.text
    assert found.verdict.exit_status == made.exit_status == 1
    moved = mukca.Placement.of_arrays(
        "moved", since.positions - 3e-3 * np.eye(7)[3], since.sockets, distance=0.05
    )
    moved = mukca.what_changed(calibration, moved)
    assert moved.verdict.title == "FAIL" and "mukca rezero" in moved.text


@pytest.mark.slow
def test_a_base_that_does_not_stand_where_it_stood_is_told(simulated):
    first, second = simulated.calibration.document.data[:2]
    q = np.array([s.position for s in second.samples])
    moved = mukca.Placement.of_arrays("moved", q, [s.socket for s in second.samples], distance=0.05)
    stays = mukca.what_changed(simulated.calibration, moved, stood=second.name)
    elsewhere = mukca.what_changed(simulated.calibration, moved, stood=first.name)
    assert stays.likeliest == "nothing"
    assert elsewhere.likeliest != "nothing"


@pytest.mark.slow
def test_the_command_says_what_to_do_next(simulated, cal, tmp_path, command, refused):
    write_samples(tmp_path / "since", simulated.read({3: 3e-3}))
    words = ("check", tmp_path / "since", "--calibration", cal)
    status, out, _ = command(*words)
    assert status == 1 and f"mukca rezero {cal} {tmp_path / 'since'} --joint panda_joint4" in out
    status, out, _ = command(*words, "--json")
    assert status == 1 and json.loads(out)["likeliest"] == "panda_joint4"
    by_check = command(*words)
    words = ("validate", cal, tmp_path / "since")
    assert command(*words) == by_check
    status, out, _ = command(*words, "--json", "--out", tmp_path / "page")
    assert status == 1
    said = json.loads(out)
    told = html.unescape((tmp_path / "page" / "report.html").read_text())
    assert said["outputs"]["report"].endswith("report.html")
    assert said["verdict"]["nearest_cause"]["offset"] == pytest.approx(3e-3, abs=5e-4)
    assert said["verdict"]["text"] in told
    assert 0 < told.index("= held out") < told.index("<summary>All numbers")
    # limits that are given excuse other changes, never a joint's
    assert command(*words, "--repeatability-mm", "9")[0] == 1
    refused("page: exists", *words, "--out", tmp_path / "page")
    refused("--robot", "check", tmp_path / "since")


def test_a_few_samples_say_nothing_of_an_old_calibration(simulated, cal, tmp_path, command):
    since = simulated.read({})
    few = mukca.Placement.of_arrays(
        "few", since.positions[[0, 1, -2, -1]], [0, 0, 1, 1], distance=since.distance
    )
    write_samples(tmp_path / "few", few)
    for words in (("validate", cal), ("check", "--calibration", cal)):
        status, out, _ = command(*words, tmp_path / "few")
        assert status == 3 and "too little" in out


def test_samples_that_suffice_to_check_are_not_called_few(simulated, cal, tmp_path, command):
    since = simulated.read({})
    rows = [*np.flatnonzero(since.sockets == 0)[:6], *np.flatnonzero(since.sockets == 1)[:6]]
    samples = tuple(since.samples[row] for row in rows)
    write_samples(tmp_path / "later", replace(since, samples=samples))
    status, out, err = command("validate", cal, tmp_path / "later")
    assert status != 3 and "are the least" not in out + err


def test_samples_that_were_trained_on_are_known_in_any_form(simulated, tmp_path, command):
    cal = simulated.calibration
    first = cal.document.data[0].placement(cal.robot.joint_names)
    write_samples(tmp_path / "first", first)
    status, _, error = command(
        "convert", tmp_path / "first", "--to", "holes", "--out", tmp_path / "holes"
    )
    assert status == 0, error
    (holes,) = mukca.read_placements(tmp_path / "holes")
    degrees = np.round(np.degrees(first.positions), 5)
    order = np.random.default_rng(0).permutation(len(degrees))
    mixed = mukca.Placement.of_arrays(
        "mixed", np.radians(degrees)[order], first.sockets[order], distance=0.05
    )
    for placement in (first, holes, mixed):
        assert [row.role for row in cal.validate(placement)] == ["train"]
    assert [row.role for row in cal.validate(simulated.read({}))] == ["test"]


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.01, 0.03, 0.07])
def test_a_wrong_distance_is_named(simulated, distance):
    found = mukca.what_changed(simulated.calibration, simulated.read({}), distance=distance)
    assert found.verdict.status == "fail" and "sockets' distance is off by" in found.text
    assert found.likeliest == "distance" and "set-distance" in found.text


@pytest.mark.slow
def test_a_calibration_whose_distance_nobody_measured_is_not_valid_yet(
    simulated, tmp_path, command
):
    old, since = simulated.calibration, simulated.read({})
    rows = [structs.replace(one, distance_source="default") for one in old.document.placements]
    settings = {**old.document.settings, "distance": None}
    document = structs.replace(old.document, placements=tuple(rows), settings=settings)
    Calibration(document, old.calibrated, old.source).save(tmp_path / "cal")
    pairs = since.positions, since.sockets
    write_samples(tmp_path / "told", since)
    write_samples(tmp_path / "untold", mukca.Placement.of_arrays("untold", *pairs))
    for words in (("validate", tmp_path / "cal"), ("check", "--calibration", tmp_path / "cal")):
        status, out, _ = command(*words, tmp_path / "untold")
        assert status == 3 and "obody measured the distance of the sockets" in out
        assert command(*words, tmp_path / "told")[0] == 0


@pytest.mark.slow
def test_a_zero_has_one_sign_wherever_it_is_told(simulated, panda):
    """That of what is to be added to the readings."""
    trained = [
        mukca.Placement.of_arrays(
            placement.name,
            [sample.position for sample in placement.samples],
            [sample.socket for sample in placement.samples],
            distance=0.05,
        )
        for placement in simulated.calibration.document.data
    ]
    since = simulated.read({3: 5e-3})
    survey = inspect_all(panda, [measure(p, panda) for p in (*trained, since)])
    by_check = next(h for h in survey.hypotheses if h.name == "zero_lost")
    by_validate = mukca.what_changed(simulated.calibration, since)
    (by_rezero,) = mukca.rezero(simulated.calibration, since).changed
    offsets = by_check.parameters["offset"], by_validate.cause.offset, by_rezero.offset
    assert offsets == pytest.approx([5e-3] * 3, abs=5e-4)
    for text in (by_check.text, by_validate.text, by_rezero.brief):
        assert "deg" in text and "to what it reads" in text and "+0.2" in text


@pytest.mark.slow
def test_samples_that_state_no_distance_are_of_the_calibrations_base(simulated, tmp_path, command):
    """A base of 100 mm: the zero is found as by a distance stated, and the command carries one."""
    robot = mukca.load_robot("panda")
    _, (*train, later) = mukca.simulate_recordings(robot, 3, distance=0.1, seed=6, samples=12)
    mukca.calibrate(robot, train, **RIGID).save(tmp_path / "cal")
    words = "--joint", "panda_joint4"
    shifted = later.with_positions(later.positions + 0.02 * (np.arange(7) == 3))
    write_sockets(tmp_path / "since", shifted)
    at = tmp_path / "cal", tmp_path / "since"
    status, out, err = command("rezero", *at, *words)
    assert status == 0 and "panda_joint4: add -0.0" in out
    assert "base is taken, 100 mm; for another base give --distance" in out + err
    status, out, _ = command("validate", *at)
    assert status == 1 and "rezero" in out and "--distance" not in out.split("rezero")[1]
    _, stated, _ = command("validate", *at, "--distance", 0.1)
    assert "--joint panda_joint4" in stated and "--distance 0.1" in stated.split("rezero")[1]

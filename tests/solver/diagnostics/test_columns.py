"""Signs, swaps and zeros of the columns are found, and never seen in a right recording."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cases import by_table

from mukca import MukcaError
from mukca.solver.calibration import reaching
from mukca.solver.diagnostics import inspect_all
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import load_robot
from mukca.tools.simulation import perturb, reachable_bases, record, simulate_recordings

pytestmark = pytest.mark.slow


def flipped(joint):
    return lambda q: np.where(np.arange(len(q)) == joint, -q, q)


@pytest.mark.parametrize(
    ("mistake", "code", "words"),
    [
        (
            flipped(1),
            "sign",
            "joint 2 (panda_joint2) looks sign-flipped: with the other sign the error falls",
        ),
        (flipped(6), "sign", "joint 7 (panda_joint7) looks sign-flipped"),
        (lambda q: q[[2, 1, 0, 3, 4, 5, 6]], "swap", "joints 1 and 3 (panda_joint1, panda_joint3)"),
        (lambda q: q + 0.35 * np.eye(7)[2], "zero", "joint 3 (panda_joint3) looks off: with -"),
    ],
)
def test_a_mistake_in_all_files_is_found(look, change, placements, mistake, code, words):
    seen = look([change(placement, mistake) for placement in placements])
    (finding,) = [f for f in seen.diagnostics if f.code == code]
    level = "warning" if code == "zero" else "error"  # the fit has zeros as unknowns
    assert (finding.level, finding.where) == (level, "all placements")
    assert words in finding.text, finding.text
    assert " -q" not in finding.text
    if code == "sign":
        joint = int(words.split()[1])
        column = ",".join(f"{'-' * (k == joint)}{k}" for k in range(1, 8))
        assert f"--columns 'q={column}'" in finding.advice


def within(robot, placements):
    """Measurements by the robot whose limits hold all readings."""
    wider = reaching(robot, np.concatenate([p.positions for p in placements]))
    return [measure(placement, wider) for placement in placements]


def lacking(joint, other, share):
    return lambda q: q - share * q[other] * np.eye(len(q))[joint]


@pytest.mark.parametrize(
    ("mistake", "code", "words"),
    [
        (lacking(2, 1, 1.0), "coupled", "with elbow_joint + shoulder_lift_joint for elbow_joint"),
        (lacking(2, 1, -1.0), "coupled", "with elbow_joint - shoulder_lift_joint for elbow_joint"),
        (lacking(2, 1, 0.5), "coupled", "with elbow_joint + 0.5 shoulder_lift_joint for elbow_"),
        (lacking(3, 4, 1.0), "coupled", "wrist_1_joint + wrist_2_joint for wrist_1_joint"),
        (
            lambda q: q / [1, 1, 6, 1, 1, 1],
            "ratio",
            "joint 3 (elbow_joint) looks wrongly geared: with 6 q",
        ),
        (lambda q: q[[1, 0, 2, 4, 3, 5]], "swap", "columns look out of order: 2, 1, 3, 5, 4, 6"),
        (lambda q: q[[1, 2, 0, 3, 4, 5]], "swap", "columns look out of order: 3, 1, 2, 4, 5, 6"),
        (lambda q: q * [1, -1, -1, -1, 1, 1], "sign", "joints 2 and 3 and 4 (shoulder_lift_joint"),
    ],
)
def test_what_several_joints_read_together_is_found(change, mistake, code, words):
    robot = load_robot("ur5e")
    generator = np.random.default_rng(4)
    arm = perturb(robot, generator, 1e-3, 3e-3)
    bases = reachable_bases(robot, generator, 2)
    data = [record(arm, base, generator, samples=20, noise=5e-5) for base in bases]
    measured = [measure(change(p, mistake), robot) for p in data]
    found = inspect_all(robot, measured)
    assert [f.code for f in found.shared] == [code] and words in found.shared[0].text
    assert found.shared[0].level == "error" and found.hypotheses[0].probability > 0.9


@pytest.mark.parametrize("name", ["ur3e", "ur5e"])
def test_half_a_coupling_is_found_whatever_whole_turns_the_other_joint_reads(change, name):
    robot = load_robot(name)
    _, recorded = simulate_recordings(robot, 2, seed=7, samples=22, distance=0.1)
    measured = [measure(change(p, lacking(2, 1, 0.5)), robot) for p in recorded]
    assert np.ptp(measured[0].positions[:, 1]) > 2
    (seen,) = inspect_all(robot, measured).shared
    assert "with elbow_joint + 0.5 shoulder_lift_joint for elbow_joint" in seen.text


def test_signs_are_told_from_those_of_the_mirrored_arm(panda, change):
    """And from these with the last joint's, by which the ball hardly moves."""
    _, recorded = simulate_recordings(panda, 2, seed=7, samples=22, distance=0.1)
    flip = [1, 1, 1, -1, 1, -1, 1]
    measured = within(panda, [change(p, lambda q: flip * q) for p in recorded])
    (seen,) = inspect_all(panda, measured).shared
    assert (
        "joints 4 and 6 (panda_joint4, panda_joint6) look sign-flipped: with the other sign"
        in seen.text
    )


@pytest.mark.parametrize(
    ("factors", "offsets", "words"),
    [
        (
            (1, -1, -1, -1, 1),
            (0, 1, -1, 0, 0),
            "2 and 3 and 4 .* look sign-flipped and joints 2 and",
        ),
        (
            (1, -1, -1, 1, 1),
            (0, 1, 0, 0, 0),
            "2 and 3 .* look sign-flipped and joint 2 .* looks off",
        ),
        ((1, 1, 1, 1, 1), (0, 1, -1, 0, 0), "2 and 3 .* look off: with -(89|90)"),
        (
            (1, -1, -1, -0.5, 1),
            (0, 0, 0, 0, 0),
            "2 and 3 and 4 .* joint 4 .* geared: with the other sign and 2 q",
        ),
    ],
)
def test_quarter_turns_and_ratios_beside_signs_are_named(change, factors, offsets, words):
    """As other calibration formats of servo arms have them."""
    robot = load_robot("so101")
    _, recorded = simulate_recordings(robot, 2, seed=7, samples=22, distance=0.1)
    off = np.pi / 2 * np.array(offsets)
    measured = within(robot, [change(p, lambda q: q * factors + off) for p in recorded])
    (seen,) = inspect_all(robot, measured).shared
    assert re.search(words, seen.text), seen.text


@pytest.mark.parametrize(
    ("name", "ratio"), [("ur5e", 1.0), ("so101", 1.0), ("so101", 1.1), ("so101", 2.0)]
)
def test_signs_an_exchanged_pair_and_a_gain_at_once_are_each_named(change, name, ratio):
    robot = load_robot(name)
    _, recorded = simulate_recordings(robot, 2, seed=1, samples=20, distance=0.1)
    factors = np.ones(len(robot.joint_names))
    factors[1:4] = -1.0, -1.0, -ratio
    order = np.arange(len(factors))
    order[1:3] = 2, 1
    measured = within(robot, [change(p, lambda q: (factors * q)[order]) for p in recorded])
    (seen,) = inspect_all(robot, measured).shared
    assert "joints 2 and 3 and 4 " in seen.text and "look sign-flipped" in seen.text
    assert "look swapped" in seen.text and "their columns put right the error falls" in seen.text
    assert bool(re.search(r"and 0\.[59]\d* q and", seen.text)) == (ratio != 1)


def test_a_mistake_in_one_placement_is_found_there(look, change, placements):
    """Also of the last joint: the ball hardly moves, and the model's own errors hide the sign."""
    seen = look([placements[0], change(placements[1], flipped(4)), placements[2]])
    (finding,) = seen.diagnostics
    assert finding.code == "sign" and finding in seen.placements[1].diagnostics
    for joint in (4, 6):
        seen = look([placements[0], change(placements[1], flipped(joint))])
        assert [f.code for f in seen.placements[1].diagnostics] == ["sign"]
        assert seen.placements[0].sound and not seen.shared
        assert f"joint {joint + 1} (panda_joint{joint + 1})" in seen.hypotheses[0].text


def test_what_no_single_mistake_explains_is_told(look, change, placements):
    generator = np.random.default_rng(0)
    wild = [change(p, lambda q: q + generator.normal(0, 0.2, 7)) for p in placements]
    (finding,) = [f for f in look(wild).diagnostics if f.level == "error"]
    assert finding.code == "model" and "does --robot name this arm" in finding.advice
    assert "unit" not in finding.advice


def test_angles_that_were_converted_twice_are_asked_for_their_unit(look, change, placements):
    twice = [change(placement, np.deg2rad) for placement in placements]
    advice = [f.advice for f in look(twice).diagnostics if f.level == "error"]
    assert advice and "are the angles in another unit?" in advice[0]


def test_a_sign_that_leaves_the_limits_is_told(look, change, placements):
    with pytest.raises(MukcaError, match=r"panda_joint4.*is it sign-flipped\? .* q=1..3,-4,5..7"):
        look([change(placement, flipped(3)) for placement in placements])


def test_a_few_samples_accuse_no_joint(look, panda):
    """Three in each socket can be explained by almost anything, here by another last sign."""
    _, (whole,) = simulate_recordings(panda, 1, samples=20, seed=3)
    few = replace(whole, samples=(*whole.samples[:3], *whole.samples[20:23]))
    assert [(f.level, f.code) for f in look([few]).diagnostics] == [("warning", "few")] * 2


@pytest.mark.parametrize("name", ["iiwa14", "ur5e", "gen3_lite"])
def test_only_a_flipped_last_joint_looks_flipped(name, change):
    """Its ball is near its axis, so it sees the mistake weakly."""
    robot = load_robot(name)
    generator = np.random.default_rng(5)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    last = len(robot.actuated) - 1
    data = [
        record(arm, base, generator, samples=20, noise=1e-4)
        for base in reachable_bases(robot, generator, 2)
    ]
    for placements, codes in ((data, []), ([change(p, flipped(last)) for p in data], ["sign"])):
        measured = [measure(p, robot) for p in placements]
        found = inspect_all(robot, measured).diagnostics
        assert [f.code for f in found] == codes


@by_table("order", "signs", "offsets", "code", "words")
def test_two_mistakes_are_told_together(
    look, placements, change, order, signs, offsets, code, words
):
    """And before the distance: two offsets make the arm come out too large."""
    off = change(placements[0], lambda q: ((q + offsets) * signs)[order])
    (found,) = [d for d in look([off]).diagnostics if d.code == code]
    assert found.level == ("warning" if code == "zero" else "error")
    assert words in found.text and found.text.count("added to what") == 1, found.text

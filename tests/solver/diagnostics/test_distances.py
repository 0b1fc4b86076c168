"""A wrong distance between the sockets is found before any fit believes it."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cases import by_table
from recorded import recorded_by_servos

from mukca.solver.assessment import Recordings, recording_rows
from mukca.solver.design import accuracy_by
from mukca.solver.diagnostics import inspect_all
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import load_robot
from mukca.tools.simulation import perturb, reachable_bases, record

pytestmark = pytest.mark.slow


@by_table("given", "status", "words")
def test_a_wrong_distance_is_found(panda, placements, given, status, words):
    """By the size of a fit alone; what explains it says the distance, and no size of its own."""
    measured = [measure(p, panda, given) for p in placements]
    (accuracy, survey) = (f(panda, measured) for f in (accuracy_by, inspect_all))
    recordings = Recordings(measured, scale=accuracy.scale)
    rows = {row.name: row for row in recording_rows(survey.diagnostics, recordings)}
    assert abs(accuracy.scale.value - (given / 0.05 - 1)) < 4 * accuracy.scale.deviation
    assert rows["scale"].status == status and words in rows["scale"].text
    assert rows["data_checks"].status == "pass"
    for finding in survey.diagnostics:
        assert (finding.level, finding.where) == ("warning", "all placements")
        assert f"the sockets are more likely 50.0 mm apart than {1e3 * given:.1f}" in finding.text
        assert "as you gave it" in finding.advice and "--distance" in finding.advice


def test_samples_that_any_model_fits_accuse_no_placement(look, placements):
    """Of three in each socket the fit leaves nothing but rounding."""
    few = [replace(p, samples=(*p.samples[:3], *p.samples[20:23])) for p in placements]
    assert not [f for one in look(few).placements for f in one.diagnostics if f.level == "error"]


def test_a_forgotten_distance_is_found(look, record_at):
    long = record_at([0.5, 0.0, 0.1], 3, distance=0.12)
    assert look([long]).diagnostics == ()
    (finding,) = look([replace(long, distance=None)]).diagnostics
    assert re.search("the sockets are more likely (119.9|120.0) mm apart", finding.text)
    assert "nothing but the default" in finding.advice


def test_a_base_that_moved_between_its_sockets_is_no_wrong_scale(look, record_at, placements):
    after = record_at([0.5, 0.3, 0.1], 3)
    samples = (*placements[0].samples[:20], *after.samples[20:])
    for others in (placements[1:], placements[1:2]):
        seen = look([replace(placements[0], samples=samples), *others])
        (finding,) = seen.diagnostics
        assert finding.code == "distance" and finding in seen.placements[0].diagnostics
    assert (
        "350." in finding.text
        and "mm apart by the model and the other recordings, not 50.0" in finding.text
    )


def test_both_sockets_recorded_in_one_are_told(look, record_at, placements):
    again = record_at([0.5, 0.0, 0.1], 4)
    twice = [replace(s, socket=1) for s in again.samples[:20]]
    samples = (*placements[0].samples[:20], *twice)
    for others in ([], placements[1:]):
        codes = [
            f.code for f in look([replace(placements[0], samples=samples), *others]).diagnostics
        ]
        assert codes == ["one-socket"]


@pytest.mark.parametrize(("name", "joint"), [("panda", 3), ("panda", 5), ("so101", 2)])
def test_a_zero_that_changes_the_size_is_no_wrong_distance(name, joint, change):
    """The distance alone is never the cause of errors that a zero takes away."""
    robot, generator = load_robot(name), np.random.default_rng(5)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    (base,) = reachable_bases(robot, generator, 1)
    sound = record(arm, base, generator, samples=20, noise=1e-4)
    off = change(sound, lambda q: q + 0.1 * (np.arange(len(q)) == joint))

    def seen(placement, distance=None):
        measured = measure(placement, robot, distance)
        return list(inspect_all(robot, [measured]).shared)

    for distance, codes in ((None, {"zero"}), (0.055, {"zero", "scale"})):
        assert {finding.code for finding in seen(off, distance)} == codes
    (finding,) = seen(off)
    assert (finding.level, finding.code) == ("warning", "zero")
    assert f"joint {joint + 1} " in finding.text or robot.joint_names[joint] in finding.text
    found = re.search(r" -(\d+\.?\d*) deg .*to what it reads", finding.text)
    assert found is not None and abs(float(found[1]) - np.degrees(0.1)) < 0.5
    assert [finding.code for finding in seen(sound, 0.055)] == ["scale"]


@pytest.mark.parametrize("distance", [None, 0.055])
def test_servos_zeros_and_play_are_no_mistake_and_hide_none(distance):
    """With zeros off by degrees, which are sought, only a wrong distance is told."""
    robot, (placement,) = recorded_by_servos("koch", 0, 1)
    measured = measure(placement, robot, distance)
    seen = inspect_all(robot, [measured], zeros=True)
    assert [f.code for f in seen.diagnostics] == ([] if distance is None else ["scale"])
    true, size = 0.0 if distance is None else 0.1, accuracy_by(robot, [measured], zeros=True).scale
    assert abs(size.value - true) < 3 * size.deviation < 0.06


@pytest.mark.parametrize("count", [2, 3])
def test_the_recording_whose_distance_is_out_of_line_is_named(look, placements, count):
    wrong = [placements[0], replace(placements[1], distance=0.0508), *placements[2:count]]
    seen = look(wrong)
    (finding,) = seen.diagnostics
    assert finding.code == "distance" and finding in seen.placements[1].diagnostics
    assert "50.0 mm apart by the model and the other recordings, not 50.8" in finding.text
    assert "as placement.json has it" in finding.advice
    assert look([replace(placements[0], distance=0.0502), placements[1]]).diagnostics == ()

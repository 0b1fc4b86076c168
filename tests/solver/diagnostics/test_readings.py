"""Joints that read wrongly in ways of their own: uneven, stuck; and postures that repeat."""

from dataclasses import replace

import numpy as np
import pytest
from altered import moved

import mukca
from mukca.solver.diagnostics import inspect_all
from mukca.solver.identification.data import STANDARD_LOAD, measure


def test_a_joint_that_turns_unevenly_is_told(look, placements, change):
    def uneven(q):
        return q + 8e-3 * np.sin(q + 1.0) * np.eye(7)[3]

    first = look([change(p, uneven) for p in placements]).hypotheses[0]
    assert first.name == "uneven"
    assert "panda_joint4 turns unevenly" in first.text and "once a turn" in first.text


def commanded(robot, placements, size):
    """Return placements with what joints that sag were told, which encoders do not see."""
    recorded: list[mukca.Placement] = []
    for placement in placements:
        torques = STANDARD_LOAD.samples(robot, measure(placement, robot, 0.1)).torques
        sag = torques / np.sqrt(np.mean(torques**2, axis=0)).max()
        recorded.append(moved(placement, placement.positions + size * sag))
    return recorded


def test_commands_of_servos_that_sag_are_told(look, placements, panda):
    survey = look(commanded(panda, placements, 0.017))
    first = survey.hypotheses[0]
    assert first.name == "commands" and first.probability > 0.9
    assert first.parameters["size"] == pytest.approx(0.017, rel=0.1)
    assert look(placements).hypotheses[0].name == "sound"


@pytest.mark.parametrize("seed", [1, 3])
def test_commands_are_told_where_zeros_are_off_by_degrees_too(seed):
    robot = mukca.load_robot("so101")
    options = {"seed": seed, "samples": 20, "distance": 0.1, "zeros": 0.03, "play": 2e-3}
    _, placements = mukca.simulate_recordings(robot, 2, **options)

    def causes_of(recorded):
        return inspect_all(robot, [measure(p, robot, 0.1) for p in recorded], zeros=True).causes

    assert causes_of(commanded(robot, placements, 0.035)) == ("commands",)
    assert causes_of(placements) == ()


def test_a_joint_that_is_stuck_is_told_and_one_that_stood_still_is_not(look, placements, change):
    held = placements[0].positions[10, 2]

    def stuck(q):
        q[2] = held
        return q

    (front, *others) = placements
    survey = look([change(front, stuck, slice(10, None)), *others])
    first = survey.hypotheses[0]
    assert first.name == "stuck" and survey.causes == ("stuck",)
    assert first.parameters["joint"] == "panda_joint3" and first.parameters["samples"] == 30
    assert look([change(p, stuck) for p in placements]).hypotheses[0].name == "stuck"


def test_postures_that_repeat_are_told(look, placements, change):
    (front, *others), generator = placements, np.random.default_rng(1)
    by_socket = [[s for s in front.samples if s.socket == k] for k in (0, 1)]
    few = [*by_socket[0][:4], *by_socket[1][:4]]
    again = replace(front, samples=tuple(few * 5))
    again = change(again, lambda q: q + 1e-4 * generator.normal(size=7))
    survey = look([again, *others])
    assert survey.hypotheses[0].name == "repeated"
    assert "its 40 samples are in only 8 postures" in survey.hypotheses[0].text
    assert look(placements).hypotheses[0].name == "sound"

"""Joints that read wrongly in ways of their own: uneven, stuck; and postures that repeat."""

from dataclasses import replace

import numpy as np
import pytest
from altered import moved

import mukca
from mukca.solver.identification.data import STANDARD_LOAD, measure


def test_a_joint_that_turns_unevenly_is_told(look, placements, change):
    def uneven(q):
        return q + 8e-3 * np.sin(q + 1.0) * np.eye(7)[3]

    first = look([change(p, uneven) for p in placements]).hypotheses[0]
    assert first.name == "uneven"
    assert "panda_joint4 turns unevenly" in first.text and "once a turn" in first.text


def test_commands_of_servos_that_sag_are_told(look, placements, panda):
    """Encoders see the sag, a file of goals does not."""
    recorded: list[mukca.Placement] = []
    for placement in placements:
        torques = STANDARD_LOAD.samples(panda, measure(placement, panda, 0.1)).torques
        sag = torques / np.sqrt(np.mean(torques**2, axis=0)).max()
        recorded.append(moved(placement, placement.positions + 0.017 * sag))
    survey = look(recorded)
    first = survey.hypotheses[0]
    assert first.name == "commands" and first.probability > 0.9
    assert first.parameters["size"] == pytest.approx(0.017, rel=0.1)
    assert look(placements).hypotheses[0].name == "sound"


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

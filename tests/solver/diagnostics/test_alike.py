"""Causes that the samples cannot tell apart are both named, and bending is no wrong gear ratio."""

from dataclasses import replace

import numpy as np
import pytest
from worlds import realistic_flaws

from mukca.solver.diagnostics import cause, inspect_all
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import load_robot, rotation
from mukca.tools.simulation import Base, perturb, reachable_bases, record

pytestmark = pytest.mark.slow


def test_a_base_that_moved_about_the_first_joint_is_named_beside_its_zero(
    look, record_at, placements, true_panda
):
    turn = np.array(rotation((0, 0, 1), np.deg2rad(0.5)))
    centre, along = np.array([0.5, 0.0, 0.1]), np.array([0.0, 1.0, 0.0])
    moved = Base("front", turn @ centre, turn @ along)
    after = record(true_panda, moved, np.random.default_rng(1), samples=20, noise=1e-4)
    odd = [i for i, s in enumerate(after.samples) if s.socket == 1][8:]
    samples = [after.samples[i] if i in odd else s for i, s in enumerate(placements[0].samples)]
    seen = look([replace(placements[0], samples=tuple(samples)), *placements[1:]])
    alike = {h.name: h.fits_as_well for h in seen.hypotheses}
    first, other = list(alike)[:2]
    assert {first, other} == {"zero_lost", "base_moved"} and alike[other]
    words = cause(seen.hypotheses)
    assert "panda_joint1 is off" in words and "base moved" in words


def test_a_model_without_masses_blames_no_gear_ratio_for_an_arm_that_bends():
    robot = load_robot("iiwa14")
    generator = np.random.default_rng([2, 7])
    arm = perturb(robot, generator, 1e-3, 5e-3)
    flaws = realistic_flaws(robot, generator)
    bases = reachable_bases(arm, generator, 2, 0.1)
    data = [measure(record(arm, base, generator, imperfection=flaws), robot) for base in bases]
    (first, *_) = inspect_all(replace(robot, bodies=()), data).hypotheses
    assert first.name == "sound"

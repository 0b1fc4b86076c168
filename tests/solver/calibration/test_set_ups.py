"""Frame and target of an instrument, set up anew for each placement."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_arm import pose_at, with_ball
from recorded import RIGID
from worlds import measured_points

import mukca
from mukca.solver.calibration.poses import quaternion_of
from mukca.solver.identification.robot import BallModel, turn

NOISE, TURN_NOISE = 3e-5, 2e-4
EXPECTED = 1.6 * NOISE  # [m], the mean length of such a vector
DAYS = 3


def set_up(arm, day, generator, offset, turned=None):
    """Points of one day, in a frame and of a target of that day; poses where it is turned."""
    moved = with_ball(arm, arm.origins[-1, :3] + offset)
    frame = pose_at(generator.uniform(-2, 2, 3), np.array([2.0, 0.3 * day, 0.5]))
    points = measured_points(moved, frame, generator, samples=40, noise=NOISE)
    placement = replace(points, name=f"day{day}")
    if turned is None:
        return placement
    R = BallModel(moved, []).rotations(np.empty(0), points.positions).points
    shaken = turn(TURN_NOISE * generator.normal(size=(40, 3)))
    quaternions = quaternion_of(frame.rotation.T @ R @ turn(turned) @ shaken)
    samples = tuple(
        replace(sample, orientation=tuple(row))
        for sample, row in zip(points.samples, quaternions.tolist(), strict=True)
    )
    return replace(placement, samples=samples, poses_of="flange")


def errors(calibration):
    return [row.calibrated.mean_absolute_error for row in calibration.errors]


@pytest.mark.parametrize("size", [1e-3, 2e-2])
def test_each_day_has_its_frame_and_target(true_panda, panda, size):
    """Nothing is said of a target that sits elsewhere: that is how instruments are used."""
    generator = np.random.default_rng(3)
    *days, later = (
        set_up(true_panda, day, generator, size * generator.normal(size=3))
        for day in range(DAYS + 1)
    )
    found = mukca.calibrate(panda, days, later, **RIGID)
    assert max(errors(found)) < 2 * EXPECTED
    assert not found.document.checks
    assert mukca.what_changed(found, later).verdict.status == "pass"


def test_a_target_turned_by_half_a_turn_is_turned_back(true_panda, panda):
    generator = np.random.default_rng(4)
    half = np.array([0.0, 0.0, np.pi])
    turns = [np.zeros(3), half + 0.01, np.full(3, 0.01), half]
    *days, later = (
        set_up(true_panda, day, generator, 1e-3 * generator.normal(size=3), turned)
        for day, turned in enumerate(turns)
    )
    found = mukca.calibrate(panda, days, later, **RIGID)
    assert max(errors(found)) < 2 * EXPECTED
    angles = [row.calibrated.orientation_error for row in found.errors]
    assert max(angles) < 4 * TURN_NOISE
    assert ["turned by" in line for line in found.document.warnings] == [True]
    (row,) = mukca.what_changed(found, later).errors
    assert row.calibrated.orientation_error < 4 * TURN_NOISE


def test_the_same_plan_measured_again_is_no_copy(true_panda, panda):
    generator = np.random.default_rng(5)
    first = set_up(true_panda, 0, generator, np.zeros(3))
    again = set_up(true_panda, 1, generator, np.zeros(3))
    found = mukca.calibrate(panda, first, **RIGID)
    planned = again.with_positions(first.positions)
    (row,) = found.validate(planned)
    assert row.role == "test"
    (row,) = found.validate(first)
    assert row.role == "train"

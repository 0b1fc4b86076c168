"""Arms made of servos: joint offsets of degrees, and backlash in the gears."""

from dataclasses import replace

import numpy as np
import pytest
from altered import coefficients, moved, seats, with_efforts, write_samples

import mukca
from mukca.solver.identification.effects import EXTENSIONS
from mukca.tools.cli import main

pytestmark = pytest.mark.slow

OFFSETS = np.radians([3.0, -4.0, 5.0, -2.0, 0.0])
DECIDED = np.radians(0.2)


@pytest.fixture(scope="module")
def robot():
    return mukca.load_robot("so101")


@pytest.fixture(scope="module")
def recorded(robot, tmp_path_factory):
    """An arm as nominal, but that it stands at q + offset where it reads q; a base measured."""
    truth, (placement,) = mukca.simulate_recordings(
        robot, 1, samples=14, seed=0, translation=0, rotation=0, noise=1e-4, distance=0.15
    )
    rows = ["frame,socket,x [mm],y [mm],z [mm],deviation [mm]"]
    for k, place in enumerate(1e3 * seats(truth, placement)):
        rows.append(f"base,{placement.name}:{k},{','.join(f'{v:.4f}' for v in place)},0.1")
    at = tmp_path_factory.mktemp("servo") / "at.csv"
    at.write_text("\n".join(rows))
    return moved(placement, placement.positions - OFFSETS), at


@pytest.fixture(scope="module")
def found(robot, recorded):
    placement, at = recorded
    return mukca.calibrate(robot, placement, zeros=True, sockets_at=at, without=[*EXTENSIONS])


def test_joint_offsets_are_found_make_no_arm_longer_and_stand_in_the_urdf(found, recorded):
    values, deviations = coefficients(found, "zero")
    error = np.degrees(values - OFFSETS)
    assert np.abs(error[:4]).max() < 0.3
    assert np.degrees(deviations[:4]).max() < 0.2
    assert np.degrees(deviations[4]) > 2.5, "the roll's offset is told only by where the ball is"
    (line,) = found.document.choices or ()
    assert line.startswith("joint offsets: shoulder_pan +")
    assert "wrist_roll" in line.rpartition(", ")[2] and line.endswith("(not decided)")
    scale = found.document.scale
    assert abs(scale.value) < 2e-3 and scale.deviation < 5e-3
    q, calibrated = recorded[0].positions, found.calibrated
    assert found.document.deflection == {} and calibrated.exported is None
    assert calibrated.geometric_ball(q) == pytest.approx(calibrated.ball(q))


def test_backlash_is_found_and_widens_what_is_said_of_offsets(robot, recorded):
    """0.7 degrees of play; measured efforts say on which side each joint rests."""
    placement, at = recorded
    generator, half = np.random.default_rng(0), np.radians(0.35)
    efforts = generator.choice([-1.0, 1.0], placement.positions.shape)
    efforts[:, 2] = 1.0  # an elbow always hangs on one side
    idle = generator.random(efforts.shape) < 0.3
    idle[:, 2] = False
    rest = np.where(idle, generator.uniform(-1, 1, efforts.shape), efforts)
    efforts = np.where(idle, 0.0, efforts)
    read = with_efforts(moved(placement, placement.positions + half * rest), efforts)
    without = [name for name in EXTENSIONS if name != "play"]
    found = mukca.calibrate(robot, read, zeros=True, sockets_at=at, without=without)
    assert found.document.deflection.keys() == {"play"}
    assert np.degrees(found.document.deflection["play"][2]) == pytest.approx(0.35, abs=0.15)
    values, deviations = coefficients(found, "zero")
    error = (values - OFFSETS)[:4]
    assert np.abs(error / deviations[:4]).max() < 3
    assert np.degrees(np.abs(error[deviations[:4] < DECIDED])).max(initial=0) < 0.4


def test_check_knows_of_offsets_as_solve_does(recorded, tmp_path, capsys):
    """Readings off by degrees are an error, unless offsets may be."""
    for name, first in (("a", 0), ("b", 1)):
        every_other = replace(recorded[0], samples=recorded[0].samples[first::2])
        write_samples(tmp_path / name, every_other)
    words = [str(tmp_path), "--robot", "so101", "--distance", "0.15"]
    told = []
    for zeros in ([], ["--zeros"]):
        main(["check", *words, *zeros])
        told.append(capsys.readouterr().out.split("calibrat", 1)[-1])
    assert told[0] != told[1]

"""Known places: sockets in a table's frame or the base, points that an instrument measured."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from altered import seats
from cases import by_table
from imagined import turned as turned_about

import mukca

pytestmark = pytest.mark.slow

WITHOUT = ["compliance", "tilt", "transmission", "joint-noise"]
ROTATION = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
ROTATION *= np.linalg.det(ROTATION)
ORIGIN = np.array([0.3, -0.8, 0.4])


def in_frame(points):
    """Points of the base frame, seen from a table or an instrument."""
    return (points - ORIGIN) @ ROTATION


def write_at(file, frame, places, deviation):
    rows = ["frame,socket,x [m],y [m],z [m],deviation [m]"]
    for name, own in places.items():
        for k, place in enumerate(own):
            rows.append(f"{frame},{name}:{k},{','.join(map(repr, place.tolist()))},{deviation}")
    file.write_text("\n".join(rows))
    return file


@pytest.fixture(scope="module")
def noisy(panda):
    truth, placements = mukca.simulate_recordings(panda, 3, samples=12, seed=4)
    return truth, [replace(p, distance=None) for p in placements]


def as_points(truth, positions, noise=0.0):
    """Points that an instrument measured in its own frame."""
    _, (template,) = mukca.simulate_recordings(truth.robot, 1, samples=2)
    points = in_frame(truth.ball(positions))
    points = points + np.random.default_rng(1).normal(0, 1, points.shape) * noise
    samples = tuple(
        replace(template.samples[0], socket=0, position=tuple(q), point=tuple(p))
        for q, p in zip(positions.tolist(), points.tolist(), strict=True)
    )
    return replace(template, name="points", samples=samples, distance=None)


def poses(robot, count, seed=0):
    lower = np.array([max(joint.lower, -3) for joint in robot.actuated])
    upper = np.array([min(joint.upper, 3) for joint in robot.actuated])
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


@pytest.mark.parametrize("name", ["panda", "ur3e"])
def test_exact_sockets_on_a_table_give_every_place_back(name, tmp_path):
    """Where the ball is in the table's frame, at sockets held out, to a nanometre."""
    robot = mukca.load_robot(name)
    truth, (*train, held) = mukca.simulate_recordings(robot, 5, samples=10, seed=1, noise=0)
    places = {p.name: in_frame(seats(truth, p)) for p in train}
    at = write_at(tmp_path / "at.csv", "table", places, 1e-8)
    train = [replace(p, distance=None) for p in train]
    found = mukca.calibrate(robot, train, sockets_at=at, without=WITHOUT)
    q = held.positions
    true, seen = truth.ball(q), found.ball(q)
    (frame,) = found.document.frames
    turn, origin = turned_about(*frame.rpy)[:3, :3], np.array(frame.xyz)
    assert np.abs((seen - origin) @ turn - in_frame(true)).max() < 1e-8


def test_an_anchored_base_is_known_within_its_interval(panda, noisy, tmp_path):
    """The base's pose and joint 1's offset: where the ball is in the base frame."""
    truth, placements = noisy
    places = {p.name: seats(truth, p) for p in placements}
    at = write_at(tmp_path / "at.csv", "base", places, 5e-5)
    tied = mukca.calibrate(panda, placements, sockets_at=at, without=WITHOUT)
    free = mukca.calibrate(panda, placements, distance=0.05, without=WITHOUT)
    unseen = [f.document.uncertainty.cannot_see for f in (free, tied) if f.document.uncertainty]
    assert "the base frame" in unseen[0][0] and unseen[1] == unseen[0][1:]
    q = poses(panda, 40)
    off = np.linalg.norm(tied.ball(q) - truth.ball(q), axis=1)
    assert np.median(off) < 1e-3  # without the anchor some millimetres

    def yaw(found):
        (row,) = [p for p in found.document.parameters if p.name == "panda_joint1.yaw"]
        return row.standard_deviation or 0.0

    assert yaw(tied) < yaw(free)


def test_coordinates_in_the_wrong_base_frame_are_refused(panda, noisy, tmp_path):
    truth, placements = noisy
    places = {p.name: seats(truth, p) for p in placements}
    turned = {name: own[:, [1, 0, 2]] * [-1, 1, 1] for name, own in places.items()}
    large = {name: 1e3 * own for name, own in places.items()}
    for wrong, words in ((turned, "origin and axes as the URDF's base"), (large, "millimetres")):
        at = write_at(tmp_path / "at.csv", "base", wrong, 5e-5)
        with pytest.raises(mukca.MukcaError, match=words):
            mukca.calibrate(panda, placements, sockets_at=at, without=WITHOUT)


def test_two_sockets_in_the_base_leave_it_a_turn(panda, noisy, tmp_path):
    truth, placements = noisy
    at = write_at(
        tmp_path / "at.csv", "base", {placements[0].name: seats(truth, placements[0])}, 5e-5
    )
    found = mukca.calibrate(panda, placements, distance=0.05, sockets_at=at, without=WITHOUT)
    assert "can still turn" in found.document.uncertainty.cannot_see[0]


@pytest.mark.parametrize("name", ["so101", "ur5", "iiwa14"])
def test_exact_points_give_the_arm_and_the_frame_back(name):
    """All distances, and where the tool is in the instrument's frame, to a nanometre."""
    robot = mukca.load_robot(name)
    truth, _ = mukca.simulate_recordings(robot, 1, samples=2, seed=1)
    found = mukca.calibrate(robot, as_points(truth, poses(robot, 40)), without=WITHOUT)
    q = poses(robot, 50, 5)
    (frame,) = found.document.frames
    seen = (found.ball(q) - np.array(frame.xyz)) @ turned_about(*frame.rpy)[:3, :3]
    assert np.abs(seen - in_frame(truth.ball(q))).max() < 1e-8


def test_sockets_and_points_together_know_each_its_own_noise(panda):
    truth, (seated,) = mukca.simulate_recordings(panda, 1, samples=12, seed=4, noise=5e-5)
    points = as_points(truth, poses(panda, 30), 2e-5)
    held = replace(as_points(truth, poses(panda, 60, 9)), name="held out")

    def fit(*train):
        found = mukca.calibrate(panda, train, test=held, without=WITHOUT)
        return found, found.errors.summary.test.calibrated.max_error

    found, error = fit(seated, points)
    noise = found.document.noise
    assert noise.space == pytest.approx(5e-5, rel=0.4)
    assert noise.measured_space == pytest.approx(2e-5, rel=0.4)
    assert error < min(fit(seated)[1], 3e-4)


def test_stated_deviations_are_those_that_gaussian_noise_leaves(panda):
    """Such errors show that they have no tails; to claim more than they tell would be too sure."""
    truth, _ = mukca.simulate_recordings(panda, 1, samples=2, seed=3)
    deviations = [
        found.document.uncertainty.distance_deviation.median
        for found in (
            mukca.calibrate(panda, as_points(truth, poses(panda, n), 1e-4), without=WITHOUT)
            for n in (150, 600)
        )
    ]
    # four times the samples halve it
    assert deviations[0] / deviations[1] == pytest.approx(2, abs=0.2)


@by_table("factors", "words")
def test_points_in_other_units_or_hands_are_refused(panda, factors, words):
    truth, _ = mukca.simulate_recordings(panda, 1, samples=2, seed=4)
    points = as_points(truth, poses(panda, 30))
    places = [tuple(np.multiply(s.point, factors).tolist()) for s in points.samples]
    wrong = tuple(replace(s, point=p) for s, p in zip(points.samples, places, strict=True))
    with pytest.raises(mukca.MukcaError, match=words):
        mukca.calibrate(panda, replace(points, samples=wrong), without=WITHOUT)


def test_too_few_points_are_refused(panda):
    truth, _ = mukca.simulate_recordings(panda, 1, samples=2, seed=4)
    points = as_points(truth, poses(panda, 30))
    with pytest.raises(mukca.MukcaError, match="3 measured points; at least 4"):
        mukca.calibrate(panda, replace(points, samples=points.samples[:3]))
    file = Path("tracker", "points.csv")
    alike = replace(points, samples=points.samples[:1] * 9, files=(file,))
    with pytest.raises(mukca.MukcaError, match=f"{file}: all 9 points are of one configuration"):
        mukca.calibrate(panda, alike)

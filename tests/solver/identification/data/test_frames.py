"""Frames: poses, the best rigid motion, and coordinates that cannot be."""

import numpy as np
import pytest
from cases import by_table

from mukca.errors import NotConverged
from mukca.solver.identification.data import (
    FrameError,
    FrameObservations,
    Pose,
    fit_pose,
    place_frames,
)
from mukca.solver.identification.robot import turn


def pose(seed):
    generator = np.random.default_rng(seed)
    return Pose(turn(generator.normal(0, 1, 3)), generator.normal(0, 1, 3))


def landmarks(points, name="table"):
    return FrameObservations(
        name, np.arange(len(points)), points, [f"f:{i}" for i in range(len(points))]
    )


@pytest.fixture
def points():
    return np.random.default_rng(0).uniform(-0.4, 0.4, (12, 3))


def test_a_pose_is_found_again_in_spite_of_a_point_far_off(points):
    frame = pose(3)
    outer = frame.apply(points)
    outer[4] += 0.1
    found = fit_pose(points, outer)
    assert found.rotation == pytest.approx(frame.rotation, abs=1e-6)
    assert found.translation == pytest.approx(frame.translation, abs=1e-6)


def test_frames_are_placed_one_by_the_other(points):
    """The third shares nothing with the world, only with the second."""
    second, third = pose(4), pose(5)
    world = FrameObservations("world", np.arange(6), points[:6], [""] * 6)
    two = FrameObservations("two", np.arange(9), second.inverse().apply(points[:9]), [""] * 9)
    three = FrameObservations(
        "three", np.arange(6, 12), third.inverse().apply(points[6:]), [""] * 6
    )
    found = place_frames([world, three, two])
    assert found[1].apply(three.points) == pytest.approx(points[6:])
    assert found[2].translation == pytest.approx(second.translation)


@by_table("factors", "shift_of_one", "words")
def test_coordinates_that_cannot_be_are_refused(points, factors, shift_of_one, words):
    wrong = pose(6).apply(points) * factors
    wrong[7] += shift_of_one
    with pytest.raises(FrameError, match=words):
        place_frames([landmarks(points, "world"), landmarks(wrong)])


def test_a_line_is_blamed_only_where_few_are_off(points):
    """How many they are is told; where most are, the model is looked at, not a line."""
    wrong = pose(6).apply(points)
    wrong[[3, 7]] += 2
    with pytest.raises(FrameError, match=r"f:\d: .* m from where the nominal .* .2 such.,"):
        place_frames([landmarks(points, "world"), landmarks(wrong)])
    scattered = pose(6).apply(2 * points[::-1] ** 2)
    with pytest.raises(NotConverged, match=r"^f:0: .* \d+ of 12. Is a joint's zero or sign"):
        place_frames([landmarks(4 * points, "world"), landmarks(4 * scattered)])
    bent = points + 0.7 * np.abs(points) * points[::-1]
    worst = np.linalg.norm(fit_pose(bent, points).apply(bent) - points, axis=1).max()
    larger = 0.3 / worst
    place_frames([landmarks(larger * points, "world"), landmarks(larger * bent)])

"""A fit to all, proven by fits that each leave something out."""

import json
from dataclasses import replace

import numpy as np
import pytest

import mukca
from mukca.solver.calibration.folds import MOST, REGIONS, groups_of, regions
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import workspace

ROBOT = mukca.load_robot("ur5e")


@pytest.fixture(scope="module")
def recorded():
    """Three placements of an arm, far from one another."""
    truth, placements = mukca.simulate_recordings(ROBOT, 3, samples=12, seed=3)
    return truth, placements


@pytest.fixture(scope="module")
def proven(recorded):
    """The calibration on all of them."""
    return mukca.calibrate(ROBOT, recorded[1])


def measured_at(places, samples=6):
    """Placements whose balls are about some places, by configurations that all differ."""
    generator = np.random.default_rng(0)
    sockets = np.repeat([0, 1], samples // 2)
    return [
        measure(
            mukca.Placement.of_arrays(
                f"p{i}", generator.normal(0, 1, (samples, 6)), sockets, ROBOT.joint_names
            ),
            ROBOT,
            sockets=1,
        )
        for i in range(len(places))
    ]


def test_left_out_is_what_a_fit_to_the_others_says_of_it(proven, recorded):
    placements = recorded[1]
    rows = proven.document.left_out
    assert [row.name for row in rows] == [placement.name for placement in placements]
    for i, row in enumerate(rows[:2]):
        others = placements[:i] + placements[i + 1 :]
        held_out = mukca.calibrate(ROBOT, others, placements[i])
        kept_apart = held_out.errors[row.name]
        for model in ("nominal", "calibrated", "ball_refitted"):
            ours, theirs = (getattr(those, model) for those in (row, kept_apart))
            assert ours.mean_absolute_error == pytest.approx(theirs.mean_absolute_error, abs=1e-7)
            assert ours.distance_error == pytest.approx(theirs.distance_error, abs=1e-7)
        assert row.distance_deviation == pytest.approx(kept_apart.distance_deviation, rel=1e-4)
        trained = proven.errors[row.name]
        assert row.calibrated.mean_absolute_error != trained.calibrated.mean_absolute_error


def test_the_urdf_is_that_of_all_with_or_without_proof(proven, recorded, tmp_path):
    bare = mukca.calibrate(ROBOT, recorded[1], no_proof=True)
    assert bare.urdf() == proven.urdf()
    assert not bare.document.left_out and bare.document.summary.left_out is None
    assert proven.document.summary.test is None
    titles = [row.title for row in proven.verdict.limits]
    assert "mean left-out error" in titles and not any("held-out" in title for title in titles)
    assert bare.verdict.status_of("mean_absolute_error") == "not evaluated"
    proven.save(tmp_path / "out")
    loaded = mukca.load_calibration(tmp_path / "out")
    assert loaded.verdict == proven.verdict and loaded.misfit == proven.misfit > 0
    kept = json.loads((tmp_path / "out" / "calibration.json").read_text())
    assert {sample["fold"] for sample in kept["data"][1]["samples"]} == {1}


def test_what_is_held_out_is_the_proof_instead(recorded):
    placements = recorded[1]
    document = mukca.calibrate(ROBOT, placements[:2], placements[2]).document
    assert not document.folds and document.summary.left_out is None
    assert document.summary.proof == document.summary.test


def test_one_place_is_proven_by_nothing(recorded):
    first = recorded[1][0]
    alone = mukca.calibrate(ROBOT, first)
    again = replace(first, name="again")
    nearby = measured_at(range(2))
    assert not alone.document.folds and alone.document.summary.proof is None
    assert alone.verdict.status_of("mean_absolute_error") == "not evaluated"
    assert groups_of(nearby, [np.zeros(3), np.full(3, 0.05)]) == []
    copies = [measure(p, ROBOT) for p in (first, again)]
    assert groups_of(copies, [np.zeros(3), np.ones(3)]) == []


def test_placements_of_one_place_are_left_out_together():
    places = [
        np.zeros(3),
        np.array([0.5, 0, 0]),
        np.array([0.0, 0.08, 0]),
        np.array([0.0, 0.16, 0]),
    ]
    groups = groups_of(measured_at(places), places)
    assert sorted(sorted(group) for group in groups) == [[0, 2, 3], [1]]


def test_many_places_are_left_out_in_some_ten_folds():
    generator = np.random.default_rng(1)
    places = [*(10 * generator.normal(size=(3 * MOST, 3)))]
    groups = groups_of(measured_at(places, samples=4), places)
    assert len(groups) == MOST
    assert sorted(i for group in groups for i in group) == [*range(len(places))]
    gaps = [max(np.linalg.norm(places[i] - places[j]) for i in g for j in g) for g in groups]
    assert np.mean(gaps) < np.linalg.norm(np.ptp(places, axis=0)) / 2


def test_regions_are_boxes_of_neighbours_and_never_at_random():
    generator = np.random.default_rng(2)
    poses = generator.uniform(-2, 2, (40, 6))
    points = np.repeat(poses, 3, axis=0) + generator.normal(0, 1e-4, (120, 6))
    parts = regions(points, REGIONS)
    assert sorted(np.concatenate(parts).tolist()) == [*range(120)]
    assert all(16 <= len(part) <= 32 for part in parts)
    for part in parts:  # a pose that was taken again stays with the first
        assert all({3 * (i // 3), 3 * (i // 3) + 1, 3 * (i // 3) + 2} <= set(part) for i in part)
        for other in parts:
            gaps = points[other].min(axis=0) - points[part].max(axis=0)
            back = points[part].min(axis=0) - points[other].max(axis=0)
            assert part is other or max(gaps.max(), back.max()) > 0
    again = regions(points, REGIONS)
    assert all(np.array_equal(a, b) for a, b in zip(parts, again, strict=True))


def test_points_of_one_set_up_are_left_out_by_region(recorded):
    truth, _ = recorded
    q = workspace(ROBOT, 60)
    noise = np.random.default_rng(4).normal(0, 3e-5, (60, 3))
    sockets = np.zeros(60, int)
    placement = mukca.Placement.of_arrays("tracker", q, sockets, ROBOT.joint_names)
    balls = (truth.ball(q) + noise).tolist()
    pairs = zip(placement.samples, balls, strict=True)
    samples = tuple(replace(sample, point=tuple(ball)) for sample, ball in pairs)
    points = replace(placement, samples=samples)
    calibration = mukca.calibrate(ROBOT, points)
    rows = calibration.document.left_out
    assert [row.name for row in rows] == REGIONS * ["tracker"]
    assert sum(sum(row.samples) for row in rows) == 60
    summary = calibration.document.summary
    assert summary.left_out.calibrated.mean_absolute_error > (
        summary.train.calibrated.mean_absolute_error
    )
    (place,) = calibration.assessment.placements
    assert place.role == "left_out"
    mean = calibration.errors.left_out("tracker").loaded.mean_absolute_error
    assert place.loaded.mean_absolute_error == pytest.approx(mean)
    deviations = calibration.assessment.predictions.judged[0].errors("geometric")
    assert deviations.mean() == pytest.approx(mean, rel=0.1)

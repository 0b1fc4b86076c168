"""The exported URDF: as near to the full model as a URDF can be where it is used."""

from dataclasses import replace

import numpy as np
import pytest

import mukca
from mukca.recorder import Placement, Sample
from mukca.solver.identification.data import IDENTITY, fit_pose
from mukca.solver.identification.robot import workspace

pytestmark = pytest.mark.slow
ELASTIC = {"compliance": 8e-5, "tilt": 4e-5}
TRIED = {"without": ("transmission", "curves")}
"""Options of a calibration that tries elasticity alone."""


def by_geometry(calibration):
    """The mean error of the exported URDF alone at placements held out [m]."""
    summary = calibration.errors.summary.test
    return (summary.geometric or summary.calibrated).mean_absolute_error


def test_it_is_better_than_the_papers_geometry_elsewhere(panda):
    _, (train, *test) = mukca.simulate_recordings(panda, 4, seed=0, noise=7e-5, **ELASTIC)
    by_auto = mukca.calibrate(panda, train, test=test, **TRIED)
    by_paper = mukca.calibrate(panda, train, test=test, method="paper")
    assert by_auto.document.deflection
    assert by_geometry(by_auto) < by_geometry(by_paper)


def test_a_rigid_arms_geometry_is_its_calibration(panda, tmp_path):
    _, (train,) = mukca.simulate_recordings(panda, 1, samples=15, seed=0, noise=1e-6)
    found = mukca.calibrate(panda, train)
    assert found.document.deflection == {}
    assert found.save(tmp_path / "out").keys() == {"urdf", "calibration"}
    q = np.random.default_rng(0).uniform(-1, 1, (20, 7))
    assert found.calibrated.geometric_ball(q) == pytest.approx(found.calibrated.ball(q), abs=1e-12)


def test_it_is_near_to_the_truth_anywhere(panda):
    """The full model tells more of the workspace than the samples' own geometry does."""
    truth, (train,) = mukca.simulate_recordings(panda, 1, seed=1, noise=7e-5, **ELASTIC)
    by_paper = mukca.calibrate(panda, train, method="paper").calibrated
    full = mukca.calibrate(panda, train, **TRIED).calibrated
    q = workspace(panda, 400)
    balls = (truth.ball(q), by_paper.ball(q), full.geometric_ball(q), full.ball(q))
    true, *lengths = (np.linalg.norm(ball[1::2] - ball[::2], axis=1) for ball in balls)
    paper, exported, corrected = (np.median(np.abs(one - true)) for one in lengths)
    assert corrected < exported < 0.7 * paper


@pytest.mark.parametrize("flaws", [ELASTIC, {}])
def test_a_distance_that_is_hardly_known_does_not_set_the_size(panda, flaws):
    """The paper's cost takes it as it is; so its geometry is not what the URDF has."""
    truth, (train,) = mukca.simulate_recordings(panda, 1, seed=0, noise=7e-5, **flaws)
    wrong = replace(train, distance=0.051)
    options = TRIED | {"distance_deviation": 1e-3, "accept_distorted": True}
    found = mukca.calibrate(panda, wrong, **options).calibrated
    q = np.random.default_rng(0).uniform(-1.5, 1.5, (60, 7))
    true, exported = (
        np.linalg.norm(points[1::2] - points[::2], axis=1).sum()
        for points in (truth.ball(q), found.geometric_ball(q))
    )
    assert exported / true == pytest.approx(1, abs=4e-3)


def near_a_table(truth, name, generator):
    """Balls that an instrument measured, in postures as above one table."""
    q = np.array([0, -0.4, 0, -2, 0, 1.8, 0.8]) + generator.uniform(-0.6, 0.6, (60, 7))
    rows = zip(
        q.tolist(), (truth.ball(q) + generator.normal(0, 3e-5, (60, 3))).tolist(), strict=True
    )
    samples = tuple(Sample(tuple(row), 0, point=tuple(point)) for row, point in rows)
    return Placement(name, samples, truth.robot.joint_names)


def rigid_fit(ball, q, points):
    """The rigid geometry of least squares at measured balls, and next to nominal beyond them."""
    values = ball.nominal.copy()
    for _ in range(6):
        linear = ball.linearise(values, q)
        Q = np.linalg.qr(IDENTITY.slopes(points).reshape(-1, 6))[0]
        rows = np.column_stack(
            [(linear.points - points).ravel(), linear.by_parameters.reshape(len(Q), -1)]
        )
        r, J = np.split(rows - Q @ (Q.T @ rows), [1], axis=1)
        values -= np.linalg.solve(J.T @ J + 0.1 * np.eye(J.shape[1]), J.T @ r)[:, 0]
    return values


def test_where_balls_were_measured_no_rigid_geometry_is_much_better(panda):
    truth, _ = mukca.simulate_recordings(panda, 1, samples=10, seed=1, noise=7e-5, **ELASTIC)
    generator = np.random.default_rng(0)
    train, test = (near_a_table(truth, name, generator) for name in ("train", "test"))
    found = mukca.calibrate(panda, train, **TRIED)
    (q, points), (q_test, points_test) = (
        (np.array([s.position for s in p.samples]), np.array([s.point for s in p.samples]))
        for p in (train, test)
    )
    ball = found.posterior.model.ball
    balls = (
        found.calibrated.geometric_ball(q_test),
        ball.points(rigid_fit(ball, q, points), q_test),
    )
    exported, best = (
        np.linalg.norm(b - fit_pose(points_test, b).apply(points_test), axis=1).mean()
        for b in balls
    )
    assert exported < 1.2 * best


def test_a_few_measured_balls_do_not_bend_the_geometry(panda):
    """Four can be met whatever they are; the workspace is no worse for them."""
    truth, (train,) = mukca.simulate_recordings(panda, 1, samples=15, seed=1, noise=7e-5, **ELASTIC)
    points = near_a_table(truth, "points", np.random.default_rng(0))
    few, q = replace(points, samples=points.samples[:4]), workspace(panda, 400)
    both = (mukca.calibrate(panda, p, **TRIED) for p in (train, [train, few]))
    balls = [found.calibrated.geometric_ball(q) for found in both]
    true, *lengths = (np.linalg.norm(b[1::2] - b[::2], axis=1) for b in (truth.ball(q), *balls))
    without, beside = (np.median(np.abs(length - true)) for length in lengths)
    assert beside < 1.1 * without

"""True errors at held-out points are the authority, and a scale is told as a scale."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated_arm import pose_at
from msgspec import structs
from recorded import RIGID
from worlds import measured_points

import mukca
from mukca.recorder import Sample
from mukca.solver.identification.robot import BallModel, workspace

FRAME = pose_at(np.array([0.3, -1.0, 2.0]), np.array([2.0, -1.0, 0.5]))
LONGER = 1.008
SPREAD = np.array([0.15, 0.15, 0.15, 0.15, 0.02, 0.02, 0.02])


def points(arm, seed, scale=1.0, samples=60):
    placement = measured_points(
        arm, FRAME, np.random.default_rng(seed), samples=samples, noise=3e-5
    )
    rows = (
        replace(s, point=tuple((scale * np.array(s.point)).tolist())) for s in placement.samples
    )
    return replace(placement, name=f"points{seed}", samples=tuple(rows))


@pytest.fixture(scope="module")
def found(true_panda, panda):
    return mukca.calibrate(panda, points(true_panda, 1), points(true_panda, 2), **RIGID)


@pytest.mark.parametrize("probability", [0.05, 0.95])
def test_measured_errors_decide_whatever_the_posterior_expects(found, probability):
    better = found.document.better
    unsure = structs.replace(
        better, workspace=structs.replace(better.workspace, probability=probability)
    )
    document = structs.replace(found.document, better=unsure)
    verdict = mukca.Calibration(document, found.calibrated).verdict
    assert verdict.use
    assert "mm at 60 points not trained on" in verdict.answer[1]


def test_held_out_points_that_are_worse_bar_a_model_that_is_thought_better(found, panda):
    worse = mukca.calibrate(panda, points(panda, 1), points(panda, 2), **RIGID)
    better = structs.replace(
        worse.document.better, workspace=found.document.better.workspace, recorded_places=None
    )
    verdict = mukca.Calibration(
        structs.replace(worse.document, better=better), worse.calibrated
    ).verdict
    summary = worse.document.summary.test
    assert summary.loaded.mean_absolute_error >= 0.98 * summary.before.mean_absolute_error
    assert better.probability > 0.9
    assert not verdict.use


def test_a_narrow_cube_states_what_it_knows_there(true_panda, panda):
    """Postures far from all that were recorded say nothing of it: the tip is hardly known."""
    middle = workspace(panda, 1, 3)
    generator = np.random.default_rng(4)
    q = middle + SPREAD * generator.normal(size=(60, 7))
    balls = BallModel(true_panda, []).points(np.empty(0), q)
    measured = FRAME.inverse().apply(balls) + 3e-5 * generator.normal(size=(60, 3))
    rows = zip(q.tolist(), measured.tolist(), strict=True)
    samples = tuple(Sample(tuple(row), 0, point=tuple(point)) for row, point in rows)
    cube = mukca.Placement("cube", samples, panda.joint_names)
    known = mukca.calibrate(panda, cube, **RIGID).document.better
    assert known.recorded_places.now.value < 7e-5
    assert known.workspace.now.value > 3 * known.recorded_places.now.value


def test_a_scale_is_told_and_settled(true_panda, panda):
    """It is the instrument's or the arm's; told which, nothing is asked any more."""
    data = points(true_panda, 1, LONGER), points(true_panda, 2, LONGER)
    verdict = mukca.calibrate(panda, *data, **RIGID).verdict
    assert verdict.use and verdict.kind != "no_better"
    assert [line for line in verdict.answer if "--scale 1.00" in line]
    settled = mukca.calibrate(panda, *data, scale=LONGER, **RIGID)
    assert abs(settled.document.scale.value) < 1.5e-3
    assert not [line for line in settled.verdict.answer if "--scale" in line]
    later = points(true_panda, 3, LONGER)
    assert mukca.what_changed(settled, later).verdict.status == "pass"
    (row,) = settled.validate(data[0])
    assert row.role == "train"

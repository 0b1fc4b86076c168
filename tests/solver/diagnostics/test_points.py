"""Explanations of points that an instrument measured: those of sockets, by the same evidence."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import RIGID

from mukca import MukcaError, calibrate
from mukca.recorder import Placement, Sample
from mukca.solver.calibration import SolveOptions, problem_in_any_reach, quaternion_of
from mukca.solver.identification.data import FrameError
from mukca.solver.identification.robot import BallModel, turn, workspace

HALF = 25


def scaled(q, y):
    return q, 1.02 * y


def moved(q, y):
    return q, np.concatenate([y[:HALF], y[HALF:] + np.array([3e-3, 0, 0])])


def moved_far(q, y):
    return q, np.concatenate([y[:HALF], y[HALF:] @ turn(np.array([0.0, 0.05, 0.0])) + 0.05])


def zero_off(q, y):
    return q + 0.1 * np.eye(7)[2], y


def zero_lost(q, y):
    return np.concatenate([q[:HALF], q[HALF:] + 0.01 * np.eye(7)[2]]), y


def sign_turned(q, y):
    return q * [1, 1, -1, 1, 1, 1, 1], y


def joints_swapped(q, y):
    return q[:, [0, 1, 4, 3, 2, 5, 6]], y


def points_wrong(q, y):
    return q, y + 8e-3 * np.isin(np.arange(len(y)), [3, 17])[:, None]


@pytest.fixture(scope="module")
def points(panda, true_panda):
    """Return placements that share an instrument's frame, with a fault."""

    def points(fault=lambda q, y: (q, y), names=("front",)):
        generator = np.random.default_rng(5)
        q = workspace(panda, 2 * HALF)
        balls = BallModel(true_panda, ()).points(np.zeros(0), q)
        y = (balls - 1.0) @ turn(np.array([0.3, 2.0, -0.4]))
        q, y = fault(q, y + 1e-4 * generator.normal(size=y.shape))
        samples = [
            Sample(tuple(a), 0, point=tuple(b)) for a, b in zip(q.tolist(), y.tolist(), strict=True)
        ]
        placement = Placement(name="", samples=(), joint_names=panda.joint_names)
        parts = np.array_split(np.arange(len(q)), len(names))
        return [
            replace(placement, name=name, samples=tuple(samples[i] for i in rows))
            for name, rows in zip(names, parts, strict=True)
        ]

    return points


@pytest.mark.parametrize(
    "fault, name, words",
    [
        (scaled, "distance", "all measured coordinates are 2.0 % too large"),
        (moved, "base_moved", "the instrument, or the arm's base, moved by 3.0 mm before point 26"),
        (moved_far, "base_moved", "before point 26"),
        (zero_off, "zero", "joint 3 (panda_joint3) looks off: with -5"),
        (zero_lost, "zero_lost", "to what it reads"),
        (sign_turned, "sign", "joint 3 (panda_joint3) looks sign-flipped"),
        (joints_swapped, "swap", "joints 3 and 5 (panda_joint3, panda_joint5) look swapped"),
        (points_wrong, "ball_sample", "mm off: it was measured badly"),
    ],
)
def test_faults_of_points_are_named_as_those_of_sockets(look, points, fault, name, words):
    first = look(points(fault)).hypotheses[0]
    assert first.name == name and words in first.text


def test_sound_points_are_sound_and_an_instrument_moved_between_placements_is_told(look, points):
    names = ("front", "left")
    assert look(points()).hypotheses[0].name == "sound"
    assert look(points(names=names)).hypotheses[0].name == "sound"
    (first, *_) = look(points(moved, names)).hypotheses
    assert first.name == "base_moved" and first.text.endswith("before point 1")


def test_an_instrument_that_moved_is_an_unknown_of_the_fit(panda, points):
    calibration = calibrate(panda, points(moved), **RIGID)
    assert len(calibration.document.data) == 1
    (told,) = [d for d in calibration.document.checks if d.code == "movement"]
    assert "moved by" in told.text and "point 26" in told.text
    kept = calibrate(panda, points(moved), as_recorded=True, **RIGID)
    errors = [c.document.summary.train.calibrated.mean_absolute_error for c in (calibration, kept)]
    assert 3 * errors[0] < errors[1]


@pytest.mark.parametrize("digits", [5, 7, 16])
def test_points_that_a_controller_computed_are_told(look, panda, points, digits):
    (measured,) = points()
    balls = BallModel(panda, ()).points(np.zeros(0), measured.positions) + 1.0
    rows = zip(measured.samples, np.round(balls, digits).tolist(), strict=True)
    computed = [replace(sample, point=tuple(ball)) for sample, ball in rows]
    seen = look([replace(measured, samples=tuple(computed))]).placements[0]
    assert "computed" in [d.code for d in seen.diagnostics]
    assert "computed" not in [d.code for d in look([measured]).placements[0].diagnostics]


@pytest.mark.parametrize("size", [0.017, 0.03, 0.08])
@pytest.mark.parametrize("rows", [[8, 30], [5, 6, 40], [2, 17, 29, 35, 48]])
def test_points_that_hide_each_other_are_named_each_once(look, points, size, rows):
    def off(q, y):
        shifts = np.random.default_rng(len(rows)).normal(size=(len(rows), 3))
        y[rows] += size * shifts / np.linalg.norm(shifts, axis=1, keepdims=True)
        return q, y

    survey = look(points(off))
    told = [d for one in survey.placements for d in one.diagnostics if d.code == "elsewhere"]
    assert sorted(d.text.split(" is ")[0] for d in told) == sorted(f"point {i + 1}" for i in rows)
    sizes = [float(d.text.split(" is ")[1].split(" mm")[0]) for d in told]
    assert sizes == pytest.approx([1e3 * size] * len(rows), abs=0.6)
    assert survey.hypotheses[0].name == "ball_sample" and not survey.shared


def test_points_and_sockets_are_explained_together(look, points, placements):
    both = [placements[0], *points(zero_lost, ["tracker"]), placements[1]]
    assert (
        look([placements[0], *points(names=["tracker"]), placements[1]]).hypotheses[0].name
        == "sound"
    )
    survey = look(both)
    assert survey.hypotheses[0].name == "zero_lost"
    assert [one.measured.name for one in survey.placements] == ["front", "tracker", "left"]


def last_scaled(q):
    return q * [1, 1, 1, 1, 1, 1, 1.02]


def last_uneven(q):
    return q + 0.02 * np.sin(q) * np.eye(7)[6]


def last_zero_lost(q):
    return np.concatenate([q[:HALF], q[HALF:] + 0.03 * np.eye(7)[6]])


@pytest.fixture(scope="module")
def poses(panda, true_panda):
    """Return measured poses of a target on the axis of the last joint, with wrong readings."""

    def poses(wrong=lambda q: q):
        generator = np.random.default_rng(7)
        q, model = workspace(panda, 2 * HALF), BallModel(true_panda, ())
        none, turned = np.zeros(0), q + 1.0 * np.eye(7)[6]
        R, p = model.rotations(none, q).points, model.points(none, q)
        by_turn = R - model.rotations(none, turned).points
        moves = model.points(none, turned) - p
        on_axis = np.linalg.lstsq(by_turn.reshape(-1, 3), moves.ravel(), rcond=None)[0]
        frame, tool = turn(np.array([0.3, 2.0, -0.4])), turn(np.array([0.5, -0.2, 1.0]))
        y = (p + R @ on_axis - 1.0) @ frame + 1e-4 * generator.normal(size=p.shape)
        noise = np.array([turn(w) for w in 5e-4 * generator.normal(size=p.shape)])
        quaternions = quaternion_of(frame.T @ R @ tool @ noise)
        rows = zip(wrong(q).tolist(), y.tolist(), quaternions.tolist(), strict=True)
        samples = [Sample(tuple(a), 0, point=tuple(b), orientation=tuple(o)) for a, b, o in rows]
        names = panda.joint_names
        common = {"joint_names": names, "poses_of": "flange"}
        return [Placement(name="poses", samples=tuple(samples), **common)]

    return poses


@pytest.mark.parametrize(
    "wrong, name", [(last_scaled, "gain"), (last_uneven, "uneven"), (last_zero_lost, "zero_lost")]
)
def test_orientations_show_a_joint_on_whose_axis_the_target_lies(look, poses, wrong, name):
    first = look(poses(wrong)).hypotheses[0]
    assert first.name == name and "panda_joint7" in first.text


def test_sound_poses_are_sound_and_a_zero_of_the_last_joint_is_a_turn_of_the_target(look, poses):
    for wrong in (lambda q: q, lambda q: q + 0.1 * np.eye(7)[6]):
        survey = look(poses(wrong))
        assert survey.hypotheses[0].name == "sound" and not survey.shared


def quarter_turned(q, y):
    return q + np.pi / 2 * np.eye(7)[1], y


def mirrored(q, y):
    return q, y * [1, -1, 1]


def first_sign_turned(q, y):
    return q * [-1, 1, 1, 1, 1, 1, 1], y


def test_a_joint_that_no_fit_reaches_is_an_error_that_solve_names_too(panda, points):
    """Never a line of the table, though most points are far from the nominal model's."""
    wide = tuple(replace(joint, lower=-7.0, upper=7.0) for joint in panda.joints)
    robot = replace(panda, joints=wide)
    (finding, *_) = problem_in_any_reach(robot, points(quarter_turned), SolveOptions()).checks
    assert (finding.level, finding.code) == ("error", "zero")
    with pytest.raises(MukcaError, match=r"the fit did not converge; .* .panda_joint2. looks off"):
        calibrate(robot, points(quarter_turned), **RIGID)


def test_a_left_handed_frame_is_told_before_signs_that_explain_it(panda, points):
    """But one sign that explains as much is a sign."""
    with pytest.raises(FrameError, match=r"mirrored .left-handed.: swap two axes"):
        problem_in_any_reach(panda, points(mirrored), SolveOptions())
    problem = problem_in_any_reach(panda, points(first_sign_turned), SolveOptions())
    assert problem.hypotheses[0].name == "sign"

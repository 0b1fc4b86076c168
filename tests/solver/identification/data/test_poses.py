"""Poses that an instrument measured: the file, and where its frame and the tool are."""

from dataclasses import replace

import numpy as np
import pytest
from cases import by_table
from worlds.zoo import recorded_of

import mukca
from mukca.recorder import Placement, Sample
from mukca.solver.calibration import pose_of_numbers, quaternion_of
from mukca.solver.identification.data import check_orientations, hand_eye, measure
from mukca.solver.identification.robot import (
    BallModel,
    rotation_matrices,
    rotation_vectors,
    turn,
    workspace,
)

HEADER = "a,b,x,y,z,qx,qy,qz,qw"
ROW = "0.1,-1.5,1,2,3,0,0,0.6,0.8"
TOLD = "# measured flange poses"


def read(folder, *lines):
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")
    return mukca.read_placements(folder)[0]


@pytest.mark.parametrize("comment", [TOLD, "", "# camera: pose of the board in its frame"])
def test_poses_are_read_with_what_they_are(tmp_path, comment):
    found = read(tmp_path, *filter(None, [comment, HEADER, ROW]))
    (sample,) = found.samples
    assert sample.point == (1, 2, 3) and sample.orientation == pytest.approx((0, 0, 0.6, 0.8))
    assert found.poses_of == {TOLD: "flange", "": None}.get(comment, "camera")
    (tmp_path / "placement.json").write_text('{"poses_of": "flange"}')
    assert mukca.read_placements(tmp_path)[0].poses_of == "flange"


@by_table("header", "row", "words")
def test_malformed_poses_are_refused_by_line(tmp_path, header, row, words):
    with pytest.raises(mukca.MukcaError, match=words):
        read(tmp_path, TOLD, header, row)


def test_poses_of_something_else_are_not_measured_ones(tmp_path, panda):
    header = ",".join([*panda.joint_names, "x,y,z,qx,qy,qz,qw"])
    rows = [",".join(map(str, [*q, 0, 0, 0, 0, 0, 0, 1])) for q in workspace(panda, 5)]
    for comment in ("# commands", "# of my arm"):
        with pytest.raises(mukca.MukcaError, match='let the first line be "# measured flange'):
            measure(read(tmp_path, comment, header, *rows), panda)
    measured = measure(read(tmp_path, TOLD, header, *rows), panda)
    assert np.allclose(measured.rotations, np.eye(3)) and measured.kind == "points"


def poses(panda):
    """Joint positions, and rotations and places of the ball's link there."""
    q, model = workspace(panda, 30), BallModel(panda, [])
    none = np.zeros(0)
    return q, model.rotations(none, q).points, model.points(none, q)


def test_the_tool_and_the_frame_are_found_from_anywhere(panda):
    _, R, p = poses(panda)
    generator = np.random.default_rng(0)
    F, X = (turn(generator.uniform(-3, 3, 3)) for _ in range(2))
    f, x = generator.uniform(-3, 3, (2, 3))
    M, t = F.T @ R @ X, (p + R @ x - f) @ F
    t[3] += 0.5
    M[5] = M[5] @ turn(np.array([0.4, 0, 0]))
    found = hand_eye(R, p, M, t)
    assert np.allclose(found.frame.rotation, F, atol=1e-6)
    assert np.allclose(found.tool.rotation, X, atol=1e-6)
    assert np.allclose(found.tool.translation, x, atol=1e-6)
    assert found.distances[3] == pytest.approx(0.75**0.5, rel=0.01)
    assert found.angles[5] == pytest.approx(0.4, rel=0.01)
    with pytest.raises(mukca.MukcaError, match="turns about one axis only"):
        hand_eye(
            R[0] @ np.array([turn(np.array([0, 0, a])) for a in range(9)]), p[:9], M[:9], t[:9]
        )


def test_wrong_columns_of_quaternions_are_named(panda):
    _, R, _ = poses(panda)
    X = turn(np.array([0.3, -2, 1]))
    given = quaternion_of(X.T @ R)
    check_orientations(R, given * np.where(np.arange(30) % 2, 1, -1)[:, None], "file")
    for order, sign in (
        ((1, 2, 3, 0), (1, 1, 1, 1)),
        ((1, 0, 2, 3), (1, 1, 1, 1)),
        ((0, 1, 2, 3), (-1, -1, -1, 1)),
        ((0, 1, 2, 3), (1, 1, -1, 1)),
    ):
        wrong = np.zeros_like(given)
        wrong[:, order] = given * sign
        with pytest.raises(mukca.MukcaError, match="they turn the other way: two of the columns"):
            check_orientations(R, wrong, "file")


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_half_a_turn_is_about_one_axis_whatever_the_sign_of_zero(zero):
    about_z = np.array([[[-1.0, 0.0, 0.0], [zero, -1.0, 0.0], [0.0, 0.0, 1.0]]])
    assert quaternion_of(about_z).tolist() == [[0.0, 0.0, 1.0, 0.0]]


@by_table("order", "signs", "words")
def test_wrong_columns_of_joints_are_named_by_orientations(panda, order, signs, words):
    q, R, p = poses(panda)
    recorded = q[:, order] * signs
    rows = zip(recorded.tolist(), p.tolist(), quaternion_of(R).tolist(), strict=True)
    samples = [Sample(tuple(a), 0, point=tuple(b), orientation=tuple(o)) for a, b, o in rows]
    names = panda.joint_names
    placement = Placement("poses", tuple(samples), names, poses_of="flange")
    with pytest.raises(mukca.MukcaError, match=words):
        measure(placement, panda)


def test_the_turns_of_the_link_are_its_derivatives(panda):
    q, _, _ = poses(panda)
    model = BallModel(panda, list(range(6, 20)))
    linear = model.rotations(model.nominal, q[:3])
    for k, step in enumerate(1e-6 * np.eye(14)):
        turned = model.rotations(model.nominal + step, q[:3]).points @ linear.points.swapaxes(1, 2)
        assert np.allclose(
            rotation_vectors(turned), 1e-6 * linear.by_parameters[:, :, k], atol=1e-11
        )
    for k, step in enumerate(1e-6 * np.eye(7)):
        turned = model.rotations(model.nominal, q[:3] + step).points @ linear.points.swapaxes(1, 2)
        assert np.allclose(rotation_vectors(turned), 1e-6 * linear.by_joints[:, :, k], atol=1e-11)


@pytest.mark.slow
def test_poses_calibrate_and_judge_places_and_turns(true_panda):
    """The instrument stands anywhere, and its probe is turned by 100 degrees on the flange."""
    generator = np.random.default_rng(3)
    model, none = BallModel(true_panda, []), np.zeros(0)
    q = workspace(true_panda, 70, seed=3)
    F, X = turn(np.array([0.2, -2, 1])), turn(np.array([1.7, 0.3, -0.4]))
    R, x = model.rotations(none, q).points, np.array([0.08, -0.1, 0.2])
    places = (model.points(none, q) + R @ x - 4.0) @ F + generator.normal(0, 3e-5, (70, 3))
    turned = [M @ turn(generator.normal(0, 1e-4, 3)) for M in F.T @ R @ X]
    rows = zip(q.tolist(), places.tolist(), quaternion_of(np.array(turned)).tolist(), strict=True)
    samples = tuple(Sample(tuple(a), 0, point=tuple(b), orientation=tuple(c)) for a, b, c in rows)
    train, test = (
        mukca.Placement(name, own, true_panda.joint_names, poses_of="flange")
        for name, own in (("train", samples[:45]), ("test", samples[45:]))
    )
    robot = mukca.load_robot("panda")
    found = mukca.calibrate(
        robot,
        replace(train, poses_of=None),
        test=test,
        without=("compliance", "transmission"),
        flange_poses=True,
    )
    (row,) = (row for row in found.errors if row.role == "test")
    assert row.calibrated.mean_absolute_error < 1.5e-4
    assert row.calibrated.orientation_error < 4e-4 < row.nominal.orientation_error
    noise = found.document.noise
    assert noise is not None and noise.measured_turn == pytest.approx(1e-4, rel=0.3)
    (again,) = mukca.Calibration(found.document).validate(test)
    assert again.calibrated.orientation_error < 5e-4 and "mrad" in repr(found.errors)


@pytest.mark.slow
def test_orientations_without_any_noise_are_fitted_as_they_are():
    """As simulated ones are, while places have their noise."""
    recorded = recorded_of("poses of ur5e")
    found = mukca.calibrate(mukca.load_robot("ur5e"), recorded.train[""], recorded.test[""])
    (row,) = (row for row in found.errors if row.role == "test")
    assert row.calibrated.orientation_error < 5e-5
    assert row.calibrated.mean_absolute_error < 2e-4


def test_a_rotation_vector_and_a_matrix_are_read_as_the_quaternion(tmp_path):
    turns = [turn(v) for v in np.random.default_rng(0).normal(0, 1.2, (5, 3))]
    turns.append(np.diag([1.0, -1.0, -1.0]))
    forms = {
        "qx,qy,qz,qw": [quaternion_of(R[None])[0] for R in turns],
        "rx,ry,rz": [*rotation_vectors(np.array(turns[:-1])), np.array([np.pi, 0, 0])],
        ",".join(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)): [R.ravel() for R in turns],
    }
    for form, rows in forms.items():
        lines = [",".join(map(repr, [0.1, 1.0, 2.0, 3.0, *row.tolist()])) for row in rows]
        (tmp_path / "poses.csv").write_text("\n".join([f"joint,x,y,z,{form}", *lines]) + "\n")
        (placement,) = mukca.read_placements(tmp_path)
        read = np.array([sample.orientation for sample in placement.samples])
        assert rotation_matrices(read) == pytest.approx(np.array(turns), abs=1e-9)


def test_quaternions_are_those_of_the_rotations(simulated, panda):
    T = simulated.calibration.flange(workspace(panda, 50))
    given = np.hstack([T[:, :3, 3], quaternion_of(T[:, :3, :3])])
    assert np.abs(pose_of_numbers(given) - T).max() < 1e-12

"""The answers: use, next, data; and the parts of the 3D view."""

import json

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca.solver.assessment import area, percent, short_names
from mukca.solver.diagnostics import farthest_place
from mukca.solver.results import Model, calibrated_robot, encode
from mukca.solver.robot import load_robot
from mukca.tools.cli import main
from mukca.tools.report import build_report
from mukca.tools.report.build import Options
from mukca.tools.report.figures.answer_next import hardly_moved
from mukca.tools.report.figures.arm import frames
from mukca.tools.report.figures.meshes import link_meshes, thin_out


@pytest.mark.slow
def test_the_task_is_answered_place_by_place(document, typed) -> None:
    figures = build_report(typed(document), "").figures
    left = figures.placements[1].quantiles.calibrated
    largest, p95 = left.max, left.p95
    answers = {
        tolerance: build_report(typed(document), "", Options(tolerance=tolerance)).figures
        for tolerance in (1.01 * largest, 0.99 * largest, 0.99 * p95)
    }
    words = [f.answers.use.rows[1].answer for f in answers.values()]
    assert words == ["yes", "mostly", "no"]
    assert all(f.answers.use.rows[0].answer == "trained on" for f in answers.values())


@pytest.mark.slow
def test_a_place_whose_distance_is_off_cannot_be_used(document, typed) -> None:
    """Small errors do not help where the model has shrunk."""
    row = document["placements"][1]
    row["calibrated"]["distance_error"] = -2e-3
    use = build_report(typed(document), "").figures.answers.use
    assert use.rows[1].answer == "no" and use.rows[2].answer != "no"


@pytest.mark.slow
def test_what_is_expected_of_distances_is_told_where_none_was_measured(document, typed) -> None:
    between = build_report(typed(document), "").figures.answers.use.between
    assert between.endswith("since no such distance is known.")
    document["uncertainty"] = {
        "weak_directions": [],
        "correlations": [],
        "observability_index": 0.01,
        "distance_deviation": {"median": 6.8e-4, "worst": 1.5e-3},
        "cannot_see": [],
    }
    between = build_report(typed(document), "").figures.answers.use.between
    assert "expects 0.68 mm (one standard deviation" in between


@pytest.mark.slow
def test_a_recording_that_is_wrong_comes_first(document, typed) -> None:
    answers = build_report(typed(document), "").figures.answers
    assert "First mend" not in answers.next.text and "rest on" not in answers.data.text
    bad = {"level": "error", "code": "moved", "text": "the base moved", "advice": "record it again"}
    for row, said in ((document["placements"][0], True), (document["placements"][1], False)):
        document["checks"] = [{**bad, "where": f"/home/me/{row['name']}/hole_1.csv:12"}]
        answers = build_report(typed(document), "").figures.answers
        name = row["name"].split("/")[-1]
        assert answers.next.text.startswith(f"First mend {name}, see below.")
        assert (f"All figures here rest on {name}, trained on." in answers.data.text) == said
    document["checks"] = [{**bad, "where": "all placements"}]
    answers = build_report(typed(document), "").figures.answers
    assert answers.next.text.startswith("First mend front, left and right, see below.")
    assert "rest on front, trained on" in answers.data.text


@pytest.mark.slow
def test_a_placement_alone_leaves_the_same_everywhere(document, typed, session, capsys) -> None:
    """The terminal and the page say one number by the same words."""
    assert main(["check", str(session), "--robot", "panda", "--json"]) == 0
    told = {row["name"]: row["floor"] for row in json.loads(capsys.readouterr().out)["placements"]}
    answer = build_report(typed(document), "").figures.answers.data
    assert {f"session/{row.name}": row.mean_absolute_error for row in answer.floors} == told
    low, high = (f"{1e3 * f(told.values()):.3f} mm" for f in (min, max))
    assert f"Fitted alone, the placements leave {low} to {high}: none stands out." in answer.text


def test_places_off_the_middle_are_told_with_their_side(document, typed) -> None:
    text = build_report(typed(document), "").figures.answers.use.text
    assert "left (to the robot's left)" in text and "right (to the robot's right)" in text


def test_a_joint_that_hardly_moved_is_named(document, typed) -> None:
    figures = build_report(typed(document), "").figures
    assert figures.answers.next.joints == ()
    for sample in document["data"][0]["samples"]:
        sample["position"][6] = 0.1 + 1e-3 * sample["position"][6]
    robot = calibrated_robot(typed(document), "").robot
    assert robot.joint_names[6] == "panda_joint7"
    positions = np.array([s["position"] for s in document["data"][0]["samples"]])
    coverage = figures.coverage
    still = msgspec.structs.replace(
        coverage.sockets[0],
        low=tuple(positions.min(axis=0).tolist()),
        high=tuple(positions.max(axis=0).tolist()),
    )
    sockets = (still, *coverage.sockets[1:])
    assert "panda_joint7" in hardly_moved(msgspec.structs.replace(coverage, sockets=sockets))


places = st.lists(
    st.tuples(st.floats(0.3, 0.7), st.floats(-0.5, 0.5), st.floats(0.0, 0.5)),
    min_size=1,
    max_size=6,
)


@pytest.mark.slow
@settings(deadline=None)
@given(places)
def test_the_next_place_stands_apart_and_is_as_far_as_the_others(points) -> None:
    positions = np.array(points)
    place = farthest_place(positions)
    assert np.hypot(*place[:2]) == pytest.approx(np.hypot(*positions[:, :2].T).mean())
    assert place[2] == pytest.approx(positions[:, 2].mean())
    assert place[0] > -1e-9
    assert np.linalg.norm(positions - place, axis=1).min() > 0.05


def test_places_are_told_as_the_robot_sees_them() -> None:
    assert area([0.5, -0.2, 0.001]) == "0.50 m ahead, 0.20 m to its right"
    assert area([-0.1, 0.3, -0.05]) == "0.10 m behind, 0.30 m to its left, 0.05 m below"
    assert short_names(["s/a", "s/b"]) == ["a", "b"]
    assert short_names(["s/a", "t/a"]) == ["s/a", "t/a"]
    assert (percent(0.9999), percent(1.0), percent(1e-9), percent(0.0)) == (
        "99 %",
        "100 %",
        "1 %",
        "0 %",
    )


def test_the_drawn_arm_ends_at_the_ball(document, typed) -> None:
    calibration = calibrated_robot(typed(document), "")
    q = np.array([s["position"] for s in document["data"][0]["samples"]])
    assert not calibration.deflection.extensions
    origins = calibration.model.origins(calibration.values)
    T = frames(calibration.robot, origins, q)
    assert np.allclose(T[:, 0], np.eye(4))
    for i, xyz in enumerate(origins[:, :3]):  # each joint stands where its parent's frame says
        assert np.allclose(T[:, i + 1, :3, 3], T[:, i, :3, :3] @ xyz + T[:, i, :3, 3])
    assert np.allclose(T[:, -1, :3, 3], calibration.ball(q), atol=1e-12)
    R = T[:, :, :3, :3]
    assert np.allclose(R @ R.transpose(0, 1, 3, 2), np.eye(3))


def test_shapes_come_with_the_links_and_missing_ones_do_not_hurt(tmp_path) -> None:
    import trimesh

    trimesh.creation.icosphere(subdivisions=4, radius=0.1).export(tmp_path / "ball.stl")
    text = """<robot name="r"><link name="base"><visual><origin xyz="0 0 1"/><geometry>
      <box size="0.2 0.2 0.4"/></geometry></visual></link>
      <joint name="a" type="revolute"><parent link="base"/><child link="arm"/>
        <origin xyz="0 0 0.3"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
      <link name="arm"><visual><geometry><mesh filename="package://some/ball.stl"/></geometry>
        </visual><visual><geometry><mesh filename="http://localhost/x.stl"/></geometry></visual>
      </link>
      <joint name="b" type="fixed"><parent link="arm"/><child link="ball_link"/>
        <origin xyz="0.5 0 0"/></joint><link name="ball_link"/></robot>"""
    file = tmp_path / "robot.urdf"
    file.write_text(text)
    robot = load_robot(str(file))
    model = Model(
        name="r",
        source=str(file),
        sha256="",
        base="base",
        tip="ball_link",
        joint_names=robot.joint_names,
        nominal_urdf=text,
        calibrated_urdf=text,
    )
    meshes = link_meshes(model, robot)
    assert [mesh.frame for mesh in meshes] == [0, 1]
    box, ball = (np.array(mesh.vertices) for mesh in meshes)
    assert np.allclose(box.min(axis=0), [-0.1, -0.1, 0.8])
    assert np.allclose(box.max(axis=0), [0.1, 0.1, 1.2])
    assert np.linalg.norm(ball, axis=1) == pytest.approx(0.1, abs=0.02)
    assert 100 < len(meshes[1].faces) <= 600


@pytest.mark.slow
@settings(deadline=None, max_examples=20)
@given(st.integers(4, 200))
def test_thinning_keeps_within_bounds(most) -> None:
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=3)
    vertices, faces = thin_out(np.array(mesh.vertices), np.array(mesh.faces), most)
    assert 0 < len(faces) <= most
    assert faces.max() < len(vertices)
    assert np.abs(vertices).max() <= 1 + 1e-9


@pytest.mark.slow
def test_large_sessions_are_drawn_in_part_and_counted_whole(document, typed) -> None:
    rows = document["data"][1]["samples"]
    document["data"][1]["samples"] = [s for s in rows for _ in range(150)]
    figures = build_report(typed(document), "").figures
    assert len(figures.samples) <= 3000
    assert figures.summary.test.samples == 24 * 150 + 24
    assert len(encode(figures)) < 4_000_000

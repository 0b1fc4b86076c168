"""A camera on the arm or beside it, found with the calibrated chain held."""

import json
from functools import cache

import numpy as np
import pytest
from altered import write_rows
from calibrated_arm import pose_of
from cameras import (
    POSE,
    angles_of,
    board_seen,
    columns_of,
    flanges,
    in_file,
    names_of,
    recorded,
    rotations,
    views,
)
from recorded import RIGID

import mukca
from mukca import MukcaError

pytestmark = pytest.mark.slow


@pytest.fixture(params=["on-arm", "beside"])
def camera(request):
    return request.param


@pytest.fixture(scope="module")
def found_by(simulated):
    """What is found of views by a camera."""
    return lambda camera, rows, **options: mukca.handeye(
        simulated.calibration, recorded(rows), camera, **options
    )


@pytest.fixture(scope="module")
def sound(simulated, found_by):
    """What is found of the views by a camera."""
    return cache(lambda camera: found_by(camera, views(simulated, camera)))


def test_a_board_seen_elsewhere_stays_where_it_is(simulated, sound, camera):
    found = sound(camera)
    later = views(simulated, camera, seed=5)
    later[:, 7:10] *= found.size
    own, target = pose_of(found.frame.origin), found.target
    flange = found.calibration.flange(later[:, :7])
    if camera == "on-arm":
        carried = own.apply(later[:, 7:10])
        expected = np.tile(target.translation, (len(later), 1))
    else:
        carried = np.tile(target.translation, (len(later), 1))
        expected = own.apply(later[:, 7:10])
    seen = np.einsum("nij,nj->ni", flange[:, :3, :3], carried) + flange[:, :3, 3]
    off = float(np.mean(np.sum((seen - expected) ** 2, axis=1))) ** 0.5
    assert off < 1e-3
    assert off == pytest.approx(found.held_out[0], rel=0.5)
    assert 1e-4 < found.noise[0] < 4e-4


def scattered(q, seed):
    return q + np.random.default_rng(seed).normal(0, 3e-3, q.shape)


def two_decimals(q, seed):
    return np.round(q, 2)


def whole_degrees(q, seed):
    return np.radians(np.round(np.degrees(q)))


@pytest.mark.parametrize("reading", [scattered, two_decimals, whole_degrees])
def test_joints_that_scatter_alike_are_no_zero_that_changed(simulated, found_by, camera, reading):
    rows = views(simulated, camera, seed=2)
    rows[:, :7] = reading(rows[:, :7], 2)
    found = found_by(camera, rows)
    size = {scattered: "3", two_decimals: "2.9", whole_degrees: "5"}[reading]
    assert found.untold[0].startswith(f"All joints scatter alike, by some {size} mrad")
    steps = {two_decimals: "10 mrad", whole_degrees: "17.5 mrad"}
    if reading in steps:
        said = f"the joints read in steps of {steps[reading]}; rounding to them scatters"
        assert any(said in note for note in found.notes)
    assert not any("zero" in line or "panda_joint" in line for line in found.untold)
    assert sum("scatter alike" in line for line in found.text) == 1


def test_encoder_ticks_are_no_zero_that_changed(simulated, found_by, camera):
    rows = views(simulated, camera, seed=2)
    tick = np.pi / 2048
    rows[:, :7] = tick * np.round(rows[:, :7] / tick)
    found = found_by(camera, rows)
    assert not found.untold
    assert any("in steps of 1.53 mrad; rounding" in note for note in found.notes)


def test_exact_views_leave_little_noise(simulated, found_by):
    found = found_by("beside", views(simulated, "beside", noise=0))
    assert found.noise[0] < 1e-5 and not found.untold


def test_another_camera_other_units_and_mirrored_poses_are_told(simulated, found_by, camera):
    rows = views(simulated, camera)
    other = "beside" if camera == "on-arm" else "on-arm"
    with pytest.raises(MukcaError, match=f"use --camera {camera}"):
        found_by(other, rows)
    large = rows.copy()
    large[:, 7:10] *= 1e3
    with pytest.raises(MukcaError, match=r"millimetres[?]"):
        found_by(camera, large)
    rows[:, [7, 11, 12]] *= -1
    found = found_by(camera, rows)
    assert len(found.untold) == 1 and "are places mirrored" in found.untold[0]


def test_the_size_of_the_board_is_an_unknown_and_a_wrong_one_is_told(
    simulated, found_by, sound, camera
):
    rows = views(simulated, camera)
    for factor in (0.9, 1.005, 1.05):
        scaled = rows.copy()
        scaled[:, 7:10] *= factor
        found = found_by(camera, scaled)
        off = np.array(found.frame.xyz) - np.array(sound(camera).frame.xyz)
        assert off == pytest.approx(np.zeros(3), abs=5e-4)
        told = [line for line in found.untold if "The views fit if the board" in line]
        assert bool(told) == (abs(factor - 1) > 0.01)
        assert not told or ("larger" in told[0]) == (factor < 1)


@pytest.mark.parametrize("seed", range(3))
def test_a_size_that_no_view_tells_stays_as_it_was_said(simulated, found_by, sound, seed):
    """Two joints alone move: the camera is near its place, and asks for other distances."""
    generator = np.random.default_rng(seed)
    q = np.tile(simulated.later.positions[0], (30, 1))
    q[:, 5:] += generator.uniform(-0.5, 0.5, (30, 2))
    board = board_seen(flanges(simulated.truth, q), "beside")
    board[:, :3, 3] += generator.normal(0, 5e-4, (30, 3))
    found = found_by("beside", np.hstack([q, columns_of(board)]))
    off = np.array(found.frame.xyz) - np.array(sound("beside").frame.xyz)
    assert not found.size_told and found.size == pytest.approx(1, abs=0.01)
    assert "do not show the size of the board: vary its distance" in " ".join(found.brief)
    assert np.linalg.norm(off) < 0.02
    assert not found.untold or "vary the distance to the board" in found.untold[0]
    assert sound("beside").size_told


def test_an_instrument_s_places_are_of_the_right_size(simulated, found_by, sound):
    rows = views(simulated, "beside")
    found = found_by("beside", rows, scale="exact")
    assert found.size == 1 and found.size_told and not found.untold
    off = np.array(found.frame.xyz) - np.array(sound("beside").frame.xyz)
    assert np.linalg.norm(off) < 2e-3
    with pytest.raises(MukcaError, match="--scale large: choose among board, exact"):
        found_by("beside", rows, scale="large")


@pytest.mark.parametrize(("camera", "joint"), [("on-arm", 1), ("beside", 3), ("on-arm", 5)])
def test_a_zero_that_changed_since_is_told(simulated, found_by, sound, camera, joint):
    rows = views(simulated, camera)
    rows[:, joint] -= 5e-3
    found = found_by(camera, rows)
    assert "A joint's zero changed since the calibration" in found.untold[0]
    assert simulated.calibration.robot.joint_names[joint] in found.untold[0]
    off = np.array(found.frame.xyz) - sound(camera).frame.xyz
    covariance = np.array(found.frame.covariance)
    assert np.trace(covariance) > 2 * np.trace(sound(camera).frame.covariance)
    assert off @ np.linalg.solve(covariance, off) < 3**2 + 3


def test_a_place_less_sure_than_a_limit_is_not_enough(simulated):
    data = recorded(views(simulated, "on-arm"))
    found = mukca.handeye(simulated.calibration, data, "on-arm", limit=1e-5)
    assert found.untold[0].startswith("NOT ENOUGH DATA: these views cannot show camera")
    assert "turn the flange about two axes" in found.untold[0]
    assert not any("ros2" in line for line in found.text)


def test_the_way_to_read_the_turns_is_named(simulated, found_by, camera):
    rows = views(simulated, camera)
    first, transposed = rows.copy(), rows.copy()
    first[:, 10:] = rows[:, [13, 10, 11, 12]]
    transposed[:, 10:13] *= -1
    both, inverse = transposed.copy(), rows.copy()
    both[:, 10:] = transposed[:, [13, 10, 11, 12]]
    back = rotations(rows).swapaxes(1, 2)
    inverse[:, 7:10] = -np.einsum("nij,nj->ni", back, rows[:, 7:10])
    inverse[:, 10:] = both[:, 10:]
    for wrong, words in (
        (first, "w first"),
        (transposed, "transposed"),
        (both, "w first, turns transposed"),
        (inverse, "w first, inverse"),
    ):
        with pytest.raises(MukcaError, match=f"read as .*{words}"):
            found_by(camera, wrong)


ANGLES = {
    r"roll, pitch, yaw \(Rz": angles_of,
    r"roll, pitch, yaw in degrees \(Rz": lambda R: np.degrees(angles_of(R)),
    "Euler angles about z, y, x": lambda R: angles_of(R)[::-1],
    "Euler angles about x, y, z": lambda R: [-angle for angle in angles_of(R.T)],
    "Euler angles about z, y, z": lambda R: [
        np.arctan2(R[1, 2], R[0, 2]),
        np.arccos(R[2, 2]),
        np.arctan2(R[2, 1], -R[2, 0]),
    ],
}


@pytest.mark.parametrize("words", ANGLES)
def test_angles_in_the_place_of_rotation_vectors_are_named(simulated, tmp_path, words):
    camera = "on-arm" if words.startswith("roll") else "beside"
    rows = views(simulated, camera)
    angles = [ANGLES[words](R) for R in rotations(rows)]
    names = (*names_of(simulated)[:10], "rx", "ry", "rz")
    file = write_rows(tmp_path / "a.csv", np.hstack([rows[:, :10], angles]).tolist(), names)
    with pytest.raises(MukcaError, match=f"read as {words}"):
        mukca.handeye(simulated.calibration, in_file(file), camera)


def test_a_flipped_view_is_named_and_hardly_counts(simulated, found_by, sound):
    rows = views(simulated, "on-arm")
    rows[4, 10:] = rows[4, [13, 12, 11, 10]] * [1, 1, -1, -1]
    found = found_by("on-arm", rows)
    assert not sound("on-arm").outliers
    assert len(found.outliers) == 1 and "view 4" in found.outliers[0]
    assert np.array(found.frame.xyz) == pytest.approx(np.array(sound("on-arm").frame.xyz), abs=5e-4)


def turned_over(rows, count):
    """Return views, the board in some of them turned by 180 degrees about its normal."""
    rows = rows.copy()
    rows[:count, 10:] = rows[:count, [11, 10, 13, 12]] * [1, -1, 1, -1]
    return rows


def test_a_board_turned_over_is_told_in_a_few_views_and_in_half_of_them(simulated, found_by):
    rows = views(simulated, "on-arm", seed=4)
    few = found_by("on-arm", turned_over(rows, 2))
    assert len(few.outliers) == 2 and not few.untold
    assert all(line.endswith("Was the board found turned over?") for line in few.outliers)
    half = found_by("on-arm", turned_over(rows, 7))
    assert "7 of 15 views fit no other: is the board turned over" in half.untold[0]


def test_views_of_which_most_agree_with_no_other_ask_for_the_board(simulated):
    rows = recorded(turned_over(views(simulated, "beside"), 7))
    with pytest.raises(MukcaError, match=r"Is the board turned over in some views\?"):
        mukca.handeye(simulated.calibration, rows, "beside")


@pytest.mark.parametrize(
    ("rows", "message"),
    [(slice(4), "4 views; 5 are needed"), ([0] * 3 + [1] * 3, "2 views; 5 are needed")],
)
def test_views_that_cannot_tell_are_refused(simulated, found_by, rows, message):
    with pytest.raises(MukcaError, match=message):
        found_by("on-arm", views(simulated, "on-arm")[rows])


def test_the_command_writes_the_camera_into_the_urdf(simulated, cal, tmp_path, command, refused):
    rows, names = views(simulated, "beside").tolist(), names_of(simulated)
    write_rows(tmp_path / "of june.csv", rows, names)
    (tmp_path / "points.csv").write_text("another recording\n")
    words = ("handeye", cal, tmp_path / "of june.csv", "--camera")
    status, out, _ = command(*words, "beside", "--json", "--out", tmp_path / "new")
    said = json.loads(out)
    assert status == 0 and said["parent"] == simulated.calibration.robot.base
    assert "camera" in mukca.load_robot(said["outputs"]["urdf"]).text.links
    write_rows(tmp_path / "few.csv", rows[:3], names)
    few = ("handeye", cal, tmp_path / "few.csv", "--camera", "beside")
    assert "15 are" in refused("few.csv: 3 views; 5 are needed", *few)
    refused("", *words, "on-arm")
    refused("--near 1,2: give 7 numbers", *words, "beside", "--near", "1,2")


POSTURE = np.array([0.3, -1.4, 1.6, -1.2, -1.5, 0.2])


def test_the_order_of_columns_without_names_is_found(ur5e, tmp_path):
    """A driver's order, lift to wrist and then pan, under names that say nothing."""
    q = POSTURE + np.random.default_rng(4).uniform(-0.5, 0.5, (12, 6))
    seen = columns_of(board_seen(flanges(ur5e.calibrated, q), "beside"))
    driver = [1, 2, 3, 4, 5, 0]
    mixed = np.hstack([q[:, driver], seen]).tolist()
    names = [ur5e.robot.joint_names[k] for k in driver]
    unnamed = write_rows(tmp_path / "q.csv", mixed, [*(f"q{k}" for k in range(1, 7)), *POSE])
    with pytest.raises(MukcaError, match=f"fit if the columns are {','.join(names)} "):
        mukca.handeye(ur5e, in_file(unnamed), "beside")
    named = write_rows(tmp_path / "named.csv", mixed, [*names, *POSE])
    assert mukca.handeye(ur5e, in_file(named), "beside").held_out[0] < 1e-3


def test_another_arms_calibration_is_told_where_both_fit(simulated, sound, tmp_path, command):
    _, placements = mukca.simulate_recordings(simulated.calibration.robot, 2, seed=77, samples=12)
    other = mukca.calibrate(simulated.calibration.robot, placements, **RIGID)
    assert not sound("on-arm").untold
    touches = simulated.touched(np.array([0.03, -0.02, 0.2]))
    assert not mukca.tool(simulated.calibration, touches).untold
    assert any("another arm's" in line for line in mukca.tool(other, touches).untold)
    nominal = mukca.rezero(simulated.calibration.robot, simulated.read({}))
    assert "If it is this arm's model" in nominal.text[-1]
    other.save(tmp_path / "cal")
    rows = views(simulated, "on-arm").tolist()
    write_rows(tmp_path / "poses.csv", rows, names_of(simulated))
    words = ("handeye", tmp_path / "cal", tmp_path / "poses.csv", "--camera", "on-arm")
    status, out, _ = command(*words)
    assert status == 3 and "another arm's" in out

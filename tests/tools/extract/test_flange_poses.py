"""Views with the flange's poses in the place of joints, and of boards that look alike turned."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from calibrated_arm import pose_at
from cameras import POSE, STANDING, board_seen, columns_of, flanges, recorded, rotations, views

import mukca
from mukca import MukcaError
from mukca.tools.cameras import Board, joints_of, turned_alike

pytestmark = pytest.mark.slow

FLANGE = tuple(f"flange_{name}" for name in POSE)


def test_poses_of_the_flange_of_seven_joints_are_refused(simulated):
    placement = recorded(views(simulated, "beside"))
    with pytest.raises(MukcaError, match="7 joints bring a flange to one pose in endlessly many"):
        joints_of(simulated.calibration, replace(placement, joint_names=FLANGE), None)


def of_the_flange(arm, q, turned=None):
    """Views of a board on an arm by a camera beside it, with the flange's nominal poses."""
    board = board_seen(flanges(arm.calibrated, q), "beside")
    F = arm.nominal.flange(q) if turned is None else turned @ arm.nominal.flange(q)
    rows = np.hstack([columns_of(F), columns_of(board)])
    return replace(recorded(rows), joint_names=FLANGE)


POSTURE = np.array([0.3, -1.4, 1.6, -1.2, -1.5, 0.2])


def test_joints_are_recovered_where_they_are_told(ur5e):
    """An arm of six joints, its flange's nominal poses in place of them."""
    q = POSTURE + np.random.default_rng(1).uniform(-0.35, 0.35, (10, 6))
    placement = of_the_flange(ur5e, q)
    found = mukca.handeye(ur5e, joints_of(ur5e, placement, POSTURE.tolist()), "beside")
    assert np.array(found.frame.xyz) == pytest.approx(STANDING[:3, 3], abs=2e-4)
    assert any("recovered" in note for note in found.text)
    assert sum("taken as poses of tool0; if a tool is set in" in note for note in found.text) == 1
    with pytest.raises(MukcaError, match=r"postures bring the flange there, .* give one near"):
        joints_of(ur5e, placement, None)


def test_all_views_together_tell_the_posture(ur5e):
    q = POSTURE + np.random.default_rng(2).uniform(-0.35, 0.35, (8, 6))
    views = joints_of(ur5e, of_the_flange(ur5e, q), None, "beside")
    assert np.array([s.position for s in views.samples]) == pytest.approx(q, abs=1e-6)
    assert "8 postures bring the flange there; the views leave" in views.remarks[-1]


def test_a_single_view_is_refused(ur5e):
    placement = of_the_flange(ur5e, POSTURE[None])
    with pytest.raises(MukcaError, match=r"8 postures .* views do not tell which"):
        joints_of(ur5e, placement, None, "beside")
    with pytest.raises(MukcaError, match="1 views; 5 are needed"):
        mukca.handeye(ur5e, joints_of(ur5e, placement, POSTURE.tolist()), "beside")


@pytest.mark.parametrize("turned", [None, np.diag([-1.0, -1, 1, 1])])
def test_joints_stood_near_one_view_some_turns_on_or_in_the_controllers_frame(ur5e, turned):
    """The last joint goes all round, so that the farthest view is 3 rad off in it."""
    q = POSTURE + np.random.default_rng(3).uniform(-0.35, 0.35, (10, 6))
    q[:, 5] = np.linspace(-2.9, 2.9, 10)
    views = joints_of(ur5e, of_the_flange(ur5e, q, turned), q[0].tolist())
    off = np.array([s.position for s in views.samples]) - q
    assert off - 2 * np.pi * np.rint(off / (2 * np.pi)) == pytest.approx(0 * off, abs=1e-6)
    said = "half a turn about z off base_link, as in the frame `base`"
    assert any(said in line for line in views.remarks) == (turned is not None)


@pytest.mark.parametrize("turned", [None, np.diag([-1.0, -1, 1, 1])])
@pytest.mark.parametrize("seed", range(4))
def test_a_posture_far_from_all_views_never_puts_the_camera_half_a_turn_off(ur5e, turned, seed):
    generator = np.random.default_rng(seed)
    q = POSTURE + generator.uniform(-0.35, 0.35, (8, 6))
    guess = POSTURE + generator.normal(0, 0.9, 6)
    placement = of_the_flange(ur5e, q, turned)
    with suppress(MukcaError):
        off = joints_of(ur5e, placement, guess.tolist()).positions - q
        assert np.abs(np.sin(off / 2)).max() < 0.1
    away = q[0] + [np.pi / 2, 0, 0, 0, 0, 0]
    with pytest.raises(MukcaError, match=r"--near is 1\.\d rad from .* Give the joints of one"):
        joints_of(ur5e, placement, away.tolist())


@pytest.mark.parametrize("camera", ["on-arm", "beside"])
@pytest.mark.parametrize(("columns", "rows", "fold"), [(9, 7, 2), (10, 6, 2), (8, 8, 4), (9, 6, 1)])
def test_a_plain_board_that_looks_alike_turned_is_told_by_all_views(
    simulated, camera, columns, rows, fold
):
    board = Board(columns=columns, rows=rows, square=0.03, dictionary="none")
    seen = views(simulated, camera)
    turns = np.random.default_rng(4).integers(0, fold, 15)
    turns[0] = 0
    middle = pose_at([0, 0, 0], [0.015 * columns, 0.015 * rows, 0]).matrix
    turned = seen.copy()
    for row, R, k in zip(turned, rotations(seen), turns.tolist(), strict=True):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R, row[7:10]
        about_z = pose_at([0, 0, 2 * np.pi * k / fold], [0, 0, 0]).matrix
        row[7:] = columns_of((T @ middle @ about_z @ np.linalg.inv(middle))[None])[0]
    found = turned_alike(simulated.calibration, recorded(turned), board)
    there = np.array([(*s.point, *s.orientation) for s in found.samples])
    assert np.abs(there[:, :3] - seen[:, 7:10]).max() < 1e-9
    assert np.abs(rotations(there) - rotations(seen)).max() < 1e-9
    assert len(found.remarks) == (fold > 1)

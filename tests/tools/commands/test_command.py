"""`mukca command` and `mukca poses`: files of poses and of joint positions."""

import numpy as np
import pytest

import mukca
from mukca.solver.robot import workspace


@pytest.fixture(scope="module")
def folder(session, panda, tmp_path_factory):
    """A calibration, and joint positions on a short way."""
    folder = tmp_path_factory.mktemp("command")
    mukca.calibrate(panda, mukca.read_placements(session)[0], method="paper").save(folder / "it")
    middle = (panda.lower + panda.upper) / 2
    q = middle + np.linspace(0, 0.2, 6)[:, None] * np.sin(np.arange(7))
    lines = [",".join(panda.joint_names), *(",".join(map(repr, row)) for row in q.tolist())]
    (folder / "joints.csv").write_text("\n".join(lines) + "\n")
    return folder


def numbers(file):
    return np.loadtxt(file, delimiter=",", skiprows=1)


def test_a_round_trip_brings_the_poses_back(folder, command, tmp_path):
    setup = ("--tool", "0.01,0,0.12,0.1,0.2,1.57", "--payload", "1.2")
    there, back, again = (tmp_path / name for name in ("poses.csv", "back.csv", "again.csv"))
    assert command("poses", folder / "it", folder / "joints.csv", "--out", there, *setup)[0] == 0
    start = ("--start", *numbers(folder / "joints.csv")[0] + 0.05)
    status, _, err = command("command", folder / "it", there, "--out", back, *setup, *start)
    assert status == 0, err
    assert command("poses", folder / "it", back, "--out", again, *setup)[0] == 0
    assert back.read_text().splitlines()[0] == (folder / "joints.csv").read_text().splitlines()[0]
    assert np.abs(numbers(again) - numbers(there)).max() < 1e-9


def test_it_is_what_python_says(folder, command):
    calibration, q = mukca.load_calibration(folder / "it"), numbers(folder / "joints.csv")
    _, out, _ = command("poses", folder / "it", folder / "joints.csv", "--tool", "ball_link")
    rows = np.array([list(map(float, line.split(","))) for line in out.splitlines()[1:]])
    assert rows[:, :3] == pytest.approx(calibration.ball(q), abs=1e-12)
    assert np.linalg.norm(rows[:, 3:], axis=1) == pytest.approx(1)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["x,y,z", "0.4,0,0.4", "4,0,0.4"], "poses.csv:3: not reached"),
        (["a,b,c", "0.4,0,0.4"], "needed: x,y,z"),
        (["x,y,z,qx,qy,qz,qw", "0.4,0,0.4,0,0,0,1", "0.4,0,0.4,0,0,0,0"], "poses.csv:3: a quat"),
    ],
)
def test_what_cannot_be_is_refused_with_its_row(folder, command, tmp_path, lines, said):
    (tmp_path / "poses.csv").write_text("\n".join(lines))
    words = (folder / "it", tmp_path / "poses.csv", "--out", tmp_path / "out.csv")
    status, _, err = command("command", *words)
    assert status == 2 and said in err and len(err.splitlines()) == 1
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize(
    ("first", "status", "said"),
    [(3.5, 0, "3: 'panda_joint1' is 3.5, outside"), (90, 2, "3: 'panda_joint1' is 90; angles are")],
)
def test_joints_are_told_with_their_line(folder, command, tmp_path, first, status, said):
    header, *lines = (folder / "joints.csv").read_text().splitlines()
    bad = ",".join([str(first), *lines[0].split(",")[1:]])
    (tmp_path / "q.csv").write_text("\n".join([header, lines[0], bad]))
    found, _, err = command("poses", folder / "it", tmp_path / "q.csv")
    assert found == status and f"q.csv:{said}" in err and len(err.splitlines()) == 1


def test_quaternions_are_those_of_the_rotations(panda, folder):
    from mukca.solver.calibration import pose_of_numbers, quaternion_of

    T = mukca.load_calibration(folder / "it").flange(workspace(panda, 50))
    given = np.hstack([T[:, :3, 3], quaternion_of(T[:, :3, :3])])
    assert np.abs(pose_of_numbers(given) - T).max() < 1e-12

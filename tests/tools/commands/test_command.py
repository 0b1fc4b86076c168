"""`mukca command` and `mukca poses`: files of poses and of joint positions, and streams of them."""

import io
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from altered import write_rows
from cases import by_table
from terminal_session import PATIENCE

import mukca

STORED = Path(__file__).parents[2] / "stored" / "1.0" / "calibrated"


@pytest.fixture(scope="module")
def folder(session, panda, tmp_path_factory):
    """A calibration, and joint positions on a short way."""
    folder = tmp_path_factory.mktemp("command")
    mukca.calibrate(panda, mukca.read_placements(session)[0], method="paper").save(folder / "it")
    middle = (panda.lower + panda.upper) / 2
    q = middle + np.linspace(0, 0.2, 6)[:, None] * np.sin(np.arange(7))
    write_rows(folder / "joints.csv", q.tolist(), panda.joint_names)
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


def test_beside_each_pose_stands_how_well_it_is_known(command, refused, tmp_path):
    arm = mukca.load_calibration(STORED)
    q = arm.calibrated.middle + np.zeros((2, 7))
    write_rows(tmp_path / "joints.csv", q.tolist(), arm.robot.joint_names)
    status, out, _ = command("poses", STORED, tmp_path / "joints.csv", "--deviation")
    header, *rows = (line.split(",") for line in out.splitlines())
    assert (status, header[-1]) == (0, "rz_deviation")
    variances = np.diagonal(arm.deviation(q), axis1=1, axis2=2)
    assert np.array(rows, dtype=float)[:, 7:] ** 2 == pytest.approx(variances)
    start = (q[0] + 0.2).tolist()
    words = ("--deviation", f"--relative-to={','.join(map(str, start))}")
    _, out, _ = command("poses", STORED, tmp_path / "joints.csv", *words)
    _, *rows = (line.split(",") for line in out.splitlines())
    moved = np.diagonal(arm.deviation(q, relative_to=start), axis1=1, axis2=2)
    assert np.array(rows, dtype=float)[:, 7:] ** 2 == pytest.approx(moved)
    assert moved[0, :3].sum() < variances[0, :3].sum() / 4
    few = ("--deviation", "--relative-to=1,2")
    refused("--relative-to 1,2: give 7 numbers", "poses", STORED, tmp_path / "joints.csv", *few)


@by_table("lines", "said")
def test_what_cannot_be_is_refused_with_its_row(folder, refused, tmp_path, lines, said):
    (tmp_path / "poses.csv").write_text("\n".join(lines))
    words = (folder / "it", tmp_path / "poses.csv", "--out", tmp_path / "out.csv")
    refused(said, "command", *words)
    assert not (tmp_path / "out.csv").exists()


def test_poses_are_no_joint_positions(folder, refused, tmp_path):
    """Seven columns are no seven joints where they are a place and a quaternion."""
    (tmp_path / "poses.csv").write_text("x,y,z,qx,qy,qz,qw\n0.4,0,0.3,0,0,0,1\n")
    refused("its header is x,y,z,qx", "poses", folder / "it", tmp_path / "poses.csv")


def test_a_recording_is_no_file_of_joint_positions(folder, command, tmp_path):
    file = tmp_path / "samples.csv"
    file.write_text("event,sample,socket,time,position.panda_joint1\ncapture,1,0,17.5,-0.5\n")
    status, _, err = command("poses", folder / "it", file)
    assert status == 2 and "its header is event,sample,socket" in err and len(err.splitlines()) == 1
    assert "needed: panda_joint1,panda_joint2" in err and len(err) < 400


@pytest.mark.parametrize(
    ("first", "status", "said"),
    [(3.5, 0, "3: 'panda_joint1' is 3.5, outside"), (90, 2, "3: 'panda_joint1' is 90: radians")],
)
def test_joints_are_told_with_their_line(folder, command, tmp_path, first, status, said):
    header, *lines = (folder / "joints.csv").read_text().splitlines()
    bad = ",".join([str(first), *lines[0].split(",")[1:]])
    (tmp_path / "q.csv").write_text("\n".join([header, lines[0], bad]))
    found, _, err = command("poses", folder / "it", tmp_path / "q.csv")
    told = [line for line in err.splitlines() if "do not use it yet" not in line]
    assert found == status and f"q.csv:{said}" in err and len(told) == 1


@pytest.fixture
def pipe(folder):
    """A verb on the calibration, with pipes to it and from it."""
    running = []

    def start(verb, *words):
        command = [sys.executable, "-m", "mukca", verb, str(folder / "it"), "-", *words]
        pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
        one = subprocess.Popen(command, text=True, **pipes)
        running.append(one)
        assert one.stdout.readline()  # its header, before any row

        def ask(line):
            """Write a line, and wait for what it gives."""
            one.stdin.write(line + "\n")
            one.stdin.flush()
            return one.stdout.readline().strip()

        return one, ask

    yield start
    for one in running:
        one.kill()
        with closing(one.stdin), closing(one.stdout), closing(one.stderr):
            one.wait()


@pytest.mark.slow
def test_a_stream_gives_each_row_at_once_as_a_file_does(folder, command, pipe, tmp_path):
    poses, joints = tmp_path / "poses.csv", tmp_path / "joints.csv"
    assert command("poses", folder / "it", folder / "joints.csv", "--out", poses)[0] == 0
    start = list(map(str, numbers(folder / "joints.csv")[0] + 0.05))
    assert command("command", folder / "it", poses, "--out", joints, "--start", *start)[0] == 0
    one, ask = pipe("command", "--out", "-", "--start", *start)
    other, ask_back = pipe("poses")
    header, *lines = poses.read_text().splitlines()
    names, *expected = joints.read_text().splitlines()
    for asked, head in ((one, header), (other, names)):
        asked.stdin.write(head + "\n")
    for line, wanted in zip(lines, expected, strict=True):
        found = ask(line)
        assert found == wanted
        back = np.array(list(map(float, ask_back(found).split(","))))
        assert np.abs(back - list(map(float, line.split(",")))).max() < 1e-9
    for asked in (one, other):
        asked.stdin.close()
        assert asked.wait(PATIENCE) == 0 and not asked.stderr.read()


@by_table("rows", "said")
def test_a_stream_ends_at_the_row_that_cannot_be(folder, command, rows, said):
    with patch("sys.stdin", io.StringIO("\n".join([*rows, "0.4,0,0.4"]))):
        status, out, err = command("command", folder / "it", "-")
    assert status == 2 and len(out.splitlines()) == len(rows) - 1
    assert f"standard input{said}" in err and len(err.splitlines()) == 1

"""Samples that tell nothing, or are another arm's: one clear line on the command line."""

import base64
import tracemalloc
import zlib

import numpy as np
import pytest
from altered import write_rows, write_samples
from cases import by_table
from imagined import edited

import mukca

VERBS = {verb: (verb, "cal", "since") for verb in ("tool", "rezero", "validate")}
VERBS["check"] = ("check", "since", "--calibration", "cal")


@pytest.fixture
def said(simulated, tmp_path, command, monkeypatch):
    """Run a verb on samples; return its status, and all that it says."""

    def run(verb, q, sockets, names=None):
        monkeypatch.chdir(tmp_path)
        simulated.calibration.save(tmp_path / "cal")
        placement = mukca.Placement.of_arrays("since", q, sockets, names, distance=0.05)
        write_samples(tmp_path / "since", placement)
        return command(*VERBS[verb])

    return run


@pytest.mark.parametrize("verb", VERBS)
def test_samples_of_an_arm_of_other_joints_are_refused(simulated, said, verb):
    since = simulated.later
    status, _, error = said(verb, since.positions[:, :6], since.sockets)
    assert status == 2 and error.count("\n") == 1
    assert "the header names 6 of the robot's 7 joints; missing: panda_joint7" in error


@pytest.mark.parametrize("verb", VERBS)
def test_columns_of_other_names_are_taken_in_order_and_said_so(simulated, said, verb):
    since = simulated.later
    names = [f"elbow{j}" for j in range(7)]
    _, out, error = said(verb, since.positions, since.sockets, names)
    assert "no column is called like a joint of the robot" in out + error


@by_table("verb", "words", "statuses")
def test_postures_alike_say_too_little(simulated, said, verb, words, statuses):
    rows = [0] * 6 + [8] * 6
    q = simulated.later.positions[rows] + np.linspace(0, 1e-5, 12)[:, None]
    status, out, _ = said(verb, q, simulated.later.sockets[rows])
    assert status in statuses and words in out


@pytest.mark.parametrize("size", [100_000_000, 8])
def test_a_covariance_of_another_size_is_refused_before_it_fills_the_memory(
    simulated, cal, tmp_path, command, size
):
    packed = base64.b64encode(zlib.compress(bytes(size))).decode()
    file, since = tmp_path / "damaged.json", simulated.later

    def change(document):
        document["posterior"]["covariance"] = packed

    edited(cal / "calibration.json", file, change)
    placement = mukca.Placement.of_arrays("since", since.positions, since.sockets, distance=0.05)
    write_samples(tmp_path / "since", placement)
    tracemalloc.start()
    status, _, error = command("validate", file, tmp_path / "since")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert status == 2 and "`posterior.covariance`: damaged" in error
    assert peak < 90e6


def test_points_in_millimetres_are_asked_about(simulated, cal, tmp_path, refused):
    names = simulated.calibration.robot.joint_names
    rows = np.hstack([simulated.later.positions[:8], np.full((8, 3), 412.5)])
    file = write_rows(tmp_path / "touches.csv", rows.tolist(), [*names, "x", "y", "z"])
    error = refused("touches.csv:2: x, y or z is 412.5", "tool", cal, file)
    assert "are these millimetres?" in error

"""The look at a placement's numbers: what no arm can read or reach, told by its line."""

from dataclasses import replace

import numpy as np
import pytest
from altered import write_rows
from cases import by_table
from recorded import PLACES, recorded_at

from mukca import MukcaError
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import BallModel, workspace


def placed(panda, count=30):
    """Joint positions, and where an instrument sees the ball, shape (N, 7 + 3)."""
    q = workspace(panda, count)
    balls = BallModel(panda, ()).points(np.zeros(0), q)
    return np.hstack([q, np.random.default_rng(3).normal(balls + 1.0, 1e-4)])


@pytest.fixture
def folder(panda, tmp_path):
    """Write rows as points.csv, and return the folder."""

    def folder(rows):
        write_rows(tmp_path / "points.csv", rows.tolist(), (*panda.joint_names, "x", "y", "z"))
        return tmp_path

    return folder


@by_table("rows", "columns", "source", "told")
def test_rows_in_which_nothing_was_read_are_left_out_each_by_its_line(
    panda, folder, command, rows, columns, source, told
):
    data = placed(panda)
    for row in rows:
        data[row, slice(*columns)] = 0.0 if source is None else data[row + source, slice(*columns)]
    path = folder(data)
    status, out, err = command("check", path, "--robot", "panda")
    lines = [f"{path / 'points.csv'}:{row + 2}: {told}" for row in rows]
    assert status == 0 and all(err.count(line) == 1 for line in lines), err
    assert f"{len(data) - len(rows)} points" in out and err.count("points.csv:") == len(rows)


READERS = {
    "check": ["--robot", "panda"],
    "solve": ["--robot", "panda"],
    "info": [],
    "convert": ["--to", "points", "--out", "OUT"],
}
"""Verbs that read a recording, and what they need besides."""


@pytest.mark.parametrize("verb", READERS)
@pytest.mark.parametrize("value", [-9999.0, 9e9, 1e19, 3e7])
def test_places_that_no_arm_reaches_are_refused_before_any_fit(
    panda, folder, refused, tmp_path, verb, value
):
    data = placed(panda)
    data[4, 8] = data[9, 8] = value
    options = [word.replace("OUT", str(tmp_path / "out")) for word in READERS[verb]]
    said = refused(":6: x, y or z is ", verb, folder(data), *options)
    assert f"{value:.6g}: metres are expected" in said and "1 more such line" in said
    assert not (tmp_path / "out").exists()


def test_a_joint_that_reads_what_none_can_is_refused_by_all_verbs(panda, folder, refused):
    data = placed(panda)
    data[4, 2] = -9e9
    refused(":6: a joint is -9e+09: radians are expected", "info", folder(data))
    data[:, 2] = 1e308
    refused("points.csv: the column of joint 3 holds no number", "info", folder(data))


def test_a_frame_at_the_other_end_of_a_hall_is_none_of_these(panda, folder, command):
    data = placed(panda) + np.repeat([0.0, 90.0], [7, 3])
    status, out, _ = command("check", folder(data), "--robot", "panda")
    assert status == 0 and out.startswith("Nothing wrong was seen"), out


def test_nothing_but_zeros_is_refused(panda):
    front = recorded_at(panda, PLACES["front"])
    zeros = front.with_positions(0 * front.positions)
    with pytest.raises(MukcaError, match="the same configuration"):
        measure(zeros, panda)


def test_a_few_zeros_in_sockets_leave_the_rest(panda):
    front = recorded_at(panda, PLACES["front"])
    q = front.positions.copy()
    q[3] = q[25] = 0.0
    named = [replace(s, where=f"f:{i}") for i, s in enumerate(front.samples)]
    placement = replace(front, samples=tuple(named)).with_positions(q)
    measured = measure(placement, panda)
    assert sum(measured.counts) == 38
    assert [w.partition(":")[2].partition(":")[0] for w in measured.warnings] == ["3", "25"]

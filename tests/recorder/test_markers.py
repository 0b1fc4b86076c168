"""Several markers on one flange: one rigid body, whose place and turn come out."""

import numpy as np
import pytest

import mukca
from mukca.solver.identification.robot import rotation_matrices

BODY = np.array([[0.0, 0.0, 0.1], [0.08, 0.0, 0.08], [0.0, 0.09, 0.06], [-0.07, -0.03, 0.12]])
JOINTS = [f"arm_{k}_joint" for k in range(1, 7)]


def written(file, generator, count, body=BODY, lost=()):
    """Write a table of so many rows; return the body's middles and turns."""
    quaternions = generator.normal(0, 1, (count, 4))
    turns = rotation_matrices(quaternions / np.linalg.norm(quaternions, axis=1)[:, None])
    places = generator.uniform(-1, 1, (count, 3))
    markers = np.einsum("nij,kj->nki", turns, body) + places[:, None]
    cells = np.column_stack([markers.reshape(count, -1), generator.uniform(-2, 2, (count, 6))])
    lines = [",".join([f"{axis}{k + 1}" for k in range(len(body)) for axis in "xyz"] + JOINTS)]
    for i, row in enumerate(cells.tolist()):
        words = [repr(value) for value in row]
        words[3] = "" if i in lost else words[3]
        lines.append(",".join(words))
    file.write_text("\n".join(lines))
    return markers.mean(axis=1), turns


def read(file):
    (placement,) = mukca.read_placements(file)
    points = np.array([sample.point for sample in placement.samples])
    turns = [sample.orientation for sample in placement.samples]
    return placement, points, turns


def test_a_body_turns_with_the_flange_alike_in_every_table(tmp_path):
    generator = np.random.default_rng(4)
    offsets = []
    for name in ("one", "two"):
        middles, turns = written(tmp_path / f"{name}.csv", generator, 12)
        placement, points, quaternions = read(tmp_path / f"{name}.csv")
        assert points == pytest.approx(middles, abs=1e-12)
        assert placement.joint_names == tuple(JOINTS)
        assert "4 markers are taken as one rigid body" in placement.remarks[-1]
        offsets.append(np.einsum("nji,njk->nik", turns, rotation_matrices(np.array(quaternions))))
    for offset in np.concatenate(offsets):
        assert offset == pytest.approx(offsets[0][0], abs=1e-9)


@pytest.mark.parametrize("body", [BODY[:2], np.outer([0.0, 0.1, 0.3], [1.0, 2.0, 0.5])])
def test_markers_on_one_line_are_a_place_alone(tmp_path, body):
    middles, _ = written(tmp_path / "t.csv", np.random.default_rng(5), 6, body)
    placement, points, turns = read(tmp_path / "t.csv")
    assert points == pytest.approx(middles, abs=1e-12) and turns == [None] * 6
    assert "by its middle; they keep its shape to 0.00 mm" in placement.remarks[-1]


def test_a_row_that_lacks_a_marker_is_left_out_and_said(tmp_path):
    middles, _ = written(tmp_path / "t.csv", np.random.default_rng(6), 9, lost=(0, 4))
    placement, points, _ = read(tmp_path / "t.csv")
    assert points == pytest.approx(np.delete(middles, (0, 4), axis=0), abs=1e-12)
    assert any("2 rows without a place are left out (lines 2, 6)" in r for r in placement.remarks)


def test_a_table_that_lacks_a_marker_in_every_row_is_refused(tmp_path):
    written(tmp_path / "t.csv", np.random.default_rng(7), 3, lost=(0, 1, 2))
    with pytest.raises(mukca.MukcaError, match="no row has numbers in these columns"):
        read(tmp_path / "t.csv")

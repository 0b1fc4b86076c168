"""A table of another program is a placement by itself, whatever tells its columns."""

import re
import shlex

import numpy as np
import pytest
from foreign_tables import text_of, workbook

import mukca

RNG = np.random.default_rng(5)
PANDA = mukca.load_robot("panda")
Q = RNG.uniform(PANDA.lower, PANDA.upper, (12, 7))
XYZ = RNG.uniform(-0.7, 0.7, (12, 3))
Q_NAMES = [f"Achse {k} [Grad]" for k in range(1, 8)]
DEGREES, MILLIMETRES = np.rad2deg(Q), 1e3 * XYZ
NAMES = ["q=Achse 1..7 [deg]", "x=X3", "y=Y3 [mm]", "z=Z3 [mm]"]
BY_NUMBER = ["q=1..7 [deg]", "x=8 [mm]", "y=9 [mm]", "z=10 [mm]"]
WRITTEN = {
    "names": (text_of([*Q_NAMES, "X [mm]", "Y/mm", "Z mm"], [*np.c_[DEGREES, MILLIMETRES]]), []),
    "numbers": (text_of([], [*np.c_[DEGREES, MILLIMETRES]]), BY_NUMBER),
    "own names": (
        text_of([*Q_NAMES, "X3 [mm]", "Y3", "Z3"], [*np.c_[DEGREES, MILLIMETRES]]),
        NAMES,
    ),
    "names with units": (
        text_of([*Q_NAMES, "x", "y", "z"], [*np.c_[DEGREES, XYZ]]),
        [f"q={','.join(name.replace('Grad', '°') for name in Q_NAMES)}"],
    ),
    "sums": (
        text_of([*Q_NAMES, "a", "b", "y", "z"], [*np.c_[DEGREES, 2 * XYZ[:, :1], XYZ]]),
        ["x=a-b [m]", "y=y [m]", "z=z [m]"],
    ),
}


def same(placement, rows=slice(None)):
    samples = placement.for_joints(PANDA.joint_names)
    points = [sample.point for sample in samples.samples]
    assert np.abs(samples.positions - Q[rows]).max() < 1e-12
    assert np.abs(np.array(points) - XYZ[rows]).max() < 1e-12


@pytest.mark.parametrize("look", WRITTEN)
def test_a_table_is_read_alike_whatever_tells_its_columns(tmp_path, look):
    text, columns = WRITTEN[look]
    (tmp_path / "t.csv").write_text(text)
    (placement,) = mukca.read_placements(tmp_path / "t.csv", columns=columns)
    same(placement)
    assert placement.name == f"{tmp_path.name}/t"
    (tmp_path / "day").mkdir()
    (tmp_path / "day" / "points.csv").write_text(text)
    (placement,) = mukca.read_placements(tmp_path / "day", columns=columns)
    same(placement)
    assert placement.name.endswith("day")
    if look != "numbers":
        (tmp_path / "t.xlsx").write_bytes(workbook(text))
        same(mukca.read_placements(tmp_path / "t.xlsx", columns=columns)[0])


def halves(folder, order, ids=("id", "id")):
    folder.joinpath("j.csv").write_text(
        text_of([ids[0], *PANDA.joint_names], [[str(i), *q] for i, q in enumerate(Q)])
    )
    rows = [[f"{i:03d}", *XYZ[i]] for i in order]
    folder.joinpath("p.csv").write_text(text_of([ids[1], "x", "y", "z"], rows))
    return folder / f"j.csv+{folder}/p.csv"


def test_two_files_are_joined_by_a_column(tmp_path):
    path = halves(tmp_path, [5, 3, *range(6, 12), 0, 1, 2])
    (placement,) = mukca.read_placements(path, on="id")
    same(placement, [0, 1, 2, 3, *range(5, 12)])
    assert (
        "1 rows have no 'id' of the other file and are left out (lines 6)" in placement.remarks[0]
    )
    with pytest.raises(mukca.MukcaError, match=r"has 12 rows.*has 11; join them .*--on id"):
        mukca.read_placements(path)
    path = halves(tmp_path, [5, 3], ("id", "ID"))
    same(mukca.read_placements(path, on="id")[0], [3, 5])
    with pytest.raises(mukca.MukcaError, match=r"has 12 rows.*has 2; join them .*--on id"):
        mukca.read_placements(path)
    halves(tmp_path, [5, 3, *range(6, 12), 0, 1, 2])
    with pytest.raises(mukca.MukcaError, match=r"no column --on 'nr'; there are id, panda_joint1"):
        mukca.read_placements(path, on="nr")
    with pytest.raises(mukca.MukcaError, match=r"p\.csv:3: '005' is twice"):
        mukca.read_placements(halves(tmp_path, [5, 5]), on="id")


def test_two_files_are_joined_by_their_order(tmp_path):
    (placement,) = mukca.read_placements(halves(tmp_path, range(12), ("a", "b")))
    same(placement)
    assert "belong together in their order; if not, join them" in " ".join(placement.remarks)
    (placement,) = mukca.read_placements(halves(tmp_path, range(12), ("id", "ID")))
    assert "; if not, join them by a column of both, --on id" in " ".join(placement.remarks)


@pytest.mark.parametrize("look", ["numbers", "own names"])
@pytest.mark.parametrize("verb", ["check", "solve"])
def test_what_a_verb_says_of_a_table_works(tmp_path, refused, look, verb):
    """The option that is named, filled in, is what the verb needs."""
    (tmp_path / "t.csv").write_text(WRITTEN[look][0].replace("[mm]", ""))
    said = refused("say which columns", verb, str(tmp_path / "t.csv"), "--robot", "panda")
    words = shlex.split(re.search(r"--columns (.*)", said)[1])
    assert words[-1].startswith("z=")
    (placement,) = mukca.read_placements(tmp_path / "t.csv", columns=words)
    same(placement)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (["q=1..8 [deg]"], "header says 'mm' of X3, not 'deg'"),
        (["q=Achse 1..8"], "no column 'Achse 8'; there are Achse 1, Achse 1 .Grad., Achse 2"),
        (["q=Achse 1..7 [rad]"], "header says 'grad' of Achse 1, not 'rad'"),
        (["q=Achse 1 [rad]"], "header says 'grad' of Achse 1, not 'rad'"),
        (["q=Achse 1..7", "x=X3 [kg]"], "x has no unit 'kg'"),
        (["q=Achse 7..1"], "no columns; count upwards"),
        (["u=Achse 1"], "there are q, effort, socket, x"),
        (["q=Achse 1..7"], "q is needed, and socket, or x, y and z; as in --columns 'q=Achse 1,"),
    ],
)
def test_columns_that_cannot_be_are_refused(tmp_path, columns, said):
    (tmp_path / "t.csv").write_text(WRITTEN["own names"][0])
    with pytest.raises(mukca.MukcaError, match=said):
        mukca.read_placements(tmp_path / "t.csv", columns=columns)


def test_a_name_that_two_columns_have_is_no_name(tmp_path):
    text = WRITTEN["names"][0].replace("Achse 2", "Achse 1", 1)
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(mukca.MukcaError, match="'Achse 1' is the name of columns 1, 2"):
        mukca.read_placements(tmp_path / "t.csv", columns=["q=Achse 1,Achse 3..7,Achse 1"])
    columns = ["q=1..7"]
    same(mukca.read_placements(tmp_path / "t.csv", columns=columns)[0])


def test_a_lost_beam_is_left_out_and_said(tmp_path):
    lines = WRITTEN["numbers"][0].splitlines()
    lines[4] = ",".join([*lines[4].split(",")[:7], "", "", ""])
    (tmp_path / "t.csv").write_text("\n".join(lines))
    (placement,) = mukca.read_placements(tmp_path / "t.csv", columns=BY_NUMBER)
    same(placement, [i for i in range(12) if i != 4])
    assert "1 rows without a place are left out (lines 5)" in placement.remarks[0]

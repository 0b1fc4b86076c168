"""Known distances between sockets in a file: words, or a table whose units are named."""

import pytest
from cases import by_table

from mukca import MukcaError
from mukca.solver.tables import parse_known, read_known

TABLES = {
    "mm": "from,to,distance [mm],deviation [mm]\nleft:0,right:0,350.02,0.1\n",
    "m": "to,from,distance [m],deviation [m]\nright:0,left:0,0.35002,0.0001\n",
    "semicolons": "# laser\nfrom;to;distance (mm);deviation_mm\nleft:0;right:0;350,02;0,1\n",
    "words": "# laser\nleft:0-right:0=350.02mm+-0.1mm\n",
}


@pytest.mark.parametrize("name", TABLES)
def test_a_distance_means_the_same_in_every_form(name, tmp_path):
    file = tmp_path / "known.csv"
    file.write_text(TABLES[name])
    (known,) = (parse_known(str(words)) for words in read_known([file]))
    assert (known.first, known.second) == (("left", 0), ("right", 0))
    assert known.distance == pytest.approx(0.35002)
    assert known.deviation == pytest.approx(1e-4)


def test_a_caliper_measured_it_where_nothing_else_is_said(tmp_path):
    (tmp_path / "known.csv").write_text("from,to,distance_mm\nleft:0,right:0,350.02\n")
    (words,) = read_known([tmp_path / "known.csv"])
    assert parse_known(str(words)).deviation == pytest.approx(3e-5)


@by_table("text", "said")
def test_a_table_that_cannot_be_is_refused_by_its_line(text, said, tmp_path):
    (tmp_path / "known.csv").write_text(text)
    with pytest.raises(MukcaError, match=said):
        list(read_known([tmp_path / "known.csv"]))

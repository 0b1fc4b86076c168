"""A suspected flaw explains recordings that have it, and no others; mock knows the same words."""

import json
from dataclasses import replace

import numpy as np
import pytest
from cases import by_table

from mukca.recorder import Placement, sample_files
from mukca.solver.diagnostics import FLAWS, Flaw, what_if
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import BallModel
from mukca.solver.results import write_files
from mukca.tools.cli import main
from mukca.tools.simulation import Session, SessionFault, with_faults

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def spoilt(true_panda, record_at):
    """Return a placement, its sockets in turn, with a fault of the simulated arm."""
    sound = record_at([0.5, 0.0, 0.1], 0)
    turns = [i + k for i in range(0, 20, 5) for k in (0, 20)]
    order = [row for turn in turns for row in range(turn, turn + 5)]
    q = np.array([sound.samples[row].position for row in order])
    sockets = np.array([sound.samples[row].socket for row in order])
    balls = BallModel(true_panda, []).points(np.zeros(0), q)
    centres = np.array([balls[sockets == k].mean(axis=0) for k in (0, 1)])

    def spoilt(text, name="front"):
        generator = np.random.default_rng(1)
        session = Session(true_panda, q, sockets, centres, generator)
        readings = with_faults(session, [SessionFault.parse(text)] if text else [])
        names = true_panda.joint_names
        placement = Placement.of_arrays(name, readings, sockets, names, distance=0.05)
        samples = [replace(s, number=i + 1) for i, s in enumerate(placement.samples)]
        return replace(placement, samples=tuple(samples))

    return spoilt


@by_table("text", "other")
def test_a_flaw_explains_the_recordings_that_have_it(panda, spoilt, text, other):
    measured = [measure(spoilt(text), panda)]
    there = what_if(panda, measured, Flaw.parse(text))
    assert there.answer == "yes", there
    assert there.size_observed == pytest.approx(there.size, rel=0.25)
    assert there.remains < there.observed or text.startswith("loose")
    assert what_if(panda, measured, Flaw.parse(other)).answer == "no"


def test_another_size_is_told_and_so_is_what_a_fit_hides(panda, spoilt):
    measured = [measure(spoilt("base@16:4mm"), panda)]
    tenth = what_if(panda, measured, Flaw.parse("base@16 0.4mm"))
    assert tenth.answer == "size" and tenth.size_observed == pytest.approx(4e-3, rel=0.05)
    sound = [measure(spoilt(""), panda)]
    assert what_if(panda, sound, Flaw.parse("base 0.05mm")).answer == "unseen"
    assert what_if(panda, sound, Flaw.parse("base@16 4mm")).answer == "no"


def test_the_words_are_those_of_the_simulated_arm_and_its_sizes_have_units(spoilt):
    for word, kinds in FLAWS.items():
        assert Flaw.parse(f"{word} 3{kinds[0].unit}" if kinds[0].unit else word).kinds
        assert SessionFault.parse(f"{word}:3{kinds[0].unit}" if kinds[0].unit else word)


def test_the_verb_answers_first_and_tells_the_words(spoilt, capsys, tmp_path):
    write_files(tmp_path / "front", sample_files(spoilt("base@16:4mm")))
    words = ["whatif", str(tmp_path / "front"), "--robot", "panda"]
    assert main([*words, "--fault", "base@16 4mm"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("YES") and len(lines) <= 24
    assert main([*words, "--fault", "bent 4mm", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["answer"] == "no"
    (tmp_path / "front").rename(tmp_path / "1m")  # a name that looks like a size
    words[1] = str(tmp_path / "1m")
    assert main([*words, "--fault", "base 1m @16 4mm"]) == 0
    assert "/1m, sample 16) would explain" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["1m", "3", "mm", "before lunch", "Süd: 2"])
def test_a_placement_of_any_name_can_be_named(panda, spoilt, name):
    measured = [measure(spoilt("base@16:4mm", name), panda), measure(spoilt("", "left"), panda)]
    there = what_if(panda, measured, Flaw.parse(f"base {name} @16 4mm"))
    assert (there.answer, there.where["placement"]) == ("yes", name)


@pytest.mark.parametrize(
    ("offset", "told"), [(-1e-6, "add 0.00 deg"), (1e-6, "add 0.00 deg"), (-0.01, "add -0.57 deg")]
)
def test_a_size_that_rounds_to_zero_has_no_sign(offset, told):
    kind = Flaw.parse("zero").kinds[0]
    assert told in kind.text({"joint": "panda_joint4", "offset": offset})


@pytest.mark.parametrize("size", ["3.5mm", "3,5mm", "0,35e1 mm", "35e-1mm"])
def test_a_size_is_read_as_people_write_it(size):
    flaw = Flaw.parse(f"base {size}")
    assert flaw.size == pytest.approx(3.5e-3) and not flaw.names

"""Plans before the first print: more placements and longer bases promise more, in every form."""

import json
from xml.etree import ElementTree

import pytest

from mukca import load_robot
from mukca.solver.design import curve_advice, in_words

WORDS = ["plan", "--robot", "ur3e", "--placements", "2", "--samples", "4"]


@pytest.mark.slow
def test_a_plan_is_a_table_a_picture_and_json(tmp_path, command):
    file = tmp_path / "plan.svg"
    words = [*WORDS, "--distance", "0.05", "0.2", "--out", file, "--json", "--processes", "1"]
    status, out, err = command(*words)
    plans = json.loads(out)["plans"]
    assert (status, json.loads(out)["advice"]) == (0, "")
    assert "every joint" in curve_advice(load_robot("ur10"))
    for plan in plans:
        assert len(plan["places"]) == 2
        assert plan["predicted"][1] < plan["predicted"][0] < 0.01
    assert plans[1]["predicted"][0] < plans[0]["predicted"][0]
    assert f"{1e3 * plans[0]['predicted'][0]:.2f}" in err and "[mm]" in err
    texts = [e.text for e in ElementTree.parse(file).iter() if e.tag.endswith("text")]
    assert f"{1e3 * plans[0]['predicted'][1]:.2f} mm" in texts
    assert command(*words)[0] == 2


@pytest.mark.slow
def test_what_short_cables_cost_stands_beside(command):
    words = ["--turn", "60", "--distance", "0.1", "--placements", "1", "--json", "--processes", "1"]
    status, out, err = command(*WORDS, *words)
    free, bound = json.loads(out)["plans"]
    assert status == 0 and (free["turn"], bound["turn"]) == (None, 60)
    assert "100 mm, within 60 deg" in err
    assert bound["predicted"][0] > 1.05 * free["predicted"][0]


def test_the_way_to_another_place_is_told_as_seen_from_the_robot():
    assert in_words((0.5, 0.0, 0.1), (0.4, 0.3, 0.2)) == (
        "0.32 m to the left around the robot, 10 cm higher"
    )
    assert in_words((0.0, 0.5, 0.1), (0.1, 0.4, 0.1)) == "0.12 m to the right, 0.09 m nearer"

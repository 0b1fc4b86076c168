"""What other arms of a type tell: it helps where it is right, and costs nothing where it is not."""

import json
from pathlib import Path

import numpy as np
import pytest
from altered import moved, write_samples
from imagined import held_out

import mukca
from mukca.solver.identification.effects import EXTENSIONS
from mukca.tools.cli import main

pytestmark = pytest.mark.slow

FLAWS = {"compliance": 8e-5, "tilt": 4e-5}
UNBENT = ("transmission", "curves")
"""Effects of which no type is known."""


@pytest.fixture(scope="module")
def recorded(panda):
    return mukca.simulate_recordings(panda, 3, samples=20, seed=1, noise=7e-5, **FLAWS)


@pytest.fixture(scope="module")
def other(panda, recorded, tmp_path_factory):
    """The calibration of an arm of the type."""
    folder = tmp_path_factory.mktemp("other") / "out"
    found = mukca.calibrate(panda, recorded[1][:2], type_prior=["none"])
    assert found.document.deflection.keys() >= FLAWS.keys()
    return Path(found.save(folder)["calibration"])


def told(file, folder, values):
    """A calibration that tells other values, to 3 urad/(N m)."""
    document = json.loads(file.read_text())
    document["deflection"] = values
    joints = document["model"]["joint_names"]
    suffixes = {"compliance": ("compliance",), "tilt": ("tilt1", "tilt2")}
    document["coefficients"] = [
        {"name": name, "unit": "rad/(N m)", "value": value, "standard_deviation": 3e-6}
        for kind, own in values.items()
        for name, value in zip(
            [f"{joint}.{suffix}" for suffix in suffixes[kind] for joint in joints], own, strict=True
        )
    ]
    (folder / "told.json").write_text(json.dumps(document))
    return folder / "told.json"


def test_a_right_one_helps_with_few_samples_and_wrong_ones_do_no_harm(
    panda, recorded, other, tmp_path
):
    truth = recorded[0]
    _, (few, *_) = mukca.simulate_recordings(panda, 3, samples=10, seed=1, noise=7e-5, **FLAWS)
    test = recorded[1][1:]
    pairs = zip(truth.deflection.extensions, truth.deflection.coefficients, strict=True)
    right = {name: own.tolist() for name, own in pairs}

    def error(*prior):
        found = mukca.calibrate(panda, few, test=test, type_prior=prior, without=UNBENT)
        return held_out(found)

    alone = error("none")
    assert error(told(other, tmp_path, right)) < 0.98 * alone
    large = {name: [5 * v for v in own] for name, own in right.items()}
    assert error(told(other, tmp_path, large)) < 1.05 * alone
    reverse = {name: own[::-1] for name, own in right.items()}
    assert error(told(other, tmp_path, reverse)) < 1.05 * alone


def test_solve_says_how_much_it_counts(panda, recorded, other):
    documents = [
        mukca.calibrate(panda, recorded[1][2], type_prior=words, without=UNBENT).document
        for words in ((), "none", (other,))
    ]
    assert [d.settings["type_prior"] for d in documents[:2]] == [["shipped"], ["none"]]
    counts = [any("type prior: counts by" in c for c in d.choices or ()) for d in documents]
    assert counts == [True, False, True]


def test_an_effect_that_is_not_to_be_tried_is_not_told_either(panda, recorded, other):
    train = recorded[1][2]
    without = [name for name in EXTENSIONS if name != "compliance"]
    found = mukca.calibrate(panda, train, type_prior=[other], without=without)
    assert found.document.deflection.keys() == {"compliance"}


def test_a_fleet_writes_what_its_arms_tell(recorded, other, tmp_path, capsys):
    """As means weighted by precision; two arms alike are known better than one.

    The second arm's base is turned.
    """
    front = recorded[1][0]
    for arm, turn in (("a", 0.0), ("b", 0.1)):
        q = front.positions + turn * np.eye(7)[0]
        write_samples(tmp_path / "arms" / arm / "front", moved(front, q))
    words = ["fleet", str(tmp_path / "arms"), "--robot", "panda", "--processes", "1"]
    assert main([*words, "--distance", "0.05", "--out", str(tmp_path / "out")]) in (0, 1, 3)
    capsys.readouterr()
    (entry,) = json.loads((tmp_path / "out" / "elasticity.json").read_text())["types"]
    assert entry["arms"] == 2 and entry["joint_names"][0] == "panda_joint1"
    (file, *_) = sorted((tmp_path / "out").rglob("calibration.json"))
    one = {c["name"]: c for c in json.loads(file.read_text())["coefficients"]}
    for c in entry["coefficients"]:
        assert c["value"] == pytest.approx(one[c["name"]]["value"], rel=1e-3)
        expected = one[c["name"]]["standard_deviation"] / 2**0.5
        assert c["standard_deviation"] == pytest.approx(expected, rel=1e-3, abs=1e-9)


def test_what_tells_nothing_of_this_arm_is_refused(recorded, other, tmp_path):
    ur5e = mukca.load_robot("ur5e")
    _, train = mukca.simulate_recordings(ur5e, 1, samples=12)
    with pytest.raises(mukca.MukcaError, match="of an arm with the joints panda_joint1"):
        mukca.calibrate(ur5e, train, type_prior=[other])
    rigid = told(other, tmp_path, {})
    with pytest.raises(mukca.MukcaError, match="no elasticity was found in that arm"):
        mukca.calibrate(mukca.load_robot("panda"), recorded[1][0], type_prior=[rigid])


def test_shipped_elasticity_is_that_of_its_type_alone(panda):
    _, train = mukca.simulate_recordings(panda, 1, samples=12, seed=3, **FLAWS)
    options = {"without": ["transmission", "joint-noise"]}
    choices = mukca.calibrate(panda, train, **options).document.choices or ()
    ur5e = mukca.load_robot("ur5e")
    _, train = mukca.simulate_recordings(ur5e, 1, samples=12, seed=3)
    others = mukca.calibrate(ur5e, train, **options).document.choices or ()
    assert any("type prior" in line for line in choices)
    assert not any("type prior" in line for line in others)
    assert np.isfinite(train[0].positions).all()

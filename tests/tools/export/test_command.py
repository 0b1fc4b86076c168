"""`mukca export` as users meet it: identity, losses, and bad input."""

import hashlib
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from cases import by_table
from imagined import edited

import mukca


def test_the_file_says_who_made_it_from_what(export, calibrations, tmp_path):
    file, out = calibrations / "panda.json", tmp_path / "a" / "panda.json"
    assert export(file, "--to", "dh", "--out", out, "--serial-number", "7 */ -- x")[0] == 0
    document = json.loads(out.read_text())
    assert document["made_by"].startswith("mukca ")
    assert document["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    assert document["serial_number"] == "7  - x"


HOSTILE = "**//-->---!>\n*/ int x; /*"


@pytest.mark.parametrize("to", ["c", "urdf", "xacro", "dh"])
def test_no_name_closes_a_comment(export, calibrations, tmp_path, to):
    ending = {"dh": "csv"}.get(to, to)

    def rename(document):
        document["model"]["name"] = HOSTILE
        text = document["model"]["nominal_urdf"]
        document["model"]["nominal_urdf"] = text.replace('name="panda"', 'name="---"')

    file = edited(calibrations / "panda.json", tmp_path / "panda.json", rename)
    out = tmp_path / "out" / f"arm.{ending}"
    status, _, error = export(file, "--to", to, "--out", out, "--serial-number", HOSTILE)
    assert status == 0, error
    text = out.read_text()
    if to == "c":
        comment, _, behind = text.partition("*/")
        assert "int x;" in comment and behind.startswith('\n\n#include "arm.h"')
        assert "/*" not in comment[2:]
    elif to == "dh":
        assert "int x;" in text
        assert all("int x;" not in line or line.startswith("# ") for line in text.splitlines())
    else:
        comments = re.findall("<!--(.*?)-->", text, re.S)
        assert any("int x;" in comment for comment in comments)
        assert not any("--" in comment for comment in comments)
        assert "int x;" not in re.sub("<!--.*?-->", "", text, flags=re.S)
        ElementTree.fromstring(text)


def test_what_a_format_cannot_say_has_its_price(export, calibrations, tmp_path):
    file = calibrations / "panda.json"
    _, out, err = export(file, "--to", "dh", "--out", tmp_path / "a.csv", "--json")
    (loss,) = json.loads(out)["losses"]
    assert "compliance" in loss["what"] and "Not in this format: corrections" in err
    calibration = mukca.load_calibration(file)
    q = np.array([sample.position for sample in calibration.document.data[0].samples])
    # distances between balls do not depend on where the base frame stands
    full, rigid = calibration.calibrated.ball(q), calibration.calibrated.geometric_ball(q)
    changed = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (full, rigid)]
    assert np.abs(changed[0] - changed[1]).max() <= 2 * loss["largest"]
    assert 0 < loss["mean"] <= np.linalg.norm(full - rigid, axis=1).max()


def test_where_the_base_frame_stands_has_no_price(export, calibrations, tmp_path):
    """The corrections are none, and the two sets of origins differ by a shift of the base."""

    def shift(document):
        for value in document["parameters"]:
            shifted = 0.01 * (value["name"] == "panda_joint1.x")
            value["exported"] = value["calibrated"] + shifted
        document["deflection"] = {k: [0.0] * len(v) for k, v in document["deflection"].items()}

    file = edited(calibrations / "panda.json", tmp_path / "shifted.json", shift)
    _, out, _ = export(file, "--to", "dh", "--out", tmp_path / "a.csv", "--json")
    (loss,) = json.loads(out)["losses"]
    assert loss["largest"] < 1e-9


def test_the_place_of_the_ball_alone_is_lost_without_a_price(export, calibrations, tmp_path):
    """It is decimetres, which alarm, and none of the arm's."""
    _, *told = export(calibrations / "ur5e.json", "--to", "ur", "--out", tmp_path / "a.yaml")
    (line,) = [line for line in "".join(told).splitlines() if "the ball's place" in line]
    assert "matters to the ball alone" in line and " mm" not in line


def test_a_calibration_of_pure_geometry_loses_nothing(export, calibrations, tmp_path):
    file = calibrations / "fitted.json"
    _, out, _ = export(file, "--to", "mdh", "--out", tmp_path / "a.json", "--json")
    assert json.loads(out)["losses"] == []


def test_a_distorted_model_is_warned_of(export, calibrations, tmp_path):
    file = calibrations / "panda.json"
    bent = edited(file, tmp_path / "bent.json", lambda d: d.update(distorted=["a/front"]))
    status, _, err = export(bent, "--to", "dh", "--out", tmp_path / "a.csv")
    assert status == 0 and "sockets' distance at a/front" in err


def test_python_writes_the_same_file(export, calibrations, tmp_path):
    file = calibrations / "ur5e.json"
    export(file, "--to", "mdh", "--out", tmp_path / "a.json")
    calibration = mukca.load_calibration(file)
    exported = mukca.export(calibration, "mdh", tmp_path / "b.json")
    assert (tmp_path / "b.json").read_bytes() == (tmp_path / "a.json").read_bytes()
    assert exported.outputs == {"b.json": str(tmp_path / "b.json")}
    assert [loss.what.split()[0] for loss in exported.losses] == ["corrections"]


def test_nothing_is_overwritten_unless_told_so(export, refused, calibrations, tmp_path):
    words = (calibrations / "panda.json", "--to", "dh", "--out", tmp_path / "a.csv")
    (tmp_path / "a.csv").write_text("mine")
    refused("--force", "export", *words)
    assert (tmp_path / "a.csv").read_text() == "mine"
    assert export(*words, "--force")[0] == 0
    assert (tmp_path / "a.csv").read_text() != "mine"


@by_table("robot", "words", "said")
def test_bad_input_gets_one_line_and_writes_nothing(
    refused, calibrations, tmp_path, monkeypatch, robot, words, said
):
    monkeypatch.chdir(tmp_path)
    refused(said, "export", calibrations / f"{robot}.json", *words)
    assert list(tmp_path.iterdir()) == []


def test_help_names_every_format_as_its_refusal_does(export, calibrations, tmp_path):
    calibration = mukca.load_calibration(calibrations / "ur5e.json")
    with pytest.raises(mukca.MukcaError, match="no format 'pdf'; there are: urdf") as told:
        mukca.export(calibration, "pdf", tmp_path / "c.json")
    names = str(told.value).partition("there are: ")[2].split(", ")
    status, out, _ = export("--help")
    assert status == 0 and export("x.json", "--to", "pdf", "--out", "a.csv")[0] == 2
    assert len(names) > 9 and all(f"\n  {name} " in out for name in names)

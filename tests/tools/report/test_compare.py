"""Comparing calibrations: what is better, where, and that noise is no difference."""

import json
import re
from functools import partial

import pytest

from mukca.tools.cli import main


@pytest.fixture(scope="module")
def other(session, tmp_path_factory):
    """A calibration of the same session by the ball alone: worse than all joints."""
    out = tmp_path_factory.mktemp("other") / "ball_only"
    words = [str(session / "left"), "--robot", "panda", "--method", "paper", "--free", "ball_joint"]
    main(["solve", *words, "--accept-distorted", "--out", str(out)])
    return out


@pytest.fixture
def run(command):
    return partial(command, "compare")


@pytest.mark.slow
def test_the_better_one_is_named_with_its_lead_beyond_the_noise(run, calibrated, other):
    files = [calibrated / "calibration.json", other / "calibration.json"]
    status, out, err = run(*files, "--json")
    assert status == 0
    result = json.loads(out)
    assert [m["name"] for m in result["models"]] == ["nominal", "calibrated", "ball_only"]
    names = [row["name"].split("/")[-1] for row in result["placements"]]
    assert names == ["front", "left", "right"]
    assert result["fair"] == [2]
    assert [m["trained_on"] for m in result["placements"][0]["models"]] == [False, True, False]
    assert [m["trained_on"] for m in result["placements"][1]["models"]] == [False, False, True]
    pair = result["pairs"][-1]
    row = result["placements"][2]["models"]
    lead = row[2]["mean_absolute_error"] - row[1]["mean_absolute_error"]
    assert pair["summary"]["mean"] == pytest.approx(lead)
    assert pair["summary"]["beyond_noise"] is True
    assert re.search(r"calibrated is better than ball_only by \d", err)


def test_a_calibration_equals_its_copy_wherever_the_base_frame_is(
    run, calibrated, document, written
):
    """The base frame cannot be seen by a ball in a socket, so its place is no difference."""
    (joint,) = [row for row in document["parameters"] if row["name"] == "panda_joint1.z"]
    for key in ("calibrated", "exported", "change"):
        joint[key] += 0.1
    _, out, _ = run(calibrated, written(document), "--json")
    pair = json.loads(out)["pairs"][-1]
    assert pair["summary"]["mean"] == pytest.approx(0, abs=1e-12)
    assert pair["apart"]["max"] == pytest.approx(0, abs=1e-12)


def test_the_nominal_model_stands_with_its_ball_refitted_as_in_solve(
    run, calibrated, document, written
):
    def compared(file):
        _, out, err = run(file, "--json")
        result = json.loads(out)
        return result["ball_refitted"], result["placements"], err

    by_name = {row["name"]: row for row in document["placements"]}
    for key in ("ball_refitted", "nominal"):
        was_refitted, placements, err = compared(written(document))
        assert was_refitted == (key == "ball_refitted") == ("its ball refitted to what" in err)
        for row in placements:
            error = by_name[row["name"]][key]["mean_absolute_error"]
            assert row["models"][0]["mean_absolute_error"] == pytest.approx(error)
        document.pop("refitted_ball", None)  # as files of before


def test_where_all_were_trained_nothing_is_said(run, session, calibrated):
    _, out, err = run(calibrated / "calibration.json", "--data", session / "front", "--json")
    result = json.loads(out)
    assert result["fair"] == [] and result["pairs"][0]["summary"] is None
    assert "trained on by one of the models" in err


def test_the_page_shows_the_figures_of_the_json(run, calibrated, other, tmp_path, read_page):
    out = tmp_path / "out"
    files = [calibrated / "calibration.json", other / "calibration.json"]
    assert run(*files, "--out", out)[0] == 0
    figures = json.loads((out / "compare.json").read_text())
    page = read_page(out / "compare.html")
    shown = page.having("data-figure")
    assert len(shown) >= 3 * 4 + 3 * 3
    for attributes, text in shown:
        value = figures
        for key in attributes["data-figure"].split("."):
            value = value[int(key)] if isinstance(value, list) else value[key]
        assert float(text) == pytest.approx(1e3 * value, abs=5.001e-4)
    captions = [text for _, text in page.all("figcaption")]
    assert captions == [plot["sentence"] for plot in figures["plots"]]
    assert run(*files, "--out", out)[0] == 2


def test_other_robots_and_twice_the_same_are_refused(run, refused, calibrated, document, written):
    file = calibrated / "calibration.json"
    assert run(file, file)[0] == 2
    for key in ("nominal_urdf", "calibrated_urdf"):
        document["model"][key] = document["model"][key].replace("panda_joint3", "elbow")
    for row in document["parameters"]:
        row["name"] = row["name"].replace("panda_joint3", "elbow")
    refused("elbow", "compare", file, written(document))

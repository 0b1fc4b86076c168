"""A sheet to sign, which rests on held-out places."""

import json
from functools import partial

import pytest

pytestmark = pytest.mark.slow


@pytest.fixture
def run(command):
    return partial(command, "report")


def test_the_sheet_has_errors_limits_verdict_and_digests(run, calibrated, tmp_path):
    sheet = tmp_path / "sheet.html"
    words = (calibrated / "calibration.json", "--limit-mae-mm", "0.7", "--out", tmp_path)
    status, out, _ = run(*words, "--certificate", sheet)
    report = json.loads((tmp_path / "report.json").read_text())
    page = sheet.read_text()
    assert status in (0, 1, 3) and f"Wrote {sheet}" in out
    held_out = report["summary"]["test"]
    figures = held_out["nominal"]["mean_absolute_error"], held_out["quantiles"]["nominal"]["p95"]
    assert all(f"{1e3 * figure:.3f} mm" in page for figure in figures)
    assert "0.700 mm" in page and report["verdict"]["title"] in page
    assert report["provenance"]["model_sha256"] in page
    assert "<script" not in page and page.count("date</p>") == 2


def test_what_nobody_noted_is_left_to_fill_in(run, calibrated, tmp_path):
    sheet = tmp_path / "sheet.html"
    run(calibrated / "calibration.json", "--out", tmp_path, "--certificate", sheet)
    assert "<th>Operator</th><td>____" in sheet.read_text()


def test_a_sheet_without_held_out_places_is_refused(command, refused, session, tmp_path):
    folder = tmp_path / "trained"
    command("solve", session / "front", "--robot", "panda", "--method", "paper", "--out", folder)
    words = (folder / "calibration.json", "--certificate", tmp_path / "sheet.html", "--force")
    refused("rests on held-out placements, and there is none", "report", *words)
    assert not (tmp_path / "sheet.html").exists()


def test_other_files_than_pages_are_refused(refused, calibrated, tmp_path):
    words = (calibrated / "calibration.json", "--certificate", tmp_path / "sheet.pdf")
    refused("only a .html page is written; print it to PDF in a browser", "report", *words)


def test_the_arm_and_who_recorded_it_are_said_where_they_were_noted(
    run, document, written, tmp_path
):
    session = {"serial_number": "FR-7", "operator": "Ada"}
    (tmp_path / "placement.json").write_text(json.dumps({"sessions": [session, session]}))
    file = str(tmp_path / "hole_0.csv")
    document["provenance"]["data_sha256"] = {file: "0" * 64}
    document["data"][0]["files"] = [file]
    calibration, sheet = written(document), tmp_path / "sheet.html"
    run(calibration, "--certificate", sheet)
    page = (calibration.parent / "report.html").read_text()
    assert "; serial number FR-7; operator Ada; method paper" in page
    assert "<th>Operator</th><td>Ada</td>" in sheet.read_text()

"""A sheet to sign, which rests on what a fit did not see."""

import hashlib
import html
import json
import re
import zlib
from functools import partial

import pytest

pytestmark = pytest.mark.slow
A4 = b"/MediaBox [0 0 595.28 841.89]"


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
    figures = [held_out[model]["mean_absolute_error"] for model in ("nominal", "ball_refitted")]
    figures.append(held_out["quantiles"]["nominal"]["p95"])
    assert all(f"<td>{1e3 * figure:.3f} mm</td>" in page for figure in figures)
    assert "0.700 mm" in page and report["verdict"]["title"] in page
    assert report["provenance"]["model_sha256"] in page
    policy = '<meta http-equiv="Content-Security-Policy".*>'
    assert re.findall(policy, page) == re.findall(policy, (tmp_path / "report.html").read_text())
    urdf = hashlib.sha256((calibrated / "calibrated.urdf").read_bytes()).hexdigest()
    assert f"{urdf} calibrated.urdf" in page and urdf in (tmp_path / "report.html").read_text()
    assert "<script" not in page and page.count("date</p>") == 2
    assert all(page.count(html.escape(row["text"])) == 1 for row in report["rests_on"])


def test_what_is_measured_and_what_is_predicted_have_columns_of_their_own(run, auto, tmp_path):
    sheet = tmp_path / "sheet.html"
    run(auto / "calibration.json", "--out", tmp_path, "--certificate", sheet)
    report = json.loads((tmp_path / "report.json").read_text())
    page = sheet.read_text()
    cells = [re.findall(r"<t[dh]>(.*?)</t[dh]>", row) for row in re.findall(r"<tr>.*?</tr>", page)]
    by_title = {row[0]: row[1:3] for row in cells if len(row) == 5}
    measured, predicted = by_title.pop("on")
    assert measured.startswith("measured") and predicted.startswith("predicted")
    for row in report["verdict"]["limits"]:
        measured, predicted = by_title[row["title"]]
        assert bool(predicted) is row["name"].startswith("predicted") and bool(
            measured
        ) is not bool(predicted)
        if predicted and "interval" in row:
            low, value, high = (
                f"{1e3 * row['interval'][key]:.3f} mm" for key in ("low", "value", "high")
            )
            assert predicted == f"{value} ({low} to {high})"
    assert str(auto) not in page and "/tmp" not in page  # no path of this computer
    models = [row[0] for row in cells if len(row) == 4]
    errors = report["summary"]["test"]
    fair = min(("nominal", "ball_refitted"), key=lambda name: errors[name]["mean_absolute_error"])
    assert ("refitted" in models[1]) is (fair == "ball_refitted")  # the fair one first
    assert ("corrected joint positions" in models) is ("geometric" in errors)
    assert "ISO 9283" in page and "Range of joints" in page and "void" in page


def test_notes_fill_their_lines_and_no_other_is_taken(run, refused, calibrated, tmp_path):
    sheet = tmp_path / "sheet.html"
    words = (calibrated / "calibration.json", "--out", tmp_path, "--certificate", sheet)
    run(*words, "--note", "instrument=Caliper <A>", "--note", "place=Hall 3")
    page = sheet.read_text()
    assert "<th>Place</th><td>Hall 3</td>" in page and "Caliper &lt;A&gt;" in page
    assert "<th>Date due</th><td>____" in page
    refused(
        "--note colour: choose among number, ", "report", *words, "--force", "--note", "colour=red"
    )
    refused("--note place: write KEY=TEXT", "report", *words, "--force", "--note", "place")


def test_what_nobody_noted_is_left_to_fill_in(run, calibrated, tmp_path):
    sheet = tmp_path / "sheet.html"
    run(calibrated / "calibration.json", "--out", tmp_path, "--certificate", sheet)
    assert "<th>Operator</th><td>____" in sheet.read_text()
    same, large = (calibrated / "calibration.json", "--out", tmp_path), tmp_path / "LARGE.HTML"
    run(*same, "--certificate", large)
    assert large.read_bytes() == sheet.read_bytes()


def test_a_sheet_where_nothing_was_left_out_is_refused(command, refused, session, tmp_path):
    folder = tmp_path / "trained"
    command("solve", session / "front", "--robot", "panda", "--method", "paper", "--out", folder)
    words = (folder / "calibration.json", "--certificate", tmp_path / "sheet.html", "--force")
    told = "rests on what a fit left out, and nothing was: record a second place"
    refused(told, "report", *words)
    assert not (tmp_path / "sheet.html").exists()


def test_a_sheet_that_is_there_is_refused_before_anything_is_written(refused, calibrated, tmp_path):
    sheet, out = tmp_path / "sheet.html", tmp_path / "out"
    sheet.write_text("signed")
    words = (calibrated, "--certificate", sheet, "--out", out)
    refused(f"{sheet}: exists", "report", *words)
    assert not out.exists()


def test_a_report_of_other_options_stays_where_only_the_sheet_is_wanted(run, document, written):
    calibration = written(document)
    page, sheet = calibration.parent / "report.html", calibration.parent / "sheet.html"
    run(calibration)
    other = page.read_bytes()
    status, out, err = run(calibration, "--certificate", sheet, "--limit-mae-mm", "0.7")
    assert status in (0, 1, 3) and not err
    assert f"{page} is of other options and stays as it is" in out and f"Wrote {sheet}" in out
    assert page.read_bytes() == other and "0.700 mm" in sheet.read_text()
    run(calibration, "--certificate", sheet, "--limit-mae-mm", "0.7", "--force")
    assert page.read_bytes() != other


def texts(pdf):
    """The words that a PDF shows, in their order."""
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.S)
    content = b"".join(zlib.decompress(stream) for stream in streams if stream[:1] == b"\x78")
    shown = b" ".join(re.findall(rb"\(((?:\\.|[^\\)])*)\) Tj", content)).decode("cp1252")
    return re.sub(r"\\(.)", r"\1", shown).split()


@pytest.fixture
def pdf_of(run, tmp_path):
    """Write a calibration's sheet as a PDF."""
    pytest.importorskip("fpdf", reason="the extra pdf is not installed")

    def write(calibration):
        run(calibration, "--out", tmp_path, "--force", "--certificate", tmp_path / "sheet.pdf")
        return (tmp_path / "sheet.pdf").read_bytes()

    return write


def test_a_pdf_has_the_words_of_the_page_on_one_a4(run, pdf_of, calibrated, tmp_path):
    calibration = calibrated / "calibration.json"
    pdf = pdf_of(calibration)
    assert pdf.startswith(b"%PDF-") and pdf.count(b"/Type /Page\n") == 1 and A4 in pdf
    run(calibration, "--out", tmp_path, "--force", "--certificate", tmp_path / "sheet.html")
    body = (tmp_path / "sheet.html").read_text().partition("<body>")[2]
    words = html.unescape(re.sub(r"<[^>]*>", " ", body)).split()
    words += ["Page", "1", "of", "1"]
    assert len(words) > 100 and "".join(sorted(texts(pdf))) == "".join(sorted(words))
    assert pdf_of(calibration) == pdf  # so that a sheet that is up to date stays


def test_much_to_say_is_still_one_page(pdf_of, document, written):
    names = {f"a/rather/long/folder/of/recordings/{i}/samples.csv": "0" * 64 for i in range(30)}
    document["provenance"]["data_sha256"] = names
    document["provenance"]["versions"] = {f"package{i}": "1.2.3" for i in range(150)}
    assert pdf_of(written(document)).count(b"/Type /Page\n") == 1


def test_letters_that_no_pdf_font_has_are_refused(refused, document, written, tmp_path):
    pytest.importorskip("fpdf", reason="the extra pdf is not installed")
    document["provenance"]["versions"] = {"Łukasz": "1"}
    words = (written(document), "--certificate", tmp_path / "sheet.pdf")
    refused("the fonts of a PDF lack the letter 'Ł': name a .html file", "report", *words)
    assert not (tmp_path / "sheet.pdf").exists()


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

"""The report: its figures are those of its page, and it speaks of the data at hand."""

import csv
import json
import math
import re
import shlex
import shutil
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from altered import HOLES
from cases import by_table

import mukca
from mukca.tools.cli import main


def look_up(figures, path):
    for key in path.split("."):
        figures = figures[int(key)] if isinstance(figures, list) else figures[key]
    return figures


def check_page(folder, read_page):
    """See that the page shows what report.json holds; return how many numbers it showed."""
    figures = json.loads((folder / "report.json").read_text())
    page = read_page(folder / "report.html")
    for attribute in ("src", "href"):  # it needs no other file
        assert all(a[attribute].startswith(("data:", "#")) for a, _ in page.having(attribute))
    assert "default-src 'none'" in (folder / "report.html").read_text()
    shown = page.having("data-figure")
    for attributes, text in shown:
        value = look_up(figures, attributes["data-figure"]) * float(attributes["data-scale"])
        digits = int(attributes["data-digits"])
        assert float(text) == pytest.approx(value, abs=0.5001 * 10**-digits), attributes
        assert len(text.partition(".")[2]) == digits
    (embedded,) = [text for a, text in page.all("script") if a.get("id") == "figures"]
    assert json.loads(embedded) == figures
    captions = [text for _, text in page.all("figcaption")]
    assert captions == [plot["sentence"] for plot in figures["plots"]]
    assert [a["id"] for a, _ in page.all("figure")] == [plot["id"] for plot in figures["plots"]]
    return len(shown)


def test_the_outline_of_badly_known_places_goes_round_all_of_them(extended, written, read_page):
    cells = [(0.1 * k + 0.05, 0.05, 0.01) for k in range(-2, 2)]
    extended["outlook"] = {"joints": [], "map": {"width": 0.1, "cells": cells}}
    file = written(extended)
    main(["report", str(file)])
    page = read_page(file.parent / "report.html")
    (figure,) = page.root.iterfind(".//figure[@id='error-map']")
    assert len(list(figure.iterfind(".//polyline[@class='threshold']"))) == 10


def test_the_page_shows_the_figures_of_the_json(calibrated, read_page):
    # 48 parameters of three numbers, and the rest.
    assert check_page(calibrated, read_page) > 3 * 48 + 30


@pytest.mark.slow
@by_table("words")
def test_what_only_some_methods_know_is_shown_too(extended, written, read_page, words):
    file = written(extended)
    main(["report", str(file)])
    assert check_page(file.parent, read_page) > 4 * 48 + 40
    html = (file.parent / "report.html").read_text()
    before = extended["summary"]["test"]["ball_refitted"]["mean_absolute_error"]
    removed = f"Removed: {100 - 100 * 2e-4 / before:.1f} % of the error, with corrected"
    assert [one for one in (*words, removed) if one not in html] == []


def test_figures_are_those_of_the_calibration(calibrated, document):
    """Errors in the report, sample by sample, average to the MAE that the solver found."""
    figures = json.loads((calibrated / "report.json").read_text())
    robot = mukca.load_calibration(calibrated / "calibration.json").calibrated
    for i, row in enumerate(figures["placements"]):
        rows = [sample for sample in figures["samples"] if sample["placement"] == i]
        for model in ("nominal", "calibrated"):
            errors = np.linalg.norm([sample[model] for sample in rows], axis=1)
            told = document["placements"][i][model]
            assert errors.mean() == pytest.approx(told["mean_absolute_error"], abs=1e-8)
            assert errors.max() == pytest.approx(told["max_error"], abs=1e-8)
        positions = [sample["position"] for sample in document["data"][i]["samples"]]
        centre = robot.ball(np.array(positions)).mean(axis=0)
        assert np.allclose(row["position"], centre, atol=1e-9)


def test_every_plot_has_short_sentences_with_figures(calibrated, extended, report):
    plain = json.loads((calibrated / "report.json").read_text())["plots"]
    more = report(extended)["plots"]
    of_extensions = {plot["id"] for plot in more} - {plot["id"] for plot in plain}
    assert of_extensions == {"predicted-found", "groups"}
    for sentence in (plot["sentence"] for plot in (*plain, *more)):
        assert re.fullmatch(r"[^.!?].*\.", sentence), sentence
        words = map(str.split, re.split(r"(?<=[.!?]) ", sentence))
        assert max(map(len, words)) <= 30, sentence
        assert re.search(r"\d", sentence), sentence


def test_an_effect_of_any_unit_has_its_own_panel_and_counts(extended, written, read_page):
    """Its coefficients are no transmission error, and its group is not the ball's."""
    one = {"name": "panda_joint1.bow", "unit": "1/rad", "value": 0.02, "standard_deviation": 0.01}
    extended["coefficients"].append(one)
    group = {"name": "bow", "unit": "1/rad", "count": 7, "width": 0.01, "effective": 6.5}
    extended["groups"].append({**group, "active": True})
    file = written(extended)
    main(["report", str(file)])
    page = read_page(file.parent / "report.html")
    drawn = [a["aria-label"] for a, _ in page.all("svg") if "," in a.get("aria-label", "")]
    panels = [label for label in drawn if label.startswith("corrections")]
    assert panels == ["corrections of joints, mrad", "corrections of joints, 1/rad"]
    (figure,) = page.root.iterfind(".//figure[@id='groups']")
    words = figure.text_content()
    assert "bow" in words and "18 of 45 parameters" in words and "the ball's" not in words


@pytest.mark.slow
@by_table("options")
def test_the_command_in_the_report_makes_it_again(session, tmp_path, monkeypatch, options):
    monkeypatch.chdir(shutil.copytree(session, tmp_path / "session"))
    main(["solve", "front", "--test", "left", "--robot", "panda", *options, "--out", "one"])
    first = json.loads(Path("one/report.json").read_text())
    words = shlex.split(first["command"])
    assert words[:2] == ["mukca", "solve"]
    assert main([*words[1:], "--out", str(tmp_path / "two")]) == 0
    second = json.loads((tmp_path / "two/report.json").read_text())
    for key in ("parameters", "summary", "placements", "command"):
        assert second[key] == first[key]


@pytest.mark.parametrize("name", ["<script>alert(1)</script>", "</script><b>", "a&b\"'\x01", "π ✓"])
def test_names_from_files_are_text(document, written, read_page, name):
    for rows in (document["placements"], document["data"]):
        rows[1]["name"] = f"session/{name}"
    document["data"][0]["samples"][0]["where"] = f"{name}/panda_joint3:1"
    document["warnings"] = [name]
    file = written(document)
    main(["report", str(file)])
    html = (file.parent / "report.html").read_text()
    assert "<script>alert" not in html and "<b>" not in html
    page = read_page(file.parent / "report.html")
    shown = name.replace("\x01", "\N{REPLACEMENT CHARACTER}")
    assert any(shown in text for _, text in page.all("td"))
    assert any(shown == text for _, text in page.all("li"))
    (embedded,) = [text for a, text in page.all("script") if a.get("id") == "figures"]
    assert json.loads(embedded)["placements"][1]["name"] == f"session/{name}"


@pytest.mark.slow
def test_a_real_arm(recordings, tmp_path, read_page):
    folder, out = recordings / "panda_3", tmp_path / "panda_3"
    words = [str(folder / "frontcenter"), "--test", str(folder), "--method", "paper"]
    words += ["--distance", "0.05"]
    robot = ["--robot", str(folder / "nominal.urdf")]
    assert main(["solve", *words, *robot, "--out", str(out)]) == 0
    assert check_page(out, read_page) > 3 * 48 + 50
    assert (out / "report.html").stat().st_size < 8_000_000
    known = tmp_path / "holes.txt"
    known.write_text(hole_grid())
    main(["report", str(out / "calibration.json"), "--known", str(known), "--force"])
    rows = json.loads((out / "report.json").read_text())["between"]
    means = [np.mean([abs(row[f"{m}_error"]) for row in rows]) for m in ("nominal", "calibrated")]
    assert means == pytest.approx([0.83e-3, 0.32e-3], abs=5e-6)


def hole_grid():
    """Known distances of panda_3: all its sockets stand in a grid of holes."""
    return "\n".join(
        f"{a}:{k}-{b}:{k}={math.dist(HOLES[a], HOLES[b]) / 1e3}"
        for a, b in combinations(HOLES, 2)
        for k in (0, 1)
    )


def test_the_table_of_residuals_has_each_sample_of_the_figures(auto):
    """Its errors are those of the page: their median and rms are the placement's."""
    with (auto / "residuals.csv").open() as file:
        rows = list(csv.DictReader(file))
    report = json.loads((auto / "report.json").read_text())
    assert len(rows) == sum(sum(row["samples"]) for row in report["placements"])
    for placement in report["placements"]:
        mine = [row for row in rows if row["placement"] == placement["name"]]
        errors = np.array([float(row["calibrated_error [mm]"]) for row in mine]) / 1e3
        quantiles = placement["quantiles"]["calibrated"]
        assert {row["role"] for row in mine} == {placement["role"]}
        assert np.median(errors) == pytest.approx(quantiles["median"], abs=2e-8)
        assert np.sqrt(np.mean(errors**2)) == pytest.approx(quantiles["rms"], abs=2e-8)
        assert errors.std() == pytest.approx(quantiles["std"], abs=2e-8)

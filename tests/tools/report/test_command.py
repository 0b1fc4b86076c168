"""`mukca report` as a user meets it: what it writes, refuses, and prints."""

import io
import json
import shutil
from pathlib import Path

import pytest
from rich.console import Console

from mukca.tools.cli import main
from mukca.tools.report import show
from mukca.tools.report.console import sparkline
from mukca.tools.report.figures.types_report import read_report


@pytest.fixture
def run(capsys):
    def run(*words: str) -> tuple[int, str, str]:
        status = main(["report", *words])
        out, err = capsys.readouterr()
        return status, out, err

    return run


@pytest.fixture
def copy(calibrated, tmp_path) -> Path:
    return Path(shutil.copytree(calibrated, tmp_path / "copy"))


def test_solve_writes_the_same_report(run, copy) -> None:
    before = (copy / "report.html").read_bytes()
    status, out, _ = run(str(copy / "calibration.json"))
    assert status == 0 and "up to date" in out
    assert (copy / "report.html").read_bytes() == before


@pytest.mark.slow
def test_another_report_is_overwritten_only_by_force(run, copy) -> None:
    words = (str(copy / "calibration.json"), "--tolerance-mm", "1")
    before = (copy / "report.html").read_bytes()
    status, _, err = run(*words)
    assert status == 2 and "--force" in err and err.count("\n") == 1
    assert (copy / "report.html").read_bytes() == before
    status, out, _ = run(*words, "--force")
    assert status == 0 and "within 1 mm?" in out
    assert (copy / "report.html").read_bytes() != before


@pytest.mark.slow
def test_json_is_the_report(run, copy) -> None:
    _, out, err = run(str(copy / "calibration.json"), "--json")
    assert json.loads(out) == json.loads((copy / "report.json").read_text())
    assert "Verdict" in err


def test_open_without_a_screen_says_where_the_page_is(run, copy, monkeypatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setattr("webbrowser.open", lambda _: pytest.fail("opened"))
    _, out, _ = run(str(copy / "calibration.json"), "--open")
    assert f"copy {copy}/report.html" in out


def test_open_shows_the_page(run, copy, monkeypatch) -> None:
    opened: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    run(str(copy / "calibration.json"), "--open")
    assert opened == [(copy / "report.html").as_uri()]


@pytest.mark.parametrize(
    "damage",
    [
        lambda d: d.pop("summary"),
        lambda d: d.pop("history"),
        lambda d: d["model"].pop("nominal_urdf"),
        lambda d: d["data"][0]["samples"].clear(),
        lambda d: d["data"][0]["samples"][0].update(position=[0.1]),
        lambda d: d["data"][0]["samples"][0].update(position=["x"] * 7),
        lambda d: d["placements"].pop(),
        lambda d: d["parameters"][5].update(calibrated=float("nan")),
        lambda d: d["parameters"][10].update(calibrated=0.5),
        lambda d: d["provenance"].pop("versions"),
        lambda d: d["settings"].update(regularization="much"),
        lambda d: d["deflection"].update(harmonic_1=[1e-4]),
    ],
)
def test_a_damaged_calibration_gets_one_line(run, document, written, damage) -> None:
    damage(document)
    file = written(document)
    status, _, err = run(str(file))
    assert status == 2
    assert err.count("\n") == 1 and "Traceback" not in err
    assert not (file.parent / "report.html").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("missing.json",),
        ("--limit-mae-mm", "-1"),
        ("--repeatability-mm", "nan"),
        ("--tolerance-mm", "0"),
        ("--known", "nowhere.txt"),
        ("--known", "front:0-left:0=x"),
        ("--known", "front:0-left:0=-1"),
        ("--known", "front:0-elsewhere:0=0.3"),
        ("--known", "front:0-left:7=0.3"),
    ],
)
def test_bad_usage_gets_one_line(run, copy, words) -> None:
    file = () if words == ("missing.json",) else (str(copy / "calibration.json"),)
    status, _, err = run(*file, *words)
    assert status == 2 and err.count("\n") == 1


@pytest.mark.slow
def test_known_distances_come_from_a_file_too(run, copy, tmp_path) -> None:
    lines = tmp_path / "known.txt"
    lines.write_text("# measured with a caliper\nfront:0-left:0=0.43+-0.0001  # long one\n\n")
    run(str(copy / "calibration.json"), "--known", str(lines), "--force")
    (row,) = json.loads((copy / "report.json").read_text())["between"]
    assert row["distance"] == 0.43 and row["standard_deviation"] == 1e-4


def test_a_pipe_gets_text_and_a_terminal_curves(calibrated) -> None:
    figures = read_report(calibrated / "report.json")
    pipe, terminal = io.StringIO(), io.StringIO()
    show(Console(file=pipe, width=120), figures)
    show(Console(file=terminal, force_terminal=True, width=120), figures)
    assert "\x1b" not in pipe.getvalue() and "▁" not in pipe.getvalue()
    assert "▁" in terminal.getvalue() and "\x1b" in terminal.getvalue()
    for words in ("PASS", "front", "left", "Use:", "Next:", "Data:", "Not evaluated"):
        assert words in pipe.getvalue()


def test_a_sparkline_keeps_the_largest_of_each_stretch() -> None:
    import numpy as np

    values = np.zeros(100)
    values[37] = 1.0
    assert sorted(sparkline(values, 1.0, width=10)) == ["▁"] * 9 + ["█"]

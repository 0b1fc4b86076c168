"""Damaged and foreign files get one line that names the key; a bug in a plot is no damaged file."""

import copy
import json
from collections.abc import Iterator
from typing import Any

import pytest

from mukca import MukcaError
from mukca.solver.results import FORMAT, CalibrationDocument, DocumentError, encode
from mukca.solver.results.files import decode
from mukca.tools.cli import main
from mukca.tools.report import build_report
from mukca.tools.report.figures import ReportDocument
from mukca.tools.report.figures.types_report import FORMAT as REPORT
from mukca.tools.report.figures.types_report import read_report
from mukca.tools.report.plots import use

OPTIONAL = {
    "deviation",
    "distance_text",
    "todo",
    "expected",
    "before",
    "after",
    "map",
    "forecasts",
    "distance_source",
    "full",
    "full_status",
    "geometric_error",
    "scale",
    "ball_refitted",
    "checks",
    "choices",
    "coefficients",
    "geometric",
    "groups",
    "found_deviation",
    "log_evidence",
    "next_placement",
    "outlook",
    "noise",
    "predicted_deviation",
    "standard_deviation",
    "uncertainty",
    "weight",
    "where",
}
"""What only some methods leave in the file; elsewhere it may be called the same."""
REQUIRED = {
    ("checks", 0, "where"),
    ("coefficients", 0, "standard_deviation"),
    ("uncertainty", "weak_directions", 0, "deviation"),
}
FREE = {"settings", "versions", "data_sha256", "outputs", "deflection"}
"""Whose keys are names, which may be any."""

Path = tuple[str | int, ...]


def paths(value: Any, path: Path = ()) -> Iterator[Path]:
    """Every key of a document, of lists the first item's, as the way to it."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield (*path, key)
            yield from paths(inner, (*path, key))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        yield from paths(value[0], (*path, 0))


def shortened(value: Any) -> Any:
    """Return a document whose lists of objects and of rows end after the first."""
    if isinstance(value, dict):
        return {key: shortened(inner) for key, inner in value.items()}
    if isinstance(value, list) and value and isinstance(value[0], dict | list):
        return [shortened(value[0])]
    return value


def at(document: Any, path: Path) -> Any:
    for key in path:
        document = document[key]
    return document


def read(document: dict[str, Any]) -> None:
    data = json.dumps(document).encode()
    build_report(decode(data, CalibrationDocument, FORMAT, "file.json"), "file.json")


def message(document: dict[str, Any]) -> str:
    """Return the one line about a damaged document."""
    with pytest.raises(MukcaError) as caught:
        read(document)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("file.json: ")
    return str(caught.value)


@pytest.mark.slow
def test_each_key_that_is_gone_is_named(extended) -> None:
    ways = list(paths(extended))
    assert len(ways) > 120
    for path in ways:
        if path[0] in FREE or (path[0] == "provenance" and len(path) > 2):
            continue
        damaged = copy.deepcopy(extended)
        del at(damaged, path[:-1])[path[-1]]
        if path[-1] in OPTIONAL and path not in REQUIRED:
            decode(json.dumps(damaged).encode(), CalibrationDocument, FORMAT, "")
        else:
            assert f"`{path[-1]}`" in message(damaged), path


def test_without_what_only_some_methods_leave_a_report_is_made(extended) -> None:
    for path in [*paths(extended)][::-1]:
        if path[-1] in OPTIONAL and path not in REQUIRED:
            del at(extended, path[:-1])[path[-1]]
    read(extended)


@pytest.mark.slow
def test_each_value_of_another_kind_is_named(extended) -> None:
    for path in paths(extended):
        damaged = copy.deepcopy(extended)
        at(damaged, path[:-1])[path[-1]] = [{"wrong": "kind"}]
        if path[0] == "settings" and len(path) > 1:
            continue
        said = message(damaged)
        names = [f"`{key}`" for key in path if isinstance(key, str)]
        assert str(path[-1]) in said or names[-1] in said or "[...]" in said, (path, said)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("data", 0, "role"), "both", "$.data[0].role"),
        (("data", 0, "samples", 0, "position"), [0.1], "`data[0].samples[0].position`"),
        (("data", 0, "samples", 0, "effort"), [0.1], "`data[0].samples[0].effort`"),
        (("data", 0, "samples"), [], "`data[0].samples`"),
        (("data",), [], "`data`"),
        (("placements",), [], "`placements`"),
        (("placements", 0, "name"), "another", "`placements`"),
        (("placements", 0, "role"), "test", "`placements`"),
        (("placements", 0, "calibrated", "mean_absolute_error"), 1.0, "`placements`"),
        (("summary", "train"), None, "`summary.train`"),
        (("summary", "test"), None, "`summary.test`"),
        (("history", 0), {"iteration": 0, "train": None, "test": None}, "`history[0]`"),
        (("parameters", 0, "name"), "elbow.x", "`parameters`"),
        (("deflection",), {"springs": [1.0]}, "`deflection.springs`"),
        (("deflection",), {"compliance": [1.0]}, "`deflection.compliance`"),
        (("settings", "regularization"), "much", "`settings.regularization`"),
        (("model", "nominal_urdf"), "<robot", "`model`: nominal_urdf:1: not XML"),
        (("model", "tip"), "nowhere", "`model`: panda: no link is called 'nowhere'"),
    ],
)
def test_parts_that_do_not_fit_each_other_are_named(document, path, value, said) -> None:
    at(document, path[:-1])[path[-1]] = value
    assert said in message(document)


@pytest.mark.parametrize("verb", ["report", "compare"])
@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text[: len(text) // 2], "not a calibration.json"),
        (lambda text: "", "not a calibration.json"),
        (lambda text: "[" * 100_000, "not a calibration.json"),
        (lambda text: text.replace('"data"', '"dada"', 1), "`data`"),
        (lambda text: text.replace('"load": {"gravity": [0.0', '"load": {"gravity": [NaN'), "NaN"),
        (lambda text: text.replace("mukca-calibration-1", "mukca-report-1"), "mukca-calibration-1"),
        (lambda text: '{"format": 3}', "$.format"),
    ],
)
def test_a_file_that_cannot_be_read_gets_one_line(
    calibrated, tmp_path, capsys, verb, damage, said
) -> None:
    text = json.dumps(json.loads((calibrated / "calibration.json").read_text()))
    file = tmp_path / "calibration.json"
    file.write_text(damage(text))
    assert main([verb, str(file)]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and str(file) in err and said in err
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("mistake", [TypeError, KeyError, ValueError, AttributeError, IndexError])
def test_a_bug_in_a_plot_is_a_traceback(document, typed, monkeypatch, mistake) -> None:
    def broken(*_: Any) -> None:
        raise mistake("a bug")

    monkeypatch.setattr(use, "map_sentence", broken)
    with pytest.raises(mistake, match="a bug") as caught:
        build_report(typed(document), "")
    assert not isinstance(caught.value, MukcaError)


def test_a_report_is_read_back_as_it_was_written(calibrated, extended, typed) -> None:
    data = (calibrated / "report.json").read_bytes()
    assert encode(read_report(calibrated / "report.json")) + b"\n" == data
    figures = build_report(typed(extended), "").figures
    assert decode(encode(figures), ReportDocument, REPORT, "") == figures


@pytest.mark.slow
def test_each_key_that_a_report_lacks_is_named(calibrated) -> None:
    report = shortened(json.loads((calibrated / "report.json").read_text()))
    for path in paths(report):
        if path[-1] in OPTIONAL or (path[0] == "provenance" and len(path) > 2):
            continue
        damaged = copy.deepcopy(report)
        del at(damaged, path[:-1])[path[-1]]
        with pytest.raises(DocumentError, match=f"`{path[-1]}`"):
            decode(json.dumps(damaged).encode(), ReportDocument, REPORT, "")


def test_a_report_without_what_later_versions_added_is_read(calibrated) -> None:
    report = json.loads((calibrated / "report.json").read_text())
    for key in ("todo", "distance_text", "scale"):
        report.pop(key, None)
    read_again = decode(json.dumps(report).encode(), ReportDocument, REPORT, "")
    assert (read_again.todo, read_again.distance_text) == ((), "")


def test_a_folder_whose_name_is_not_utf_8_does_not_hurt(document) -> None:
    document["data"][0]["files"] = ["front\udcff/hole_0.csv"]
    read(document)

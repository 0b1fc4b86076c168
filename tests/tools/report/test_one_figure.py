"""One quantity has one figure, wherever it stands."""

import json
import re

import pytest

pytestmark = pytest.mark.slow
CASES = [
    ("panda", "panda_3", ["frontcenter"], ["frontleft", "backleft"]),
    ("panda", "panda_1", ["front"], ["right"]),
]
"""Robot, recordings, placements trained on and held out."""
FIRST = re.compile(r"is wrong by about (\S+) mm \(was (\S+)\)")


@pytest.fixture(params=CASES, ids=lambda case: case[1])
def written(request, recordings, tmp_path, command):
    """What `solve` says of shared recordings, and the folder that it writes with a certificate."""
    robot, name, train, test = request.param
    folder, out = recordings / name, tmp_path / "out"
    train, test = [[folder / place for place in places] for places in (train, test)]
    words = (*train, "--test", *test, "--robot", robot, "--distance", "0.05", "--out", out)
    said = command("solve", *words, "--details")[1]
    command("report", out, "--certificate", out / "sheet.html", "--force")
    return said, out


def shown(metres):
    """Millimetres as the answer has them: two digits that count."""
    value = 1e3 * metres
    return f"{value:.{0 if value >= 9.95 else 1 if value >= 0.995 else 2}f}"


def test_the_error_of_distances_has_one_figure(written):
    """In terminal, page, JSON, certificate, limits and the next step."""
    said, out = written
    calibration = json.loads((out / "calibration.json").read_text())
    report = json.loads((out / "report.json").read_text())
    errors = calibration["better"]["workspace"]
    now, before = errors["now"], errors["before"]
    figures = shown(now["value"]), shown(before["value"])
    pages = [(out / name).read_text() for name in ("report.html", "sheet.html")]
    for text in (said, report["verdict"]["answer"][0], *pages):
        assert set(FIRST.findall(text)) == {figures}
    interval = f"now {figures[0]} (68 %: {shown(now['low'])} to {shown(now['high'])})"
    assert interval in said and interval in pages[0]
    (limit,) = [row for row in report["verdict"]["limits"] if row["name"] == "predicted_distance"]
    assert limit["found"] == now["value"] and limit["interval"] == now
    assert f"expects {1e3 * now['value']:.2f} mm" in report["answers"]["use"]["between"]
    for step in report.get("todo", []):
        if "a distance in the workspace is wrong by about" in step["expected"]:
            assert step["before"] == now["value"] > step["after"]
            assert f"in place of {figures[0]}" in step["expected"]

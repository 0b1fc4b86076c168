"""What tests of the report share: calibrations of a simulated arm, and a reader of pages."""

import json
from itertools import count
from pathlib import Path

import pytest
from lxml.html import fromstring

from mukca.tools.cli import main


class Page:
    """The elements of a page: attributes and whole text, by tag."""

    def __init__(self, html):
        self.root = fromstring(html)

    def all(self, tag):
        return [(one.attrib, one.text_content()) for one in self.root.iter(tag)]

    def having(self, attribute):
        found = self.root.iterfind(f".//*[@{attribute}]")
        return [(one.attrib, one.text_content()) for one in found]


@pytest.fixture(scope="session")
def read_page():
    return lambda file: Page(file.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def calibrated(session, shared):
    """A folder with the calibration of the simulated session, trained on the front."""
    held_out = [str(session / "left"), str(session / "right")]
    words = [str(session / "front"), "--test", *held_out, "--robot", "panda", "--method", "paper"]

    def make(out):
        assert main(["solve", *words, "--out", str(out)]) == 0

    return shared("calibrated", make)


@pytest.fixture(scope="session")
def auto(session, shared):
    """The same, by the default method."""
    held_out = [str(session / "left"), str(session / "right")]

    def make(out):
        words = [str(session / "front"), "--test", *held_out, "--robot", "panda"]
        main(["solve", *words, "--out", str(out)])

    return shared("auto", make)


@pytest.fixture
def document(calibrated):
    """The calibration's file, to be changed at will."""
    return json.loads((calibrated / "calibration.json").read_text())


@pytest.fixture
def written(tmp_path):
    """Write a document to a folder of its own and return the file."""
    numbers = count()

    def write(document):
        folder = tmp_path / f"changed-{next(numbers)}"
        folder.mkdir()
        file = folder / "calibration.json"
        file.write_text(json.dumps(document))
        return file

    return write


@pytest.fixture
def report(written):
    """Return the figures of a document's report."""

    def report(document, *options):
        file = written(document)
        assert main(["report", str(file), *options]) in (0, 1, 3)
        return json.loads((file.parent / "report.json").read_text())

    return report


@pytest.fixture
def extended(document):
    """The document as a method that knows its own uncertainty leaves it."""
    for row in document["parameters"]:
        row["standard_deviation"] = 3e-4 if row["unit"] == "m" else 5e-4
    document.update(json.loads(Path(__file__).with_name("extended.json").read_text()))
    for row in document["placements"]:
        row.update(predicted_deviation=1.5e-4, found_deviation=1.8e-4)
    for row in document["data"]:
        for sample in row["samples"]:
            sample["weight"] = 0.25 if sample is row["samples"][0] else 1.0
    for summary in document["summary"].values():
        summary["geometric"] = dict(summary["calibrated"], mean_absolute_error=2e-4)
    return document

"""What tests of the report share: calibrations of a simulated arm, and a reader of pages."""

import json
import os
import re
from html.parser import HTMLParser
from itertools import count
from pathlib import Path

import pytest

from mukca.tools.cli import main

VOID = {"meta", "link", "input", "br", "img"}
INLINE = {"a", "code", "i", "label", "option", "select", "small", "span", "strong", "input"}
UNREAD = {"details", "script", "style", "svg", "title"}


class Page(HTMLParser):
    """The elements of a page: attributes and whole text, by tag."""

    def __init__(self, html):
        super().__init__()
        self.elements = []
        self.open = []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, {key: value or "" for key, value in attrs}, []))
        if tag not in VOID:
            self.open.append(len(self.elements) - 1)

    def handle_endtag(self, tag):
        while self.elements[self.open.pop()][0] != tag:
            pass

    def handle_data(self, data):
        for i in self.open:
            self.elements[i][2].append(data)

    def all(self, tag):
        return [(a, "".join(words)) for name, a, words in self.elements if name in (tag, "")]

    def having(self, attribute):
        return [(a, "".join(words)) for _, a, words in self.elements if attribute in a]


class PageText(HTMLParser):
    """The words that a page says, a line for each paragraph, row or item; no plots, no details."""

    def __init__(self, html):
        super().__init__()
        self.words = []
        self.unread = 0
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.unread += tag in UNREAD
        self.words += [] if tag in INLINE else [" | " if tag in ("td", "th") else "\0"]

    def handle_endtag(self, tag):
        self.unread -= tag in UNREAD
        self.words += [] if tag in (*INLINE, "td", "th") else ["\0"]

    def handle_data(self, data):
        self.words += [] if self.unread else [data]

    @property
    def lines(self):
        lines = [" ".join(line.split()) for line in "".join(self.words).split("\0")]
        return [line for line in lines if re.search(r"\w", line)]


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]\d+)?")
PASSING = re.compile(r"/\S*/(?=session/|arms/)|\d{4}-\d\d-\d\d(T\S*)?|\b[0-9a-f]{64}\b")
"""Folders, dates and digests: they differ from run to run."""


@pytest.fixture(scope="session")
def says():
    """Compare what a page says with what it said; numbers may differ in the last digit.

    After a change that is meant: ``MUKCA_KEEP_PAGES=1 pytest tests/tools/report``, and look at it.
    """

    def says(name, html):
        lines = [PASSING.sub("*", line) for line in PageText(html).lines]
        lines = [line for line in lines if not line.startswith("| versions")]
        file = Path(__file__).parent / "pages" / f"{name}.txt"
        if os.environ.get("MUKCA_KEEP_PAGES"):
            file.write_text("\n".join(lines) + "\n")
        kept = file.read_text().splitlines()
        assert [NUMBER.sub("#", line) for line in lines] == [NUMBER.sub("#", line) for line in kept]
        for line, old in zip(lines, kept, strict=True):
            for one, other in zip(NUMBER.findall(line), NUMBER.findall(old), strict=True):
                digit = 10.0 ** -len(other.partition(".")[2])
                assert float(one) == pytest.approx(float(other), abs=2 * digit), (line, old)

    return says


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
    document["groups"] = [
        {
            "name": "translation",
            "unit": "m",
            "count": 24,
            "width": 4e-4,
            "effective": 11.25,
            "active": True,
        },
        {
            "name": "harmonic_2",
            "unit": "rad",
            "count": 14,
            "width": 0.0,
            "effective": 0.0,
            "active": False,
        },
    ]
    document["noise"] = {"space": 1.1e-4, "joint": 2e-4, "nu": 5.0}
    document["uncertainty"] = {
        "weak_directions": [{"text": "sliding along panda_joint3's axis", "deviation": 0.9}],
        "correlations": [{"a": "panda_joint5.x", "b": "ball_joint.x", "value": 0.94}],
        "observability_index": 0.0123,
        "distance_deviation": {"median": 1.25e-4, "worst": 3.5e-4},
        "cannot_see": ["what the flange's orientation is"],
    }
    for row in document["placements"]:
        row.update(predicted_deviation=1.5e-4, found_deviation=1.8e-4)
    for row in document["data"]:
        for sample in row["samples"]:
            sample["weight"] = 0.25 if sample is row["samples"][0] else 1.0
    document["checks"] = [
        {"level": "ok", "code": "a", "where": "", "text": "all joints moved", "advice": ""},
        {
            "level": "warning",
            "code": "far",
            "where": "left/hole_0.csv:3",
            "text": "far from its socket",
            "advice": "look at it",
        },
    ]
    document["next_placement"] = {"text": "Record behind the arm."}
    document["coefficients"] = [
        {
            "name": f"panda_joint{i}.{kind}",
            "unit": unit,
            "value": value * i,
            "standard_deviation": 0.2 * value,
        }
        for i in range(1, 8)
        for kind, unit, value in (("compliance", "rad/(N m)", 2e-5), ("sin1", "rad", 1e-4))
    ]
    document["choices"] = ["compliance: kept (log evidence +20.3)"]
    for summary in document["summary"].values():
        summary["geometric"] = dict(summary["calibrated"], mean_absolute_error=2e-4)
    return document

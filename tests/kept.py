"""Texts that stay as they were until a change is meant."""

import os
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

PAGES = Path(__file__).parent / "tools" / "report" / "pages"
INLINE = {"a", "code", "i", "label", "option", "select", "small", "span", "strong", "input"}
UNREAD = {"details", "script", "style", "svg", "title"}


def compare(file, lines):
    """Compare lines with those kept in a file; ``MUKCA_KEEP_PAGES=1`` writes it anew first."""
    if os.environ.get("MUKCA_KEEP_PAGES"):
        file.write_text("".join(f"{line}\n" for line in lines))
    assert lines == file.read_text().splitlines()


def measures(file, lengths):
    """Compare lengths by name [m] with those kept in a file, to 1e-9 m.

    After a change that is meant: ``MUKCA_KEEP_PAGES=1 pytest tests/solver/test_golden.py``.
    """
    if os.environ.get("MUKCA_KEEP_PAGES"):
        lines = [f"{name} {1e3 * length:.7f} mm\n" for name, length in lengths.items()]
        file.write_text("".join(lines))
    rows = [line.rsplit(" ", 2) for line in file.read_text().splitlines()]
    kept = {name: 1e-3 * float(number) for name, number, _ in rows}
    assert kept, f"nothing is kept in {file}"
    assert lengths == pytest.approx(kept, rel=0, abs=1e-9)


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


def says(name, html):
    """Compare what a page says with what it said; numbers may differ in the last digit.

    After a change that is meant: ``MUKCA_KEEP_PAGES=1 pytest tests/tools``, and look at it.
    """
    lines = [PASSING.sub("*", line) for line in PageText(html).lines]
    lines = [line for line in lines if not line.startswith("| versions")]
    file = PAGES / f"{name}.txt"
    if os.environ.get("MUKCA_KEEP_PAGES"):
        file.write_text("\n".join(lines) + "\n")
    kept = file.read_text().splitlines()
    assert [NUMBER.sub("#", line) for line in lines] == [NUMBER.sub("#", line) for line in kept]
    for line, old in zip(lines, kept, strict=True):
        for one, other in zip(NUMBER.findall(line), NUMBER.findall(old), strict=True):
            digit = 10.0 ** -len(other.partition(".")[2])
            assert float(one) == pytest.approx(float(other), abs=2 * digit), (line, old)


UNLIKE = 6.0
"""Mean absolute difference of grey, 0 to 255, by which a picture no longer shows the same page.

Letters larger by 4 % make 5 at most; without one of its sections a page differs
by 8 and more on a narrow screen.
"""


def pictures(name, thumbnails):
    """Compare grey pictures with those kept side by side in a file; see :func:`compare`.

    No two runs draw quite the same, so a picture that looks as it did is not written anew.
    """
    from PIL import Image

    file = PAGES / f"{name}.png"
    strip = np.hstack(list(thumbnails.values()))
    kept = np.asarray(Image.open(file), dtype=float) if file.exists() else np.empty(0)
    unlike = dict.fromkeys(thumbnails, np.inf)  # it is not there, or has other views
    if kept.shape == strip.shape:
        apart = np.abs(kept - strip).reshape(len(strip), len(thumbnails), -1).mean(axis=(0, 2))
        unlike = dict(zip(thumbnails, apart.round(1).tolist(), strict=True))
    alike = max(unlike.values()) <= UNLIKE
    if os.environ.get("MUKCA_KEEP_PAGES") and not alike:
        Image.fromarray(strip).save(file, optimize=True)
        return
    assert alike, f"{file}: it looks otherwise, by view: {unlike}"

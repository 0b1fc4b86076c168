"""The built site shows what the pages say: boxes, lists, formulas, links; in a browser, too."""

import os
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest
from lxml.html import fromstring

pytest.importorskip("mkdocs")
ROOT = Path(__file__).parents[1]
BY_CODE = {"api.md", "examples.md"}
"""Pages whose boxes are taken from the code."""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(shared):
    def make(out):
        command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(out)]
        env = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
        done = subprocess.run(command, cwd=ROOT, env=env, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    return shared("site", make)


QUERIES = {
    "NOT ENOUGH DATA": "report.html",
    "sockets-at": "frames.html",
    "own column names": "tables.html",
    "joint-table": "corrections.html",
    "calibrate again": "hold.html",
    "mukca.toml": "use.html",
    "exit status": "messages.html",
    "what to buy": "print.html",
    "print settings": "print.html",
    "caliper": "print.html",
    "lerobot": "so101.html",
    "freedrive": "universal-robots.html",
    "DH table": "use.html",
    "hand-eye camera": "handeye.html",
    "tool centre point": "hold.html",
    "left out": "verdict.html",
    "rosbag": "extract.html",
    "BASE MOVED": "causes/base_moved.html",
    "own URDF": "new-arm.html",
    "Tab key": "install.html",
}
"""What a user types, and the page that is meant."""


class Page:
    """The main text of a page: code boxes, items of numbered lists, links, and words."""

    def __init__(self, file):
        (article,) = fromstring(file.read_bytes()).xpath("//article")
        self.boxes, self.items = (len(article.xpath(f".//{way}")) for way in ("pre", "ol//li"))
        self.links = article.xpath(".//@href | .//@src")
        words = article.xpath(".//text()[not(ancestor::pre or ancestor::code)]")
        self.words = "".join(words)


def _pages():
    return (page for page in sorted((ROOT / "docs").glob("*.md")) if page.name not in BY_CODE)


def test_every_page_is_built_as_it_is_written(site):
    wrong = []
    for source in _pages():
        text, built = source.read_text(), Page(site / f"{source.stem}.html")
        fences = len(re.findall(r"^ *```", text, re.M)) // 2
        prose = re.sub(r"^ *```.*?^ *```", "", text, flags=re.M | re.S)
        steps = len(re.findall(r"^\d+\. ", prose, re.M))
        if built.boxes != fences:
            wrong.append(f"{source.name}: {fences} boxes became {built.boxes}")
        if built.items != steps:
            wrong.append(f"{source.name}: {steps} numbered steps became {built.items}")
        wrong += [
            f"{source.name}: a raw {raw}" for raw in ("\\|", "$", "```") if raw in built.words
        ]
        for link in built.links:
            path = unquote(link.partition("#")[0])
            if path and "://" not in path and not (site / path).exists():
                wrong.append(f"{source.name}: {link} leads nowhere")
    assert wrong == []


def test_the_site_works_from_the_disk_on_every_screen(site, tab):
    from playwright.sync_api import TimeoutError as TooLate

    wrong = []
    tab.on("pageerror", lambda error: wrong.append(f"{tab.url}: {error}"))
    tab.on("request", lambda asked: asked.url.startswith("http") and wrong.append(asked.url))
    for source in _pages():
        tab.goto((site / f"{source.stem}.html").as_uri())
        for width, scheme in ((390, "dark"), (1280, "light")):
            tab.emulate_media(color_scheme=scheme)
            tab.set_viewport_size({"width": width, "height": 844})
            fits = f"document.documentElement.scrollWidth <= {width}"
            try:  # a page is laid out again some time after the window changed
                tab.wait_for_function(fits, timeout=60_000)
            except TooLate:
                wrong.append(f"{source.name}: wider than {width} pixels")
        wrong += tab.evaluate(
            "[...document.querySelectorAll('article img')]"
            ".filter(img => !img.complete || !img.naturalWidth).map(img => img.src)"
        )
    assert wrong == []


def test_a_search_finds_the_page_that_is_meant(site, tab):
    """Among the first three; by the site's own search, which no address of the reference is in."""
    tab.goto((site / "index.html").as_uri())
    box = tab.get_by_placeholder("Search")
    box.click()
    wrong = {}
    for query, page in QUERIES.items():
        for words, count in (("", "== 0"), (query, "> 0")):
            box.fill(words)
            box.press("End")
            items = "document.querySelectorAll('.md-search-result__item')"
            tab.wait_for_function(f"{items}.length {count}", timeout=60_000)
        links = tab.evaluate(f"Array.from({items}, item => item.querySelector('a').pathname)")
        first = [link.partition("/site/")[2] for link in links[:3]]
        if page not in first or "api.html" in links:
            wrong[query] = first
    assert wrong == {}

"""How pages look, on wide and narrow screens, light, dark and printed: small grey pictures."""

from base64 import b64encode
from io import BytesIO
from pathlib import Path

import kept
import numpy as np
import pytest
from kept import pictures

from mukca.tools.cli import main

Image = pytest.importorskip("PIL.Image")
matplotlib = pytest.importorskip("matplotlib")

pytestmark = pytest.mark.slow

WIDE, NARROW, A4 = (1280, 800), (390, 844), (794, 1123)
VIEWS = {
    "wide": (WIDE, "screen", "light"),
    "wide dark": (WIDE, "screen", "dark"),
    "narrow": (NARROW, "screen", "light"),
    "narrow dark": (NARROW, "screen", "dark"),
    "printed": (A4, "print", "light"),
}
"""Size of the window [pixels], medium, and colours."""
REPORT, SHEET = (64, 192), (16, 24)
"""Sizes that a whole page is reduced to [pixels]: of text alone so small that lines blur."""


@pytest.fixture(scope="module")
def style():
    """The style of all pictures: one font on every computer, and nothing that turns in 3-D."""
    font = Path(matplotlib.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf").read_bytes()
    source = f"url(data:font/ttf;base64,{b64encode(font).decode()})"
    face = f"@font-face {{font-family: kept; src: {source}}}"
    return f"{face} * {{font-family: kept !important}} canvas {{visibility: hidden}}"


@pytest.fixture(scope="module")
def tab(chromium):
    with chromium.new_page(bypass_csp=True) as tab:  # pages load no font
        yield tab


def looks(tab, style, file, size):
    """The whole page in each view, as grey thumbnails."""
    thumbnails = {}
    for name, ((width, height), medium, colours) in VIEWS.items():
        tab.set_viewport_size({"width": width, "height": height})
        tab.emulate_media(media=medium, color_scheme=colours)
        tab.goto(file.as_uri())
        tab.add_style_tag(content=style)
        tab.evaluate("document.fonts.load('16px kept')")
        picture = tab.screenshot(full_page=True)
        picture = Image.open(BytesIO(picture)).convert("L")
        thumbnails[name] = np.asarray(picture.resize(size, Image.Resampling.BOX))
    return thumbnails


def test_only_a_picture_that_looks_otherwise_is_written_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(kept, "PAGES", tmp_path)
    grey = np.full((4, 4), 100, np.uint8)
    for keep, views, written in (
        ("", {"wide": grey}, None),
        ("1", {"wide": grey}, grey),
        ("1", {"wide": grey + 3}, grey),
        ("1", {"wide": grey + 30}, grey + 30),
        ("", {"wide": grey}, None),
        ("1", {"wide": grey, "narrow": grey}, np.hstack([grey, grey])),
    ):
        monkeypatch.setenv("MUKCA_KEEP_PAGES", keep)
        if written is None:
            with pytest.raises(AssertionError, match="it looks otherwise"):
                kept.pictures("page", views)
        else:
            kept.pictures("page", views)
            assert np.array_equal(np.asarray(Image.open(tmp_path / "page.png")), written)


def test_the_report_looks_as_it_did(tab, style, auto):
    pictures("auto", looks(tab, style, auto / "report.html", REPORT))


def test_the_certificate_looks_as_it_did(tab, style, auto, tmp_path):
    sheet = tmp_path / "sheet.html"
    main(
        [
            "report",
            str(auto / "calibration.json"),
            "--out",
            str(tmp_path),
            "--certificate",
            str(sheet),
        ]
    )
    pictures("certificate", looks(tab, style, sheet, SHEET))

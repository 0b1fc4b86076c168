"""How pages look, on wide and narrow screens, light, dark and printed: small grey pictures."""

from io import BytesIO

import numpy as np
import pytest
from kept import pictures

from mukca.tools.cli import main

Image = pytest.importorskip("PIL.Image")

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
def tab(chromium):
    return chromium.new_context().new_page()


def looks(tab, file, size):
    """The whole page in each view, as grey thumbnails without what turns in 3-D."""
    thumbnails = {}
    for name, ((width, height), medium, colours) in VIEWS.items():
        tab.set_viewport_size({"width": width, "height": height})
        tab.emulate_media(media=medium, color_scheme=colours)
        tab.goto(file.as_uri())
        picture = tab.screenshot(full_page=True, style="canvas {visibility: hidden}")
        picture = Image.open(BytesIO(picture)).convert("L")
        thumbnails[name] = np.asarray(picture.resize(size, Image.Resampling.BOX))
    return thumbnails


def test_the_report_looks_as_it_did(tab, auto):
    pictures("auto", looks(tab, auto / "report.html", REPORT))


def test_the_certificate_looks_as_it_did(tab, auto, tmp_path):
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
    pictures("certificate", looks(tab, sheet, SHEET))

"""Letters to engrave, as outlines of strokes; one of 0.9 mm is two lines of a 0.4 mm nozzle."""

import itertools
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from .solid import Outline, Prism, Solid

if TYPE_CHECKING:
    from manifold3d import CrossSection

HEIGHT = 5.4
"""Height of a letter at scale 1, strokes included [mm]."""
STROKE = 0.9
DEPTH = 0.8

_WIDTH, _RISE = 2.4, 4.5  # of a letter, between the middles of its outermost strokes
_GAP = 1.2  # between the strokes of neighbouring letters

# Corners of polylines, on a grid of 2 by 4; digits are those of a seven-segment display.
_STROKES: dict[str, tuple[str, ...]] = {
    "0": ("00 20 24 04 00",),
    "1": ("10 14 03",),
    "2": ("04 24 22 02 00 20",),
    "3": ("04 24 20 00", "02 22"),
    "4": ("04 02 22", "24 20"),
    "5": ("24 04 02 22 20 00",),
    "6": ("24 04 00 20 22 02",),
    "7": ("04 24 20",),
    "8": ("00 20 24 04 00", "02 22"),
    "9": ("22 02 04 24 20 00",),
    ".": ("00 00",),
    "I": ("00 04",),
    "n": ("00 02 22 20",),
    "O": ("00 20 24 04 00",),
    "T": ("10 14", "04 24"),
    "U": ("04 00 20 24",),
    "Z": ("04 24", "24 00", "00 20"),
    " ": (),
}
_NARROW = {".": 0.0, "I": 0.0, " ": 0.4, "1": 1.2}  # widths that differ from _WIDTH


def text_width(text: str, scale: float = 1.0) -> float:
    """Return the width of a line of text, strokes included [mm]."""
    return scale * (sum(_advance(letter) for letter in text) - _GAP)


def engraving(text: str, x: float, y: float, top: float, scale: float = 1.0) -> Solid:
    """Return the tool that engraves a line of text about x, y into a flat top [mm]."""
    outlines = _outlines(text, scale)
    middle_x = x - (text_width(text, scale) - scale * STROKE) / 2
    tool = Prism(outlines, DEPTH + 1.0)
    return tool.at(middle_x, y - scale * _RISE / 2, top - DEPTH)


def _outlines(text: str, scale: float) -> tuple[Outline, ...]:
    from manifold3d import CrossSection, OpType

    bars: list[CrossSection] = []
    left = 0.0
    for letter in text:
        for stroke in _STROKES[letter]:
            width = _NARROW.get(letter, _WIDTH)
            words = [(int(word[0]) / 2, int(word[1]) / 4) for word in stroke.split()]
            corners = [(left + x * width, y * _RISE) for x, y in words]
            bars += [_bar(a, b) for a, b in itertools.pairwise(corners)]
        left += _advance(letter)
    shape = CrossSection.batch_boolean(bars, OpType.Add).scale((scale, scale))
    rings: list[np.ndarray] = cast("Any", shape).to_polygons()
    return tuple(tuple((float(x), float(y)) for x, y in ring) for ring in rings)


def _bar(start: tuple[float, float], end: tuple[float, float]) -> "CrossSection":
    from manifold3d import CrossSection

    square = CrossSection.square((STROKE, STROKE), True)
    return CrossSection.batch_hull([square.translate(start), square.translate(end)])


def _advance(letter: str) -> float:
    return _NARROW.get(letter, _WIDTH) + STROKE + _GAP

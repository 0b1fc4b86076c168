"""Dimensioned drawings of parts as SVG, scale 1:1, from the front, as printed, and above [mm]."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .kernels import to_manifold
from .solid import Solid

if TYPE_CHECKING:
    from jinja2 import Environment

MARGIN, STEP = 28.0, 8.0  # around a view, and between two dimensions
COARSE = 0.02  # chords are so far from round lines


@cache
def templates() -> "Environment":
    """Return the templates of files."""
    from jinja2 import Environment, FileSystemLoader

    folder = FileSystemLoader(Path(__file__).parent / "templates")
    return Environment(loader=folder, trim_blocks=True)  # noqa: S701 (texts are escaped one by one)


def drawing_bytes(
    title: str,
    solid: Solid,
    levels: Sequence[tuple[float, float]],
    circles: Sequence[tuple[float, str]],
    notes: Sequence[str],
) -> bytes:
    """Return a drawing with heights between levels, circles of holes by diameter, and notes."""
    body: Any = to_manifold(solid, COARSE)
    low, high = np.reshape(np.array(body.bounding_box()), (2, 3))
    (wide, _, tall), middle = high - low, MARGIN - low[0]
    front = MARGIN + tall  # where z = 0 is drawn
    above = front + MARGIN + high[1]
    foot = above - low[1] + MARGIN
    paths = [
        _path(body.rotate((-90, 0, 0)), middle, front),
        _path(body, middle, above),
    ]
    dimensions = [
        *(
            _dimension(MARGIN + wide + STEP * i, front - a, MARGIN + wide + STEP * i, front - b)
            for i, (a, b) in enumerate(((low[2], high[2]), *levels), 1)
        ),
        _dimension(MARGIN, front + STEP, MARGIN + wide, front + STEP),
        _dimension(MARGIN - STEP, above - low[1], MARGIN - STEP, above - high[1]),
    ]
    words: dict[str, Any] = {
        "title": title,
        "width": round(max(wide + 2 * MARGIN + STEP * len(levels), 210), 1),
        "height": round(foot + 6 * len(notes) + 6, 1),
        "foot": round(foot, 1),
    }
    page = templates().get_template("drawing.svg.j2")
    marks = [
        {
            "x": round(middle, 2),
            "y": round(above, 2),
            "r": d / 2,
            "far": MARGIN + wide + 2,
            "text": t,
        }
        for d, t in circles
    ]
    lines = {"paths": paths, "dimensions": dimensions, "circles": marks, "notes": notes}
    return page.render(**lines, **words).encode()


def _path(body: Any, x: float, y: float) -> str:
    """Return the outline of a body's shadow along z, its origin drawn at x, y."""
    rings = (ring * (1, -1) + (x, y) for ring in body.project().to_polygons())
    return "".join("M" + "L".join(f"{a:.2f} {b:.2f}" for a, b in ring) + "Z" for ring in rings)


def _dimension(x1: float, y1: float, x2: float, y2: float) -> dict[str, Any]:
    """Return a line between two points, upright or level, with its length."""
    upright, text = x1 == x2, f"{abs(x2 - x1) + abs(y2 - y1):.4g}"
    ends = {"x1": x1, "y1": y1, "x2": x2, "y2": y2, "x": (x1 + x2) / 2, "y": (y1 + y2) / 2}
    ends["x" if upright else "y"] -= 1
    return {name: round(float(v), 2) for name, v in ends.items()} | {
        "upright": upright,
        "text": text,
    }

"""Plots of a page: panels of usual shapes, and the sentence that says what they show here."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ....solver.results import ModelName
from ..figures import PlotCaption, ReportDocument, lines
from .axis import Axis
from .panel import BOTTOM, LEFT, RIGHT, TOP, WIDTH, Panel

LINE = 14
"""Height of a line of text: names of rows that are closer are left out."""
LONGEST = 18
"""Letters of a row's name that are shown."""
TALLEST = 420
"""Height of a panel to scale, without its margins, at most."""
FROM_ABOVE = ("m to the robot's right", "m ahead of the robot's base")
"""Labels of the axes of what the robot sees from above."""


def from_above(points: ArrayLike) -> np.ndarray:
    """Return points in the robot's base as it sees them from above: right and ahead, (N, 2)."""
    ahead_first = np.asarray(points)
    return ahead_first[:, 1::-1] * (-1, 1)


def to_scale(
    title: str,
    points: np.ndarray,
    labels: tuple[str, str],
    *,
    room: float,
) -> Panel:
    """Return a panel with lines, both axes to one scale, with room round points, shape (N, 2)."""
    left, bottom = (points.min(axis=0) - room).tolist()
    right, top = (points.max(axis=0) + room).tolist()
    width = WIDTH - LEFT - RIGHT
    scale = min(width / (right - left), TALLEST / (top - bottom))
    middle = (left + right) / 2
    half = width / scale / 2
    x = Axis(middle - half, middle + half, labels[0])
    y = Axis(bottom, top, labels[1])
    height = 86 + scale * (top - bottom)
    return Panel(title, x, y, height=height).grid()


def named_rows(
    title: str,
    names: Sequence[str],
    x: Axis,
    *,
    pitch: float = 24,
    without_axis: bool = False,
    width: float = WIDTH,
) -> Panel:
    """Return a panel with named rows from the top, row i at y = i."""
    count = len(names)
    letters = min(max(map(len, names), default=0), LONGEST)
    rows = Axis(count - 0.5, -0.5)
    height = TOP + BOTTOM + pitch * count
    margin = min(24 + 6.6 * letters, 150)
    panel = Panel(
        title,
        x,
        rows,
        width=width,
        height=height,
        margin=margin,
    )
    panel.names = names
    if not without_axis:
        panel.grid(horizontal=False)
    for i in range(0, count, math.ceil(LINE / pitch)):
        _name_row(panel, i)
    for i in range(1, 0 if without_axis else count):  # below the names, too
        y = panel.y(i - 0.5)
        panel.add("line", x1=4, x2=panel.right, y1=y, y2=y, class_="grid")
    return panel


def _name_row(panel: Panel, i: int) -> None:
    """Write the name of a row before it, shortened in the middle where it is long."""
    name = panel.names[i]
    words = name
    if len(name) > LONGEST:
        words = f"{name[:8]}\N{HORIZONTAL ELLIPSIS}{name[-9:]}"
    y = panel.y(i) + 4
    panel.add(
        "text",
        name,
        words,
        x=panel.left - 8,
        y=y,
        class_="tick end",
    )


LOADED: tuple[tuple[ModelName, str], ...] = (
    ("nominal", "nominal"),
    ("geometric", "calibrated"),
)
"""Models before and after, as they are loaded, and their marks."""
COLOURS = 6
"""Marks ``model-0``, ... that the style sheet has; more models or arms take them again."""


@dataclass(frozen=True)
class Plot:
    """One plot of a page."""

    caption: PlotCaption
    legend: tuple[tuple[str, str], ...]
    """Class of the mark, and its words."""
    panels: tuple[Panel, ...]
    layout: str
    """Class of the style sheet that lays out the panels."""
    scene: str
    """Name of a view that the page's script draws instead of panels."""
    controls: Mapping[str, object] = field(default_factory=dict[str, object])
    """Values that the template needs for the plot's controls."""


Maker = Callable[[ReportDocument], Plot | None]
"""Draws a plot from a report's figures; None where they hold nothing to draw."""


def plot(
    name: str,
    *panels: Panel,
    layout: str = "",
    scene: str = "",
    controls: Mapping[str, object] | None = None,
    **values: object,
) -> Plot:
    """Return a plot whose caption is a block of the captions, written with these values.

    A caption is a title; lines of the legend, ``- mark: words; mark: words``; and short sentences.
    """
    title, *details = lines(name.replace("-", "_"), **values)
    legend: list[tuple[str, str]] = []
    sentences: list[str] = []
    for line in details:
        if not line.startswith("- "):
            sentences.append(line)
            continue
        for entry in line[2:].split("; "):
            mark, _, words = entry.partition(": ")
            legend.append((mark, words))
    caption = PlotCaption(id=name, title=title, sentence=" ".join(sentences))
    return Plot(
        caption,
        tuple(legend),
        panels,
        layout,
        scene,
        controls or {},
    )

"""Plots of a page: panels as SVG text, and the sentence that says what they show here."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import ArrayLike

from ....solver.results import ModelName
from ..figures import PlotCaption, ReportDocument, lines
from .axis import Axis

WIDTH = 440
"""Of a panel, in its own units: on a phone about as many pixels, so that text stays readable."""
LEFT, RIGHT, TOP, BOTTOM = 56, 14, 36, 42
LINE = 14
"""Height of a line of text: names of rows that are closer are left out."""
LONGEST = 18
"""Letters of a row's name that are shown."""


def element(name: str, *children: str, **attributes: object) -> Markup:
    """Return an SVG element; texts among its children are escaped.

    Of the attributes, ``class_`` stands for ``class`` and ``fill_opacity`` for ``fill-opacity``;
    floats are written to hundredths of a pixel.
    """
    words = ""
    for key, value in attributes.items():
        text = (
            f"{value:.2f}".rstrip("0").rstrip(".")
            if isinstance(value, float)
            else str(value)
        )
        words += f' {key.rstrip("_").replace("_", "-")}="{escape(text)}"'
    inner = "".join(map(escape, children))
    return Markup(f"<{name}{words}>{inner}</{name}>")  # noqa: S704  values are escaped above


class Panel:
    """Axes to draw in, written as SVG; positions are values of the axes, sizes the panel's units.

    The margin at the left holds the vertical axis' numbers, or the names of rows.
    """

    def __init__(
        self,
        title: str,
        x: Axis,
        y: Axis,
        *,
        width: float = WIDTH,
        height: float = 280,
        margin: float = LEFT,
    ) -> None:
        self.title = title
        self.x_axis = x
        self.y_axis = y
        self.names: Sequence[str] = ()
        self.width = width
        self.height = height
        self.left = margin
        self.right = width - RIGHT
        self.top = TOP + (12.0 if y.label else 0.0)
        self.bottom = height - BOTTOM
        self.parts = [element("text", title, class_="title", x=4, y=14)]

    def __html__(self) -> str:
        """Return the panel as SVG."""
        return self._svg(role="img", aria_label=self.title, class_="panel")

    def file(self, style: str) -> bytes:
        """Return the panel as a file of its own, with a style sheet."""
        self.parts.append(element("style", style))
        return self._svg(xmlns="http://www.w3.org/2000/svg").encode()

    def _svg(self, **attributes: object) -> Markup:
        box = f"0 0 {self.width:g} {self.height:g}"
        return element("svg", *self.parts, viewBox=box, **attributes)

    def x(self, value: float) -> float:
        """Return the horizontal place of a value."""
        return self.left + (self.right - self.left) * self.x_axis.fraction(value)

    def y(self, value: float) -> float:
        """Return the vertical place of a value."""
        return self.bottom - (self.bottom - self.top) * self.y_axis.fraction(value)

    def add(
        self, name: str, hint: str = "", words: str = "", /, **attributes: object
    ) -> None:
        """Add an SVG element in the panel's own units; the hint shows under the mouse."""
        title = element("title", hint) if hint else ""
        self.parts.append(element(name, title, words, **attributes))

    def grid(self, *, horizontal: bool = True) -> "Panel":
        """Draw lines at round values, their numbers, and the axes' labels."""
        for mark in self.x_axis.marks():
            self.rule("grid", x=mark)
            number = self.x_axis.number(mark)
            self.text(self.x(mark), self.bottom + 18, number, "tick middle")
        for mark in self.y_axis.marks() if horizontal else ():
            self.rule("grid", y=mark)
            number = self.y_axis.number(mark)
            self.text(self.left - 6, self.y(mark) + 4, number, "tick end")
        self.text(self.right, self.bottom + 35, self.x_axis.label, "tick end")
        self.text(4, TOP - 2, self.y_axis.label, "tick")
        return self

    def rule(
        self, class_: str, *, x: float | None = None, y: float | None = None
    ) -> None:
        """Draw a line from top to bottom at an x, or from left to right at a y."""
        x1 = self.left if x is None else self.x(x)
        x2 = self.right if x is None else x1
        y1 = self.top if y is None else self.y(y)
        y2 = self.bottom if y is None else y1
        self.add("line", x1=x1, x2=x2, y1=y1, y2=y2, class_=class_)

    def threshold(
        self,
        words: str,
        *,
        x: float | None = None,
        y: float | None = None,
        below: bool = False,
    ) -> None:
        """Draw the dashed line of a limit, where there is one and it is within the axis.

        In its words, ``{}`` stands for the number that the axis shows.
        """
        if x is not None and self.x_axis.low <= x <= self.x_axis.high:
            self.rule("threshold", x=x)
            place = self.x(x)
            side, shift = ("end", -4) if place > 0.6 * self.right else ("", 4)
            label = words.replace("{}", self.x_axis.number(x))
            self.text(place + shift, self.top - 4, label, f"threshold-words {side}")
        if y is not None and self.y_axis.low <= y <= self.y_axis.high:
            self.rule("threshold", y=y)
            place = self.y(y)
            below = below or place < self.top + 14
            label = words.replace("{}", self.y_axis.number(y))
            shift = 13 if below else -4
            self.text(self.right - 2, place + shift, label, "threshold-words end")

    def thresholds(self, words: str, x: float | None) -> None:
        """Draw the limits -x and x, the second with words; none for 0 or None."""
        if x:
            self.threshold("", x=-x)
            self.threshold(words, x=x)

    def text(
        self, x: float, y: float, words: str, class_: str, **attributes: object
    ) -> None:
        """Write words at a place in the panel's own units."""
        if words:
            self.add("text", "", words, x=x, y=y, class_=class_, **attributes)

    def line(self, points: Iterable[Sequence[float]], class_: str) -> None:
        """Draw a line through values."""
        self.add("polyline", points=self._path(points), class_=class_)

    def area(self, x: ArrayLike, low: ArrayLike, high: ArrayLike, class_: str) -> None:
        """Fill what lies between two curves over the same values, shape (N,)."""
        above = np.column_stack([x, high])
        below = np.column_stack([x, low])
        edges = np.concatenate([above, below[::-1]]).tolist()
        self.add("polygon", points=self._path(edges), class_=class_)

    def _path(self, points: Iterable[Sequence[float]]) -> str:
        return " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)

    def dot(
        self, x: float, y: float, class_: str, hint: str = "", size: float = 3
    ) -> None:
        """Draw a dot at a value; its size is in the panel's own units."""
        self.add("circle", hint, cx=self.x(x), cy=self.y(y), r=size, class_=class_)

    def square(
        self, x: float, y: float, side: float, hint: str = "", **looks: object
    ) -> None:
        """Draw a square round a place, all in the panel's own units."""
        half = side / 2
        self.add("rect", hint, x=x - half, y=y - half, width=side, height=side, **looks)

    def bars(
        self, lows: ArrayLike, highs: ArrayLike, class_: str, thick: float = 2
    ) -> None:
        """Draw a bar in each named row, unless it has no length or an end is NaN."""
        for i, (low, high) in enumerate(np.broadcast(lows, highs)):
            if abs(high - low) > 0:
                x1, x2 = sorted((self.x(low), self.x(high)))
                size = {"width": max(x2 - x1, 0.5), "height": thick}
                self.add("rect", x=x1, y=self.y(i) - thick / 2, **size, class_=class_)

    def dots(
        self,
        values: Iterable[float | None],
        classes: str | Sequence[str],
        words: str,
        form: str = ".3f",
        size: float = 5.5,
    ) -> None:
        """Draw a dot in each named row that has a length, all of one class or each of its."""
        for i, value in enumerate(values):
            if value is not None:
                class_ = classes if isinstance(classes, str) else classes[i]
                hint = (
                    f"{self.names[i]}, {words}: {self.x_axis.factor * value:{form}} mm"
                )
                self.dot(value, i, class_, hint, size)


FROM_ABOVE = ("m to the robot's right", "m ahead of the robot's base")
"""Labels of the axes of what the robot sees from above."""


def from_above(points: ArrayLike) -> np.ndarray:
    """Return points in the robot's base as it sees them from above: right and ahead, (N, 2)."""
    return np.asarray(points)[:, 1::-1] * (-1, 1)


def to_scale(
    title: str, points: np.ndarray, labels: tuple[str, str], *, room: float
) -> Panel:
    """Return a panel with lines, both axes to one scale, with room round points, shape (N, 2)."""
    left, bottom = (points.min(axis=0) - room).tolist()
    right, top = (points.max(axis=0) + room).tolist()
    width = WIDTH - LEFT - RIGHT
    scale = min(width / (right - left), 420 / (top - bottom))
    middle = (left + right) / 2
    half = width / scale / 2
    x = Axis(middle - half, middle + half, labels[0])
    y = Axis(bottom, top, labels[1])
    return Panel(title, x, y, height=86 + scale * (top - bottom)).grid()


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
    letters = max(map(len, names), default=0)
    margin = min(24 + 6.6 * min(letters, LONGEST), 150)
    height = TOP + BOTTOM + pitch * count
    panel = Panel(
        title, x, Axis(count - 0.5, -0.5), width=width, height=height, margin=margin
    )
    panel.names = names
    if not without_axis:
        panel.grid(horizontal=False)
    for i in range(0, count, math.ceil(LINE / pitch)):
        name = names[i]
        short = f"{name[:8]}\N{HORIZONTAL ELLIPSIS}{name[-9:]}"
        panel.add(
            "text",
            name,
            name if len(name) <= LONGEST else short,
            x=margin - 8,
            y=panel.y(i) + 4,
            class_="tick end",
        )
    for i in range(1, 0 if without_axis else count):
        y = panel.y(i - 0.5)
        panel.add("line", x1=4, x2=panel.right, y1=y, y2=y, class_="grid")
    return panel


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
    title, *details = lines("captions.txt.j2", name.replace("-", "_"), **values)
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
    return Plot(caption, tuple(legend), panels, layout, scene, controls or {})

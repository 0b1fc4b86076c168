"""Panels of a plot as SVG text: axes, lines, dots, bars and the dashed lines of limits."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from ....solver.assessment import nice_above

WIDTH = 440
"""Of a panel, in its own units: on a phone about as many pixels, so that text stays readable."""
LEFT, RIGHT, TOP, BOTTOM = 56, 14, 36, 42
LINE = 14
"""Height of a line of text: names of rows that are closer are left out."""
LONGEST = 18
"""Letters of a row's name that are shown."""


def element(name: str, *children: str, **attributes: object) -> Markup:
    """Return an SVG element.

    Args:
        name: Of the element.
        children: Texts, which are escaped, and other elements.
        attributes: ``class_`` stands for ``class`` and ``stroke_width`` for ``stroke-width``;
            floats are written to hundredths of a pixel, None is left out.
    """
    words = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(_short(value))}"'
        for key, value in attributes.items()
        if value is not None
    )
    inner = "".join(map(escape, children))
    return Markup(f"<{name}{words}>{inner}</{name}>")  # noqa: S704  values are escaped above


def _short(value: object) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class Axis:
    """A range of values, linear or logarithmic, and their label."""

    low: float
    high: float
    label: str = ""
    log: bool = False
    ticks: tuple[float, ...] | None = None
    """Values that carry a number; None for round ones."""

    def fraction(self, value: float) -> float:
        """Return the place of a value, 0 at the low end and 1 at the high end, never outside."""
        low, high = self.low, self.high
        if self.log:
            value, low, high = math.log(max(value, low)), math.log(low), math.log(high)
        return min(max((value - low) / (high - low), 0.0), 1.0)

    def marks(self) -> list[float]:
        """Return the values that carry a number."""
        if self.ticks is not None:
            return [t for t in self.ticks if self.low <= t <= self.high]
        if self.log:
            return self._decades()
        step = nice_above((self.high - self.low) / 5)
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [k * step for k in range(first, last + 1)]

    def _decades(self) -> list[float]:
        low, high = math.log10(self.low), math.log10(self.high)
        digits = (1,) if high - low > 2 else (1, 2, 5)
        powers = range(math.floor(low), math.ceil(high) + 1)
        marks = [digit * 10.0**power for power in powers for digit in digits]
        return [m for m in marks if self.low * (1 - 1e-9) <= m <= self.high * (1 + 1e-9)]


class Panel:
    """Axes to draw in; a template writes the panel as SVG.

    Args:
        title: Above it.
        x: The horizontal axis.
        y: The vertical axis; low values are below.
        width: In the panel's units.
        height: Likewise.
        left: Width of the margin for the vertical axis' numbers or names.
    """

    def __init__(
        self,
        title: str,
        x: Axis,
        y: Axis,
        *,
        width: float = WIDTH,
        height: float = 280,
        left: float = LEFT,
    ) -> None:
        self.title, self.x_axis, self.y_axis = title, x, y
        self.width, self.height = width, height
        self.left, self.right = left, width - RIGHT
        self.top, self.bottom = TOP + (12.0 if y.label else 0.0), height - BOTTOM
        self.parts = [element("text", title, class_="title", x=4, y=14)]

    def __html__(self) -> str:
        """Return the panel as SVG."""
        box = f"0 0 {self.width:g} {self.height:g}"
        return element(
            "svg", *self.parts, viewBox=box, role="img", aria_label=self.title, class_="panel"
        )

    def x(self, value: float) -> float:
        """Return the horizontal place of a value."""
        return self.left + (self.right - self.left) * self.x_axis.fraction(value)

    def y(self, value: float) -> float:
        """Return the vertical place of a value."""
        return self.bottom - (self.bottom - self.top) * self.y_axis.fraction(value)

    def add(self, name: str, hint: str = "", /, **attributes: object) -> None:
        """Add an SVG element in the panel's own units; the hint shows under the mouse."""
        children = (element("title", hint),) if hint else ()
        self.parts.append(element(name, *children, **attributes))

    def grid(self, *, horizontal: bool = True, vertical: bool = True) -> "Panel":
        """Draw lines at round values, their numbers, and the axes' labels."""
        if vertical:
            for mark in self.x_axis.marks():
                self.vertical(mark, "grid")
                self.text(self.x(mark), self.bottom + 18, _number(mark), "tick middle")
        if horizontal:
            for mark in self.y_axis.marks():
                self.horizontal(mark, "grid")
                self.text(self.left - 6, self.y(mark) + 4, _number(mark), "tick end")
        self.text(self.right, self.bottom + 35, self.x_axis.label, "tick end")
        self.text(4, TOP - 2, self.y_axis.label, "tick")
        return self

    def horizontal(self, value: float, class_: str) -> None:
        """Draw a line across at a value."""
        y = self.y(value)
        self.add("line", x1=self.left, x2=self.right, y1=y, y2=y, class_=class_)

    def vertical(self, value: float, class_: str) -> None:
        """Draw a line from top to bottom at a value."""
        x = self.x(value)
        self.add("line", x1=x, x2=x, y1=self.top, y2=self.bottom, class_=class_)

    def threshold(self, value: float, words: str, *, below: bool = False) -> None:
        """Draw the dashed line of a limit across, with its words, where it is within the axis."""
        if self.y_axis.low <= value <= self.y_axis.high:
            self.horizontal(value, "threshold")
            below = below or self.y(value) < self.top + 14
            at = self.y(value) + (13 if below else -4)
            self.text(self.right - 2, at, words, "threshold-words end")

    def upright_threshold(self, value: float, words: str) -> None:
        """Draw the dashed line of a limit from top to bottom, likewise."""
        if self.x_axis.low <= value <= self.x_axis.high:
            self.vertical(value, "threshold")
            side, shift = ("end", -4) if self.x(value) > 0.6 * self.right else ("", 4)
            self.text(self.x(value) + shift, self.top - 4, words, f"threshold-words {side}")

    def text(self, x: float, y: float, words: str, class_: str) -> None:
        """Write words at a place in the panel's own units."""
        if words:
            self.parts.append(element("text", words, x=x, y=y, class_=class_))

    def line(self, points: Sequence[tuple[float, float]], class_: str) -> None:
        """Draw a line through values."""
        path = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)
        self.add("polyline", points=path, class_=class_)

    def dot(self, x: float, y: float, class_: str, hint: str = "", size: float = 3) -> None:
        """Draw a dot at a value."""
        self.add("circle", hint, cx=self.x(x), cy=self.y(y), r=size, class_=class_)


def _number(value: float) -> str:
    return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")


def to_scale(
    title: str, points: np.ndarray, labels: tuple[str, str], *, room: float, width: float = 370
) -> Panel:
    """Return a panel with lines, both axes to one scale.

    Args:
        title: Above it.
        points: Points that it is to hold, shape (N, 2).
        labels: Of the axes.
        room: Beside the outermost points.
        width: Of the axes at most, in the panel's units.
    """
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    scale = float(min(width / (high[0] - low[0]), 420 / (high[1] - low[1])))
    middle = float(low[0] + high[0]) / 2
    x = Axis(middle - width / scale / 2, middle + width / scale / 2, labels[0])
    y = Axis(float(low[1]), float(high[1]), labels[1])
    return Panel(title, x, y, height=86 + scale * (y.high - y.low)).grid()


class Rows(Panel):
    """A panel with a named row for each thing.

    Args:
        title: Above it.
        names: Of the rows, from the top.
        x: The horizontal axis.
        pitch: Height of a row.
        bare: Without lines and numbers.
    """

    def __init__(
        self, title: str, names: Sequence[str], x: Axis, *, pitch: float = 24, bare: bool = False
    ) -> None:
        longest = max((len(name) for name in names), default=0)
        super().__init__(
            title,
            x,
            Axis(0, max(len(names), 1)),
            height=TOP + BOTTOM + pitch * len(names),
            left=min(24 + 6.6 * min(longest, LONGEST), 150),
        )
        self.pitch = pitch
        if not bare:
            self.grid(horizontal=False)
        every = math.ceil(LINE / pitch)
        for i, name in enumerate(names):
            if i % every == 0:
                self._name(i, name)
            if i and not bare:
                y = self.row(i) - pitch / 2
                self.add("line", x1=4, x2=self.right, y1=y, y2=y, class_="grid")

    def _name(self, i: int, name: str) -> None:
        shown = name
        if len(name) > LONGEST:
            shown = f"{name[:8]}\N{HORIZONTAL ELLIPSIS}{name[-9:]}"
        place = {"x": self.left - 8, "y": self.row(i) + 4, "class_": "tick end"}
        self.parts.append(element("text", element("title", name), shown, **place))

    def row(self, i: int) -> float:
        """Return the height of a row's middle."""
        return self.top + self.pitch * (i + 0.5)

    def mark(self, i: int, value: float, class_: str, hint: str = "", size: float = 5.5) -> None:
        """Draw a dot in a row."""
        self.add("circle", hint, cx=self.x(value), cy=self.row(i), r=size, class_=class_)

    def span(self, i: int, low: float, high: float, class_: str, thick: float = 2) -> None:
        """Draw a bar from one value to another in a row."""
        x1, x2 = sorted((self.x(low), self.x(high)))
        y = self.row(i) - thick / 2
        self.add("rect", x=x1, y=y, width=max(x2 - x1, 0.5), height=thick, class_=class_)

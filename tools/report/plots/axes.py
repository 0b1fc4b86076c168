"""The panels that plots are drawn in, as SVG: axes, lines, dots, bars, the lines of limits."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....solver.assessment import nice_above
from ..page.html import Element, tag

WIDTH = 440
"""Of a panel, in its own units: on a phone about as many pixels, so that text stays readable."""
LEFT, RIGHT, TOP, BOTTOM = 56, 14, 36, 42
LINE = 14
"""Height of a line of text: names of rows that are closer are left out."""


@dataclass(frozen=True)
class Axis:
    """A range of values, linear or logarithmic, and what they are."""

    low: float
    high: float
    label: str = ""
    log: bool = False
    ticks: tuple[float, ...] | None = None
    """Where to put numbers; None for round values."""

    def fraction(self, value: float) -> float:
        """Return where a value lies, 0 at the low end and 1 at the high end, and never outside."""
        low, high = self.low, self.high
        if self.log:
            value, low, high = math.log(max(value, low)), math.log(low), math.log(high)
        return min(max((value - low) / (high - low), 0.0), 1.0)

    def marks(self) -> list[float]:
        """Return the values that carry a number."""
        if self.ticks is not None:
            return [t for t in self.ticks if self.low <= t <= self.high]
        return _log_marks(self.low, self.high) if self.log else _marks(self.low, self.high)


def _marks(low: float, high: float) -> list[float]:
    step = nice_above((high - low) / 5)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def _log_marks(low: float, high: float) -> list[float]:
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    digits = (1,) if math.log10(high / low) > 2 else (1, 2, 5)
    marks = [d * 10.0**k for k in decades for d in digits]
    return [mark for mark in marks if low * (1 - 1e-9) <= mark <= high * (1 + 1e-9)]


def number(value: float) -> str:
    """Return a round number for an axis, with a proper minus."""
    return f"{value:.6g}".replace("-", "\N{MINUS SIGN}")


class Panel:
    """One plot.

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
        self.x_axis, self.y_axis = x, y
        self.left, self.right = left, width - RIGHT
        self.top, self.bottom = TOP + (12.0 if y.label else 0.0), height - BOTTOM
        self.root: Element = tag(
            "svg",
            tag("text", title, class_="title", x=4, y=14),
            viewBox=f"0 0 {width:g} {height:g}",
            role="img",
            aria_label=title,
            class_="panel",
        )

    def x(self, value: float) -> float:
        """Return the horizontal place of a value."""
        return self.left + (self.right - self.left) * self.x_axis.fraction(value)

    def y(self, value: float) -> float:
        """Return the vertical place of a value."""
        return self.bottom - (self.bottom - self.top) * self.y_axis.fraction(value)

    def add(self, name: str, *children: Element | str, **attributes: object) -> Element:
        """Add an SVG element in the panel's own units."""
        element = tag(name, *children, **attributes)
        self.root.append(element)
        return element

    def grid(self, *, horizontal: bool = True, vertical: bool = True) -> "Panel":
        """Draw lines at round values, their numbers, and the axes' labels."""
        if vertical:
            for mark in self.x_axis.marks():
                self.vertical(mark, "grid")
                self.text(self.x(mark), self.bottom + 18, number(mark), "tick middle")
        if horizontal:
            for mark in self.y_axis.marks():
                self.horizontal(mark, "grid")
                self.text(self.left - 6, self.y(mark) + 4, number(mark), "tick end")
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

    def threshold(
        self, value: float, words: str, *, vertical: bool = False, below: bool = False
    ) -> None:
        """Draw the dashed line of a limit, with its words, where it lies within the axis."""
        axis = self.x_axis if vertical else self.y_axis
        if not axis.low <= value <= axis.high:
            return
        if vertical:
            self.vertical(value, "threshold")
            beyond = self.x(value) > 0.6 * self.right
            side = "end" if beyond else ""
            at = self.x(value) + (-4 if beyond else 4)
            self.text(at, self.top - 4, words, f"threshold-words {side}")
        else:
            self.horizontal(value, "threshold")
            below = below or self.y(value) < self.top + 14
            at = self.y(value) + (13 if below else -4)
            self.text(self.right - 2, at, words, "threshold-words end")

    def text(self, x: float, y: float, words: str, class_: str) -> None:
        """Write words at a place in the panel's own units."""
        if words:
            self.add("text", words, x=x, y=y, class_=class_)

    def line(self, points: Sequence[tuple[float, float]], class_: str) -> None:
        """Draw a line through values."""
        path = " ".join(f"{self.x(a):.1f},{self.y(b):.1f}" for a, b in points)
        self.add("polyline", points=path, class_=class_)

    def dot(self, x: float, y: float, class_: str, hint: str = "", size: float = 3) -> None:
        """Draw a dot at a value; the hint shows under the mouse."""
        children = (tag("title", hint),) if hint else ()
        self.add("circle", *children, cx=self.x(x), cy=self.y(y), r=size, class_=class_)


def to_scale(
    title: str, points: np.ndarray, labels: tuple[str, str], *, room: float, width: float = 370
) -> Panel:
    """Return a panel with lines, both axes to one scale.

    Args:
        title: Above it.
        points: What it is to hold, shape (N, 2).
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
    """A plot with a named row for each thing.

    Args:
        title: Above it.
        names: Of the rows, from the top.
        x: The horizontal axis.
        pitch: Height of a row.
        bare: Without lines and numbers.
    """

    def __init__(
        self,
        title: str,
        names: Sequence[str],
        x: Axis,
        *,
        pitch: float = 24,
        bare: bool = False,
    ) -> None:
        height = TOP + BOTTOM + pitch * len(names)
        longest = max((len(name) for name in names), default=0)
        super().__init__(
            title,
            x,
            Axis(0, max(len(names), 1)),
            height=height,
            left=min(24 + 6.6 * min(longest, 18), 150),
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
        shown = name if len(name) <= 18 else f"{name[:8]}\N{HORIZONTAL ELLIPSIS}{name[-9:]}"
        place = {"x": self.left - 8, "y": self.row(i) + 4}
        self.add("text", tag("title", name), shown, **place, class_="tick end")

    def row(self, i: int) -> float:
        """Return the height of a row's middle."""
        return self.top + self.pitch * (i + 0.5)

    def mark(self, i: int, value: float, class_: str, hint: str = "", size: float = 4) -> None:
        """Draw a dot in a row."""
        children = (tag("title", hint),) if hint else ()
        self.add("circle", *children, cx=self.x(value), cy=self.row(i), r=size, class_=class_)

    def span(self, i: int, low: float, high: float, class_: str, thick: float = 2) -> None:
        """Draw a bar from one value to another in a row."""
        x1, x2 = sorted((self.x(low), self.x(high)))
        y = self.row(i) - thick / 2
        self.add("rect", x=x1, y=y, width=max(x2 - x1, 0.5), height=thick, class_=class_)

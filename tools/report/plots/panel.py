"""A panel of a plot: axes to draw in, written as SVG text."""

from collections.abc import Iterable, Sequence

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import ArrayLike

from .axis import Axis

WIDTH = 440
"""Of a panel, in its own units: on a phone about as many pixels, so that text stays readable."""
LEFT, RIGHT, TOP, BOTTOM = 56, 14, 36, 42


def element(name: str, *children: str, **attributes: object) -> Markup:
    """Return an SVG element; texts among its children are escaped.

    Of the attributes, ``class_`` stands for ``class`` and ``fill_opacity`` for ``fill-opacity``;
    floats are written to hundredths of a pixel.
    """
    words = ""
    for key, value in attributes.items():
        text = str(value)
        if isinstance(value, float):
            text = f"{value:.2f}".rstrip("0").rstrip(".")
        attribute = key.rstrip("_").replace("_", "-")
        words += f' {attribute}="{escape(text)}"'
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
        self,
        name: str,
        hint: str = "",
        words: str = "",
        /,
        **attributes: object,
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
        self,
        class_: str,
        *,
        x: float | None = None,
        y: float | None = None,
    ) -> None:
        """Draw a line from top to bottom at an x, or from left to right at a y."""
        x1 = self.left if x is None else self.x(x)
        x2 = self.right if x is None else x1
        y1 = self.top if y is None else self.y(y)
        y2 = self.bottom if y is None else y1
        self.add(
            "line",
            x1=x1,
            x2=x2,
            y1=y1,
            y2=y2,
            class_=class_,
        )

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
        if x is not None and self.x_axis.holds(x):
            self.rule("threshold", x=x)
            self._words_above(x, words)
        if y is not None and self.y_axis.holds(y):
            self.rule("threshold", y=y)
            self._words_at_right(y, words, below=below)

    def _words_above(self, x: float, words: str) -> None:
        """Write the words of a limit above its line, on the side that has room."""
        place = self.x(x)
        side, shift = ("end", -4) if place > 0.6 * self.right else ("", 4)
        label = words.replace("{}", self.x_axis.number(x))
        self.text(place + shift, self.top - 4, label, f"threshold-words {side}")

    def _words_at_right(self, y: float, words: str, *, below: bool) -> None:
        """Write the words of a limit at the end of its line, above it where there is room."""
        place = self.y(y)
        below = below or place < self.top + 14
        shift = 13 if below else -4
        label = words.replace("{}", self.y_axis.number(y))
        self.text(self.right - 2, place + shift, label, "threshold-words end")

    def thresholds(self, words: str, x: float | None) -> None:
        """Draw the limits -x and x, the second with words; none for 0 or None."""
        if x:
            self.threshold("", x=-x)
            self.threshold(words, x=x)

    def text(
        self,
        x: float,
        y: float,
        words: str,
        class_: str,
        **attributes: object,
    ) -> None:
        """Write words at a place in the panel's own units."""
        if words:
            self.add(
                "text",
                "",
                words,
                x=x,
                y=y,
                class_=class_,
                **attributes,
            )

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
        self,
        x: float,
        y: float,
        class_: str,
        hint: str = "",
        size: float = 3,
    ) -> None:
        """Draw a dot at a value; its size is in the panel's own units."""
        self.add(
            "circle",
            hint,
            cx=self.x(x),
            cy=self.y(y),
            r=size,
            class_=class_,
        )

    def square(
        self,
        x: float,
        y: float,
        side: float,
        hint: str = "",
        **looks: object,
    ) -> None:
        """Draw a square round a place, all in the panel's own units."""
        half = side / 2
        self.add(
            "rect",
            hint,
            x=x - half,
            y=y - half,
            width=side,
            height=side,
            **looks,
        )

    def bars(
        self,
        lows: ArrayLike,
        highs: ArrayLike,
        class_: str,
        thick: float = 2,
    ) -> None:
        """Draw a bar in each named row, unless it has no length or an end is NaN."""
        for i, (low, high) in enumerate(np.broadcast(lows, highs)):
            if not abs(high - low) > 0:  # true for NaN
                continue
            x, end = sorted((self.x(low), self.x(high)))
            width = max(end - x, 0.5)
            y = self.y(i) - thick / 2
            self.add(
                "rect",
                x=x,
                y=y,
                width=width,
                height=thick,
                class_=class_,
            )

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
            if value is None:
                continue
            class_ = classes if isinstance(classes, str) else classes[i]
            length = self.x_axis.factor * value
            hint = f"{self.names[i]}, {words}: {length:{form}} mm"
            self.dot(value, i, class_, hint, size)

"""Numbers and tables of the page; each number is marked with where it stands in report.json."""

from typing import Any, cast

from .markup import Element, tag
from .words import fixed

__all__ = ["figure", "table"]


def figure(
    figures: Any, path: str, *, scale: float = 1e3, digits: int = 3, sign: str = ""
) -> Element:
    """Return a number of the report, marked with where it stands in ``report.json``.

    Args:
        figures: The report's figures.
        path: Keys and indices with dots between them.
        scale: From SI to what is shown.
        digits: Behind the point.
        sign: ``+`` to show it always.
    """
    value: Any = figures
    for key in path.split("."):
        value = value[int(key) if key.isdecimal() else key]
    text = "\N{EN DASH}" if value is None else fixed(scale * value, digits, sign)
    return tag(
        "span",
        text,
        data_figure=path,
        data_scale=f"{scale:g}",
        data_digits=digits,
        data_sign=sign or None,
        class_="figure",
    )


def table(heads: list[Any], rows: list[list[Any]], class_: str = "") -> Element:
    """Return a table; a cell is a text, an element, or a list of them."""
    body = [
        tag(
            "tr",
            [
                tag("td", _nodes(cell), data_head=head if isinstance(head, str) else None)
                for head, cell in zip(heads, row, strict=True)
            ],
        )
        for row in rows
    ]
    return tag(
        "div",
        tag(
            "table",
            tag("thead", tag("tr", [tag("th", head, scope="col") for head in heads])),
            tag("tbody", body),
            class_=class_ or None,
        ),
        class_="scroll",
    )


def _nodes(cell: Any) -> list[Any]:
    return cast("list[Any]", cell) if isinstance(cell, list) else [cell]

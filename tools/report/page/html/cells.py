"""Numbers and tables of the page; each number is marked with where it stands in report.json."""

from collections.abc import Sequence
from typing import Any, TypeAlias, cast

from .....solver.assessment import fixed
from .....solver.results import Document
from .markup import Element, Node, tag

Cell: TypeAlias = Node | Sequence[Node]
"""A text, an element, or several of them."""


def figure(
    document: Document, path: str, *, scale: float = 1e3, digits: int = 3, sign: str = ""
) -> Element:
    """Return a number of a document, marked with where it stands in its JSON file.

    Args:
        document: The figures that the page shows.
        path: Names and indices with dots between them.
        scale: From SI to what is shown.
        digits: Number of decimals.
        sign: ``+`` to show it always.
    """
    value: Any = document
    for key in path.split("."):
        value = value[int(key)] if key.isdecimal() else getattr(value, key)
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


def table(heads: Sequence[str], rows: Sequence[Sequence[Cell]], class_: str = "") -> Element:
    """Return a table."""
    body = [
        tag(
            "tr",
            [
                tag("td", _nodes(cell), data_head=head)
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


def _nodes(cell: Cell) -> Sequence[Node]:
    return cell if isinstance(cell, list | tuple) else [cast("Node", cell)]

"""The templates of a report, which hold each sentence as a translator wants it."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....errors import fixed
from ....solver.assessment import (
    apart_words,
    area,
    intervals_in_words,
    joined,
    mm,
    percent,
    plural,
    short_where,
)

if TYPE_CHECKING:
    from jinja2 import Environment

FOLDER = Path(__file__).parents[1] / "templates"


def each(rows: Iterable[object], form: str) -> list[str]:
    """Return each row written by a format of Python, in which it is ``0``."""
    return [form.format(row) for row in rows]


@cache
def environment() -> "Environment":
    """Return the templates; what they insert is escaped in pages, and left as it is in texts."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

    templates = Environment(
        loader=FileSystemLoader(FOLDER),
        autoescape=select_autoescape(["html.j2"]),
        undefined=StrictUndefined,
        extensions=["jinja2.ext.do"],
        trim_blocks=True,
        lstrip_blocks=True,
    )
    functions = (
        *(apart_words, area, each, fixed, intervals_in_words),
        *(joined, mm, percent, plural, short_where),
    )
    filters: dict[str, Any] = {function.__name__: function for function in functions}
    templates.filters.update(filters, short="{:g}".format)
    return templates


def lines(block: str, /, **values: object) -> list[str]:
    """Return the lines of a block of the template of texts."""
    source = environment().get_template("texts.txt.j2")
    written = "".join(source.blocks[block](source.new_context(values)))
    return [words for line in written.splitlines() if (words := " ".join(line.split()))]


def text(block: str, /, **values: object) -> str:
    """Return a block of the template of texts as one line."""
    return " ".join(lines(block, **values))

"""Pages written from templates: one HTML file each, which needs no other and no network."""

import re
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from ....solver.assessment import fixed, mm, plural, short_where
from ....solver.results import Document, encode

if TYPE_CHECKING:
    from jinja2 import Environment

_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")

_FILTERS: dict[str, Any] = {
    "fixed": fixed,
    "short": "{:g}".format,
    "mm": mm,
    "plural": plural,
    "short_where": short_where,
}


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        extensions=["jinja2.ext.do"],
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(_FILTERS)
    return environment


def render(
    template: str, document: Document, data: Mapping[str, Document] | None = None, **values: object
) -> str:
    """Return a page.

    Args:
        template: Its file below ``templates``.
        document: The figures that the page shows, which it also holds as JSON.
        data: More JSON for the page's script, by the element's id.
        values: Further variables of the template.
    """
    embedded = {"figures": document, **(data or {})}
    html = (
        _environment()
        .get_template(template)
        .render(
            figure=partial(figure_value, document),
            data={name: _json(each) for name, each in embedded.items()},
            **values,
        )
    )
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", html)


def _json(document: Document) -> Markup:
    """Return JSON in which nothing can end the script element around it."""
    text = encode(document, compact=True).decode()
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)  # noqa: S704  no sign of HTML is left in it


def figure_value(
    document: Document, path: str, *, scale: float = 1e3, digits: int = 3, sign: str = ""
) -> Markup:
    """Return a number of a document, marked with its path in the document's JSON file.

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
    signed = f' data-sign="{sign}"' if sign else ""
    marks = f'data-figure="{path}" data-scale="{scale:g}" data-digits="{digits}"{signed}'
    return Markup(f'<span {marks} class="figure">{text}</span>')  # noqa: S704  all of it our own

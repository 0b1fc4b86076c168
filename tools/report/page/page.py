"""Pages written from templates: one HTML file each, which needs no other and no network."""

import re
from collections.abc import Mapping
from functools import partial
from typing import Any

from markupsafe import Markup

from ....solver.assessment import fixed
from ....solver.results import Document, encode
from ..figures import environment

_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")


def render(
    template: str, document: Document, data: Mapping[str, object] | None = None, **values: object
) -> str:
    """Return a page.

    Args:
        template: Its file below ``templates``.
        document: The figures that the page shows, which it also holds as JSON.
        data: More JSON for the page's script, by the element's id.
        values: Further variables of the template.
    """
    embedded = {name: _json(each) for name, each in {"figures": document, **(data or {})}.items()}
    figure = partial(figure_value, document)
    html = environment().get_template(template).render(figure=figure, data=embedded, **values)
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", html)


def _json(document: object) -> Markup:
    """Return JSON in which nothing can end the script element around it."""
    text = encode(document, compact=True).decode()
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)  # noqa: S704  no sign of HTML is left in it


def figure_value(
    document: Document, path: str, *, scale: float = 1e3, digits: int = 3, sign: str = ""
) -> Markup:
    """Return a number of a document times a scale, marked with its path in the JSON file."""
    value: Any = document
    for key in path.split("."):
        value = value[int(key)] if key.isdecimal() else getattr(value, key)
    text = "\N{EN DASH}" if value is None else fixed(scale * value, digits, sign)
    signed = f' data-sign="{sign}"' if sign else ""
    marks = f'data-figure="{path}" data-scale="{scale:g}" data-digits="{digits}"{signed}'
    return Markup(f'<span {marks} class="figure">{text}</span>')  # noqa: S704  all of it our own

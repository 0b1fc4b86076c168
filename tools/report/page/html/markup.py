"""HTML and SVG as a tree of elements, so that all text from files is escaped by the writer."""

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias, cast
from xml.etree import ElementTree

if TYPE_CHECKING:
    Element: TypeAlias = ElementTree.Element[str]
else:
    Element = ElementTree.Element
Node: TypeAlias = Element | str | None
_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")


def tag(name: str, *children: Node | Iterable[Node], **attributes: object) -> Element:
    """Return an element.

    Args:
        name: Of the element, as in HTML or SVG.
        children: Elements and texts, or iterables of them; None is left out.
        attributes: ``class_`` stands for ``class`` and ``stroke_width`` for ``stroke-width``;
            None is left out.
    """
    element = ElementTree.Element(name)
    for key, value in attributes.items():
        if value is not None:
            element.set(key.rstrip("_").replace("_", "-"), _clean(_word(value)))
    for child in children:
        single = child is None or isinstance(child, str | ElementTree.Element)
        for node in cast("Iterable[Node]", (child,) if single else child):
            _append(element, node)
    return element


def _append(parent: Element, node: Node) -> None:
    if node is None:
        return
    if isinstance(node, ElementTree.Element):
        parent.append(node)
    elif len(parent):
        parent[-1].tail = (parent[-1].tail or "") + _clean(node)
    else:
        parent.text = (parent.text or "") + _clean(node)


def _word(value: object) -> str:
    """Return an attribute's text; coordinates need no more than hundredths of a pixel."""
    return f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float) else str(value)


def _clean(text: str) -> str:
    """Replace what no document may hold: control characters, halves of surrogate pairs."""
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", text)


def data_script(identifier: str, text: str) -> Element:
    """Return JSON for the page's own scripts; nothing in it can end the element."""
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    script = tag("script", id=identifier, type="application/json")
    script.text = text
    return script


def render(page: Element) -> str:
    """Return a page as HTML text."""
    return "<!DOCTYPE html>\n" + ElementTree.tostring(page, encoding="unicode", method="html")

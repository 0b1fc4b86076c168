"""The frame of every page: looks, scripts and data in one HTML file, without any network."""

from collections.abc import Iterable, Mapping
from importlib.resources import files

from .markup import Element, Node, data_script, render, tag

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def frame(title: str, body: Iterable[Node], data: Mapping[str, bytes]) -> str:
    """Return a page with the report's looks and scripts.

    Args:
        title: Of the window.
        body: What it shows.
        data: What its scripts draw from: JSON, by the element's id.
    """
    style, script = tag("style"), tag("script")
    style.text = _resource("style.css")
    script.text = _resource("view.js") + _resource("report.js")
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", http_equiv="Content-Security-Policy", content=_POLICY),
        tag("link", rel="icon", href="data:,"),
        tag("title", title),
        style,
    )
    scripts = [data_script(name, text.decode()) for name, text in data.items()]
    shown = tag("body", _hatch(), tag("main", body), scripts, script)
    return render(tag("html", head, shown, lang="en"))


def _resource(name: str) -> str:
    return (files(__package__ or "") / name).read_text(encoding="utf-8")


def _hatch() -> Element:
    """Return the pattern that marks what was trained on."""
    pattern = tag(
        "pattern",
        tag("path", d="M0 6L6 0M-1 1L1 -1M5 7L7 5", class_="hatching"),
        id="hatch",
        width=6,
        height=6,
        patternUnits="userSpaceOnUse",
    )
    return tag("svg", tag("defs", pattern), width=0, height=0, class_="defs", aria_hidden="true")

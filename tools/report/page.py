"""The report as one HTML page that needs no other file and no network."""

from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any

from . import plots_errors, plots_fit, plots_model, plots_use, scenes
from .markup import Element, Node, data_script, render, tag
from .plot import Maker, Plot
from .sections import answers, headline, limits_table, placements_table, verdict_box
from .tables import details

__all__ = ["PLOTS", "frame", "page", "plots_of"]

Figures = Mapping[str, Any]

PLOTS: tuple[tuple[str, tuple[Maker, ...]], ...] = (
    ("Three questions", (plots_use.table_map,)),
    (
        "Where the error is",
        (
            plots_use.errors_by_placement,
            plots_use.shares,
            scenes.errors_in_3d,
            plots_errors.errors_in_2d,
            plots_fit.known_distances,
            plots_fit.predicted_and_found,
        ),
    ),
    ("The data", (plots_errors.order, plots_model.coverage, plots_fit.cross_placement)),
    (
        "The fit and the model",
        (plots_fit.history, scenes.arm_in_3d, plots_model.parameters, plots_model.groups),
    ),
)
"""The plots by section; the map of the first stands with the answers."""

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"


def plots_of(figures: Figures) -> dict[str, list[Plot]]:
    """Return the plots that the figures allow, by section."""
    return {
        title: [plot for maker in makers if (plot := maker(figures)) is not None]
        for title, makers in PLOTS
    }


def page(figures: Figures, plots: Mapping[str, Sequence[Plot]]) -> str:
    """Return the report as HTML.

    Args:
        figures: As :func:`.figures.report_figures` returns them.
        plots: As :func:`plots_of` returns them.
    """
    (_, (table_map,)), *sections = plots.items()
    body = [
        headline(figures),
        verdict_box(figures),
        limits_table(figures),
        answers(figures, table_map.element()),
        placements_table(figures),
        *(
            tag("section", tag("h2", title), [plot.element() for plot in group], class_="plots")
            for title, group in sections
        ),
        details(figures),
    ]
    return frame(f"Calibration of {figures['robot_name']}", body, figures)


def frame(title: str, body: Iterable[Node], data: Any) -> str:
    """Return a page with the report's looks and scripts.

    Args:
        title: Of the window.
        body: What it shows.
        data: What its scripts draw from.
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
    shown = tag("body", _hatch(), tag("main", body), data_script("figures", data), script)
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

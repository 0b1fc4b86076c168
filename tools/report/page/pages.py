"""Pages of a report, a comparison and a simulated experiment: values for templates."""

import base64
import math
import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from markupsafe import Markup

from ....solver.assessment import fixed, short_names
from ....solver.results import Document, encode
from ...experiments import SimulationDocument
from .. import figures
from ..plots import Plot, comparison_plots, map_sentence, shown_unit, simulation_plot

_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")


def render(
    template: str, document: Document, data: Mapping[str, object] | None = None, **values: object
) -> str:
    """Return a page by its template; it also holds the document's figures, and data, as JSON."""
    embedded: dict[str, Markup] = {}
    for name, each in {"figures": document, **(data or {})}.items():
        text = encode(each, compact=True).decode()
        for sign in "<>&":  # so that nothing can end the script element around it
            text = text.replace(sign, f"\\u{ord(sign):04x}")
        embedded[name] = Markup(text)  # noqa: S704  no sign of HTML is left in it
    figure = partial(figure_value, document)
    html = (
        figures.environment().get_template(template).render(figure=figure, data=embedded, **values)
    )
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", html)


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


_NUMBER = "\0"
"""Stands for the error that the task allows while the sentences are written."""


class AnswersFrom(Document, kw_only=True, frozen=True):
    """Answers where the task allows an error of at least this much."""

    allowed: float
    """[m]."""
    answers: tuple[figures.Answer, ...]
    """At each placement."""
    use: tuple[str, ...]
    """The answer in words, cut where the error that the task allows is to stand."""
    map: tuple[str, ...]
    """The sentence below the map, likewise."""


def answers_by_tolerance(report: figures.ReportDocument) -> list[AnswersFrom]:
    """Return the answers for any error that the task may allow, the first for the smallest."""
    changes = {0.0}  # tolerances at which the answer for a placement changes [m]
    for row in report.placements:
        if row.role == "test":
            errors = row.quantiles.loaded
            mostly = max(abs(row.loaded.distance_error or 0.0), errors.p95)
            changes |= {mostly, max(mostly, errors.max)}
    return [_step(report, allowed) for allowed in sorted(changes)]


def _step(report: figures.ReportDocument, allowed: float) -> AnswersFrom:
    called = [row.called for row in report.answers.use.rows]
    answers: tuple[figures.Answer, ...] = tuple(
        figures.answer_at(row, allowed) for row in report.placements
    )
    use = figures.use_text(called, answers, _NUMBER, report.verdict.status)
    return AnswersFrom(
        allowed=allowed,
        answers=answers,
        use=tuple(use.split(_NUMBER, 1)),
        map=tuple(map_sentence(report, answers, _NUMBER).split(_NUMBER, 1)),
    )


def report_page(report: figures.ReportDocument, plots: Mapping[str, Sequence[Plot]]) -> str:
    """Return the report of a calibration as HTML; the first section's plot is with the answers."""
    (_, (table_map,)), *sections = plots.items()
    role, judged = report.summary.judged
    settings = report.provenance.settings.items()
    return render(
        "report.html.j2",
        report,
        {"by-tolerance": answers_by_tolerance(report)},
        report=report,
        names=short_names([row.name for row in report.placements]),
        role=role,
        judged=judged,
        role_name={"test": "held out", "train": "trained on"}.__getitem__,
        degrees=math.degrees(1),
        settings=", ".join(f"{k} {v}" for k, v in settings if v not in (None, [], "", False)),
        shown_unit=shown_unit,
        table_map=table_map,
        sections=[(title, group) for title, group in sections if group],
    )


class Found(Document, kw_only=True, frozen=True):
    """One thing found with the calibrated arm held: words, and its figures."""

    title: str
    lines: tuple[str, ...]
    """As the terminal says them."""
    result: dict[str, Any]
    """As ``--json`` has it."""


def found_page(title: str, lines: Sequence[str], result: Mapping[str, Any]) -> str:
    """Return the page of one thing found with the calibrated arm held, in the terminal's words."""
    found = Found(title=title, lines=tuple(lines), result=dict(result))
    return render("found.html.j2", found, found=found)


def comparison_page(result: figures.ComparisonDocument) -> str:
    """Return the comparison of calibrations as HTML."""
    return render(
        "comparison.html.j2",
        result,
        result=result,
        sentences=[figures.comparison_sentence(result, pair) for pair in result.pairs],
        plots=comparison_plots(result),
        names=short_names([row.name for row in result.placements]),
    )


def simulation_page(result: SimulationDocument, pictures: Mapping[str, bytes]) -> str:
    """Return a simulated experiment with both models as HTML, and its pictures by file name."""
    models = [*([] if result.beside is None else [("beside.", result.beside)]), ("", result)]
    names = [Path(model.model).name for _, model in models]
    places = [
        (place, name, f"{start}{place}.")
        for place in ("centre", "cross", "drawing")
        for name, (start, model) in zip(names, models, strict=True)
        if getattr(model, place) is not None
    ]
    return render(
        "simulation.html.j2",
        result,
        result=result,
        models=[(name, model) for name, (_, model) in zip(names, models, strict=True)],
        places=places,
        pictures={
            name: f"data:image/{name.rpartition('.')[2]};base64,{base64.b64encode(file).decode()}"
            for name, file in pictures.items()
        },
        plot=simulation_plot(result),
    )

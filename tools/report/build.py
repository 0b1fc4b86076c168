"""Pages by templates, a report of a calibration or a comparison of several, and their tables."""

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import chain, product
from pathlib import Path
from typing import Any, cast

import msgspec
from markupsafe import Markup

from ...errors import fixed
from ...solver.assessment import Assessment, Predictions, sample_errors, short_names
from ...solver.calibration import Calibration
from ...solver.results import (
    MODELS,
    ROLES,
    Document,
    encode,
    refuse_existing,
    write_files,
)
from . import figures
from .figures import Answer, ComparisonDocument, ReportDocument, report_figures
from .plots import (
    FOLDED,
    Plot,
    comparison_plots,
    display_of,
    map_sentence,
    plots_of,
)


def build_report(assessment: Assessment) -> tuple[ReportDocument, dict[str, bytes]]:
    """Return the report of a calibration, and its files by name, the same bytes each time.

    A setting of the calibration that is no number is a DocumentError.
    """
    report = report_figures(assessment)
    plots = plots_of(report)
    captions: list[figures.PlotCaption] = []
    for section, group in plots.items():
        rows = (plot.caption for plot in group)
        captions += [msgspec.structs.replace(row, section=section) for row in rows]
    document = msgspec.structs.replace(report, plots=tuple(captions))
    files = _files("report", document, report_page(document, plots))
    files["residuals.csv"] = residual_table(assessment.predictions)
    return document, files


def _files(name: str, document: Document, html: str) -> dict[str, bytes]:
    page = html.encode("utf-8", "replace")
    data = encode(document) + b"\n"
    return {f"{name}.html": page, f"{name}.json": data}


def report_files(calibration: Calibration) -> dict[str, bytes]:
    """Return the report's files, by name, with the limits that fit the arm."""
    return build_report(calibration.assessment)[1]


def write_report(
    calibration: Calibration, folder: str | Path, *, force: bool = False
) -> dict[str, str]:
    """Write ``report.html`` and ``report.json``, which show a calibration and its verdict.

    Args:
        calibration: See :func:`mukca.calibrate` and :func:`mukca.load_calibration`.
        folder: Made where missing. Files of other names in it stay as they are.
        force: Overwrite a report that is there.

    Returns:
        The paths written, by kind.

    Raises:
        OutputError: A report is there already, or cannot be written.
    """
    folder = Path(folder)
    files = report_files(calibration)
    refuse_existing(folder, files, force=force)
    write_files(folder, files)
    return {
        "report": str(folder / "report.html"),
        "figures": str(folder / "report.json"),
    }


_CONTROL = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff]")


def render(
    template: str,
    document: object,
    data: Mapping[str, object] | None = None,
    **values: object,
) -> str:
    """Return a page by its template; it also holds the document's figures, and data, as JSON."""
    embedded: dict[str, Markup] = {}
    for name, value in {"figures": document, **(data or {})}.items():
        text = encode(value, compact=True).decode()
        for sign in "<>&":  # so that nothing can end the script element around it
            text = text.replace(sign, f"\\u{ord(sign):04x}")
        embedded[name] = Markup(text)  # noqa: S704  no sign of HTML is left in it
    page = figures.environment().get_template(template)
    html = page.render(figure=partial(figure_value, document), data=embedded, **values)
    return _CONTROL.sub("\N{REPLACEMENT CHARACTER}", html)


def figure_value(
    document: object, path: str, *, scale: float = 1e3, digits: int = 3, sign: str = ""
) -> Markup:
    """Return a number of a document times a scale, marked with its path in the JSON file."""
    value: Any = document
    for key in path.split("."):
        if value is not None:  # a placement of one sample has no errors before
            value = value[int(key)] if key.isdecimal() else getattr(value, key)
    text = "\N{EN DASH}" if value is None else fixed(scale * value, digits, sign)
    signed = f' data-sign="{sign}"' if sign else ""
    marks = (
        f'data-figure="{path}" data-scale="{scale:g}" data-digits="{digits}"{signed}'
    )
    return Markup(f'<span {marks} class="figure">{text}</span>')  # noqa: S704  all of it our own


_NUMBER = "\0"
"""Stands for the error that the task allows while the sentences are written."""


def answers_by_tolerance(report: ReportDocument) -> list[dict[str, object]]:
    """Return the answers for any error that the task may allow, the first for the smallest.

    Each from an error ``allowed`` [m] on: the answers at each placement, the answer in words, and
    the sentence below the map, both cut where the error is to be inserted.
    """
    changes = {0.0}  # tolerances at which the answer for a placement changes [m]
    for row in report.placements:
        least = figures.least_allowed(row)
        if least is not None:
            changes |= {figures.mostly_allowed(row), least}
    called = [row.called for row in report.answers.use.rows]
    steps: list[dict[str, object]] = []
    for allowed in sorted(changes):
        answers: list[Answer] = [
            figures.answer_at(row, allowed) for row in report.placements
        ]
        texts = {
            "use": figures.use_text(called, answers, _NUMBER, report.verdict.stamp),
            "map": map_sentence(report, answers, _NUMBER),
        }
        parts = {key: words.split(_NUMBER, 1) for key, words in texts.items()}
        steps.append({"allowed": allowed, "answers": answers, **parts})
    return steps


def report_page(report: ReportDocument, plots: Mapping[str, Sequence[Plot]]) -> str:
    """Return the report of a calibration as HTML; the first plots stand with the answers."""
    (_, (dots,)), (_, (table_map,)), *sections = plots.items()
    role, errors = report.summary.judged
    return render(
        "report.html.j2",
        report,
        {"by-tolerance": answers_by_tolerance(report)},
        report=report,
        role=role,
        judged=errors,
        role_name=ROLES.__getitem__,
        degrees=math.degrees(1),
        settings=_settings_text(report.provenance.settings),
        display_of=display_of,
        notes=figures.session_notes(report.provenance.data_sha256),
        dots=dots,
        table_map=table_map,
        folded=FOLDED,
        sections=[(title, group) for title, group in sections if group],
    )


def _settings_text(settings: Mapping[str, Any]) -> str:
    """Return the settings that were given, a line for each, by its name and values."""
    words: list[str] = []
    for name, value in settings.items():
        values = (
            cast("list[Any]", value) if isinstance(value, list | tuple) else [value]
        )
        if value not in (None, [], (), "", False):
            words.append(" ".join((name, *map(str, values))))
    return "\n".join(words)


def build_comparison(result: ComparisonDocument) -> dict[str, bytes]:
    """Return the files of a comparison of calibrations, with its plots, by name."""
    plots = comparison_plots(result)
    result = msgspec.structs.replace(
        result, plots=tuple(plot.caption for plot in plots)
    )
    html = render(
        "comparison.html.j2",
        result,
        result=result,
        sentences=[figures.comparison_sentence(result, pair) for pair in result.pairs],
        remarks=figures.model_remarks(result),
        plots=plots,
        names=short_names([row.name for row in result.placements]),
    )
    return _files("compare", result, html)


_SAMPLE = ("placement", "role", "socket", "sample", "where", "weight in the fit")


def residual_table(predictions: Predictions) -> bytes:
    """Return a row for each sample: its ball less the mean of its socket, by each model [mm].

    The models are the maker's URDF, the full model, and calibrated.urdf where that is another.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    rows = sample_errors(predictions, most=None)
    models = MODELS[: 2 + any(row.geometric is not None for row in rows)]
    parts = product(models, ("x", "y", "z", "error"))
    axes = [f"{name}_{part} [mm]" for name, part in parts]
    writer.writerow([*_SAMPLE, *axes])
    for row in rows:
        placement = predictions.placements[row.placement]
        cells = [placement.name, placement.role, row.socket, row.number, row.where]
        lengths = chain.from_iterable((*row.of(m), row.error(m)) for m in models)
        millimetres = [f"{1e3 * length:.5f}" for length in lengths]
        writer.writerow([*cells, row.weight, *millimetres])
    return out.getvalue().encode("utf-8", "replace")

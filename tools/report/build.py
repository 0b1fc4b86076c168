"""From a calibration to its report: first the figures, then the page that shows them."""

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import msgspec

from ..documents.calibration import CalibrationDocument
from ..documents.files import encode
from ..documents.report import PlotCaption, ReportDocument
from .figures.collect import Options, regularization_of, report_figures
from .figures.predictions import predict
from .page.report_page import page, plots_of

__all__ = ["Options", "Report", "build_report"]


_DEFAULTS = Options()


@dataclass(frozen=True)
class Report:
    """A report: its figures, and the page that shows them."""

    figures: ReportDocument
    html: str

    @property
    def files(self) -> dict[str, bytes]:
        """The files to write, by name."""
        return {
            "report.html": self.html.encode("utf-8", "replace"),
            "report.json": encode(self.figures) + b"\n",
        }


def build_report(
    document: CalibrationDocument, source: str, options: Options = _DEFAULTS
) -> Report:
    """Return the report of a calibration; the same calibration and options give the same bytes.

    Args:
        document: The calibration.
        source: Its file, for messages.
        options: Limits, known distances, tolerance.

    Raises:
        DocumentError: Parts of the document do not fit each other; the line names the key.
        MeasurementError: Its samples cannot be used.
        KnownError: A known distance names no socket of the calibration.
    """
    predictions = predict(document, source)
    regularization = regularization_of(document, source)
    figures = report_figures(predictions, options, regularization, command_of(document))
    plots = plots_of(figures)
    captions = tuple(
        PlotCaption(id=plot.id, section=section, title=plot.title, sentence=plot.sentence)
        for section, group in plots.items()
        for plot in group
    )
    figures = msgspec.structs.replace(figures, plots=captions)
    return Report(figures, page(figures, plots))


def command_of(document: CalibrationDocument) -> str:
    """Return the command that makes the calibration again."""
    folders = {
        role: [
            str(Path(row.files[0]).parent) if row.files else "?"
            for row in document.data
            if row.role == role
        ]
        for role in ("train", "test")
    }
    words = ["mukca", "solve", *folders["train"]]
    if folders["test"]:
        words += ["--test", *folders["test"]]
    words += ["--robot", document.robot, "--method", document.method]
    for key, value in document.settings.items():
        if value not in (None, [], False):
            values = cast("list[Any]", value) if isinstance(value, list) else [value]
            words += [f"--{key.replace('_', '-')}", *([] if value is True else values)]
    return shlex.join(map(str, words))

"""From a calibration to its report: first the figures, then the page that shows them."""

from dataclasses import dataclass

import msgspec

from ..documents.calibration import CalibrationDocument
from ..documents.files import encode
from ..documents.report import PlotCaption, ReportDocument
from .figures.collect import report_figures
from .figures.judged import Options
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
    figures = report_figures(document, source, options)
    plots = plots_of(figures)
    captions = tuple(
        PlotCaption(id=plot.id, section=section, title=plot.title, sentence=plot.sentence)
        for section, group in plots.items()
        for plot in group
    )
    figures = msgspec.structs.replace(figures, plots=captions)
    return Report(figures, page(figures, plots))

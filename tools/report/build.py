"""From a calibration to its report: first the figures, then the page that shows them."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from ...solver.assessment import Options
from ...solver.calibration import Calibration
from ...solver.results import CalibrationDocument, encode, refuse_existing, write_files
from .figures import ReportDocument, report_figures
from .page import report_page
from .plots import plots_of


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
    document: CalibrationDocument, source: str, options: Options | None = None
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
    figures = report_figures(document, source, options or Options())
    plots = plots_of(figures)
    captions = tuple(
        msgspec.structs.replace(plot.caption, section=section)
        for section, group in plots.items()
        for plot in group
    )
    figures = msgspec.structs.replace(figures, plots=captions)
    return Report(figures, report_page(figures, plots))


def report_files(calibration: Calibration) -> dict[str, bytes]:
    """Return the report's files, by name, with the limits that fit the arm."""
    return build_report(calibration.document, calibration.source).files


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
    return {"report": str(folder / "report.html"), "figures": str(folder / "report.json")}

"""A certificate: one sheet to sign, on what was measured at places that the fit did not see."""

from itertools import chain
from pathlib import Path

from ...errors import MukcaError
from ...solver.assessment import RoleSummaries, mm
from ...solver.results import CalibrationDocument
from . import figures
from .build import render
from .figures import ReportDocument

BLANK = "_" * 24
"""What nobody noted is filled in by hand."""
BAND = 1.96
"""Half the width of a 95 % interval, in standard deviations."""


class CertificateError(MukcaError):
    """A certificate that cannot be."""


def check_certificate(file: Path | None) -> None:
    """Refuse a file that is no HTML page; a browser prints the page to PDF."""
    if file is not None and file.suffix != ".html":
        raise CertificateError(
            f"--certificate {file}: only a .html page is written; print it to PDF in a browser"
        )


def certificate(document: CalibrationDocument, report: ReportDocument) -> bytes:
    """Return the sheet of a calibration.

    Raises:
        CertificateError: Nothing was held out.
    """
    if report.summary.test is None:
        raise CertificateError(
            "a certificate rests on held-out placements, and there is none: hold one out by --test"
        )
    files = list(chain.from_iterable(data.files for data in document.data))
    notes = figures.session_notes(files)
    facts = [(title, notes.get(title, BLANK)) for title in figures.NOTED.values()]
    facts += [
        ("Calibrated on", report.provenance.created[:10]),
        ("Payload at the ball", f"{document.load.payload:g} kg"),
        ("Measured with", report.distance_text),
    ]
    page = render(
        "certificate.html.j2",
        report,
        report=report,
        facts=facts,
        rows=_rows(report.summary),
        limits=_limits(report),
        hashes=[("model", report.provenance.model_sha256), *report.provenance.data_sha256.items()],
    )
    return page.encode("utf-8", "replace")


def _rows(summary: RoleSummaries) -> list[list[str]]:
    """Return errors at held-out places by each model: mean, 95 %, largest."""
    held_out = summary.judged[1]
    quantiles = held_out.quantiles
    models = (
        ("nominal model", held_out.nominal, quantiles.nominal),
        ("calibrated.urdf", held_out.loaded, quantiles.loaded),
    )
    rows: list[list[str]] = []
    for title, metrics, spread in models:
        errors = (metrics.mean_absolute_error, spread.p95, spread.max)
        rows.append([title, *(mm(error, 3) for error in errors)])
    return rows


def _limits(report: ReportDocument) -> list[list[str]]:
    """Return each limit, what was measured with its 95 % interval, and whether it is kept."""
    rows: list[list[str]] = []
    for row in report.verdict.limits:
        measured = "not measured" if row.found is None else mm(row.found, 3)
        if row.found is not None and row.deviation is not None:
            measured += f" \N{PLUS-MINUS SIGN}{mm(BAND * row.deviation, 3)}"
        agreed = "none" if row.limit is None else mm(row.limit, 3)
        rows.append([row.title, measured, agreed, row.status])
    return rows

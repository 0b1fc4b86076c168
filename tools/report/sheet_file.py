"""A certificate: one sheet to sign, as a page or as a PDF."""

from collections.abc import Mapping
from pathlib import Path

from ...solver.results import CalibrationDocument
from .build import render
from .figures import ReportDocument
from .sheet import CertificateError, sheet_of
from .sheet_pdf import draw, has_library


def check_certificate(file: Path | None) -> None:
    """Refuse a file that is neither a page nor a PDF that can be written here."""
    if file is None or file.suffix.lower() == ".html":
        return
    if file.suffix.lower() != ".pdf":
        raise CertificateError(f"--certificate {file}: end its name in .pdf or .html")
    if not has_library():
        raise CertificateError(
            f"--certificate {file}: a PDF needs fpdf2: pip install 'mukca[pdf]'; "
            f"or name a .html file, and print it from a browser"
        )


def certificate(
    document: CalibrationDocument,
    report: ReportDocument,
    kind: str,
    notes: Mapping[str, str] | None = None,
) -> bytes:
    """Return the sheet of a calibration as a file of a kind, ``.html`` or ``.pdf``.

    Raises:
        CertificateError: Nothing was held out, a note has no place on the sheet, or a PDF's fonts
            lack a letter.
    """
    sheet = sheet_of(document, report, notes)
    if kind == ".html":
        return render("certificate.html.j2", sheet, sheet=sheet).encode(
            "utf-8", "replace"
        )
    try:
        return draw(sheet)
    except UnicodeEncodeError as error:
        letter = error.object[error.start]
        raise CertificateError(
            f"--certificate: the fonts of a PDF lack the letter {letter!r}: name a .html file"
        ) from None

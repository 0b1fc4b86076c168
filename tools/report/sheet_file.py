"""A certificate: one sheet to sign, as a page, or as a PDF of one A4 page by fpdf2."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ...solver.results import CalibrationDocument
from .build import render
from .figures import ReportDocument
from .sheet import CertificateError, Section, Sheet, sheet_of

SIZES = (10, 9, 8, 7, 6)
"""Sizes of the letters [pt]: the largest with which all is on one page."""
MARGIN = 14
"""Around the page [mm]."""
GREY = 190
"""Of the lines of a table, 0 to 255."""
THIN = 0.1
"""Width of a line [mm]."""
LETTERS = "cp1252"
"""Encoding of the fonts that each PDF reader has."""


def check_certificate(file: Path | None) -> None:
    """Refuse a file that is neither a page nor a PDF that can be written here."""
    if file is None or file.suffix.lower() == ".html":
        return
    if file.suffix.lower() != ".pdf":
        raise CertificateError(f"--certificate {file}: end its name in .pdf or .html")
    if find_spec("fpdf") is None:
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
        return _drawn(sheet)
    except UnicodeEncodeError as error:
        letter = error.object[error.start]
        raise CertificateError(
            f"--certificate: the fonts of a PDF lack the letter {letter!r}: name a .html file"
        ) from None


def _drawn(sheet: Sheet) -> bytes:
    """Return a sheet as a PDF.

    Raises:
        UnicodeEncodeError: The fonts of a PDF lack a letter.
    """
    page = _Page(sheet, SIZES[0])
    for size in SIZES[1:]:
        if page.pdf.page_no() > 1:
            page = _Page(sheet, size)
    return bytes(page.pdf.output())


class _Page:
    """Draws a sheet from top to bottom, letters of one size [pt]."""

    def __init__(self, sheet: Sheet, size: float) -> None:
        from fpdf import FPDF

        self.size = size
        self.pdf: Any = FPDF(format="A4")
        self.pdf.core_fonts_encoding = LETTERS
        self.pdf.set_margin(MARGIN)
        self.pdf.set_auto_page_break(True, MARGIN)
        self.pdf.footer = self.footer
        self.pdf.set_creation_date(datetime.fromisoformat(sheet.created))
        self.pdf.set_title(f"Certificate, {sheet.title}")
        self.pdf.add_page()
        self.text(sheet.kind)
        self.text(sheet.title, 1.7, "B")
        for section in sheet.sections:
            self.section(section)
        self.signatures(sheet.signatures)

    def footer(self) -> None:
        """Write the number of the page, and of all, below it."""
        height = self.font(0.7)
        self.pdf.set_y(-MARGIN + height)
        words = f"Page {self.pdf.page_no()} of {self.pdf.str_alias_nb_pages}"
        self.pdf.cell(0, height, words, align="R")

    def font(
        self, scale: float = 1.0, style: str = "", family: str = "Helvetica"
    ) -> float:
        """Choose letters; return the height of a line of them [mm]."""
        self.pdf.set_font(family, style, self.size * scale)
        return 1.25 * self.pdf.font_size

    def text(
        self, text: str, scale: float = 1.0, style: str = "", family: str = "Helvetica"
    ) -> None:
        """Write a paragraph over the whole width."""
        text.encode(LETTERS)
        height = self.font(scale, style, family)
        self.pdf.multi_cell(0, height, text, align="L", new_x="LMARGIN", new_y="NEXT")

    def section(self, section: Section) -> None:
        """Write a section: title, lead, table, paragraphs, small lines."""
        self.pdf.ln(0.15 * self.size)
        if section.title:
            self.text(section.title, 1.1, "B")
        if section.lead:
            self.text(section.lead)
        self.table(section)
        for paragraph in section.paragraphs:
            self.text(paragraph)
        for line in section.small:
            self.text(line, 0.6, family="Courier")

    def table(self, section: Section) -> None:
        """Write a table with a line below each row; heads are bold, above or at the left."""
        rows = [section.heads, *section.rows] if section.heads else section.rows
        if not rows:
            return
        from fpdf import FontFace

        height = self.font()
        self.pdf.set_draw_color(GREY)
        self.pdf.set_line_width(THIN)
        columns: dict[str, Any] = {"col_widths": (1, 2)}
        if section.heads:
            columns = {"headings_style": FontFace(emphasis="B")}
        with self.pdf.table(
            align="L",
            text_align="L",
            borders_layout="HORIZONTAL_LINES",
            first_row_as_headings=bool(section.heads),
            line_height=height,
            **columns,
        ) as table:
            for cells in rows:
                row = table.row()
                for cell in cells:
                    cell.encode(LETTERS)
                    row.cell(cell)

    def signatures(self, titles: Sequence[str]) -> None:
        """Draw a line for each signature, beside each other."""
        gap = 12
        height = self.font()
        width = (self.pdf.epw - gap * (len(titles) - 1)) / len(titles)
        self.pdf.set_draw_color(0)
        self.pdf.ln(MARGIN)
        if self.pdf.will_page_break(height):
            self.pdf.add_page()
        for number, title in enumerate(titles):
            self.pdf.set_x(self.pdf.l_margin + number * (width + gap))
            self.pdf.cell(width, height, title, border="T")

"""XLSX files as text: the sheet of most cells, each row on the line of its number."""

import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree
from zipfile import BadZipFile, ZipFile
from zlib import error as ZlibError  # noqa: N812 (a class)

from .cells import NO_TEXT, with_signs
from .recording_error import RecordingError

_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_RELATION = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
_BOOK = "xl/workbook.xml"
LARGEST_PART = 50_000_000
"""Size that no sheet exceeds, unpacked [bytes]."""
MOST_CELLS = 5_000_000
_PLACE = re.compile(r"([A-Z]{1,3})([1-9]\d{0,6})")
"""Column and row of a cell, as AB12."""
_DAMAGED = (
    BadZipFile,
    ElementTree.ParseError,
    LookupError,
    RuntimeError,
    EOFError,
    ValueError,
    OSError,
    ZlibError,
)
"""Errors that a stranger's archive may raise."""


def sheet_text(content: bytes, file: Path) -> tuple[str, list[str]]:
    """Return the cells of an XLSX file as CSV, and the names of sheets that are not read.

    Raises:
        RecordingError: It is none, is damaged, or is too large; the message names the file.
    """
    try:
        with ZipFile(BytesIO(content)) as archive:
            strings: list[str] = []
            if "xl/sharedStrings.xml" in archive.namelist():
                root = _root(archive, "xl/sharedStrings.xml")
                strings = list(map(_words, root.iter(f"{_MAIN}si")))
            texts = {
                name: _text(archive, part, strings) for name, part in _sheets(archive)
            }
            sizes = {name: text.count(",") for name, text in texts.items()}
            largest = max(sizes, key=sizes.__getitem__)
            others = [n for n, text in texts.items() if text.strip() and n != largest]
            return with_signs(texts[largest]), others
    except _DAMAGED:
        raise RecordingError(f"{file}: {NO_TEXT}") from None


def _root(archive: ZipFile, part: str) -> ElementTree.Element:
    """Return the root of a part; a ValueError where it is too large or declares entities."""
    with archive.open(part) as stream:
        data = stream.read(LARGEST_PART + 1)
    text = data.decode("utf-8-sig")
    if len(data) > LARGEST_PART or "<!DOCTYPE" in text:
        raise ValueError(part)
    return ElementTree.fromstring(text)  # noqa: S314 (without declarations, see above)


def _sheets(archive: ZipFile) -> Iterator[tuple[str, str]]:
    """Yield name and part of each sheet, in the order of the book."""
    relations = _root(archive, "xl/_rels/workbook.xml.rels")
    targets = {r.get("Id"): r.get("Target", "") for r in relations}
    for sheet in _root(archive, _BOOK).iter(f"{_MAIN}sheet"):
        part = str(PurePosixPath("/xl") / targets[sheet.get(_RELATION)]).lstrip("/")
        if part.startswith("xl/worksheets/"):
            yield sheet.get("name", ""), part


def _words(element: ElementTree.Element) -> str:
    """Return the text of a cell on one line, without the marks of its pronunciation."""
    runs = [element, *element.findall(f"{_MAIN}r")]
    texts = [run.findtext(f"{_MAIN}t") or "" for run in runs]
    return " ".join("".join(texts).split())


def _text(
    archive: ZipFile,
    part: str,
    strings: list[str],
) -> str:
    """Return the cells of a sheet as CSV; a ValueError where one has no place or two."""
    rows: dict[int, dict[int, str]] = {}
    for cell in _root(archive, part).iter(f"{_MAIN}c"):
        match = _PLACE.fullmatch(cell.get("r", ""))
        if not match:
            raise ValueError(part)
        column = 0
        for letter in match[1]:
            column = 26 * column + ord(letter) - ord("A") + 1
        kind, content = cell.get("t", "n"), cell.findtext(f"{_MAIN}v") or ""
        if kind != "n":  # a number is as the sheet keeps it, words are between quotes
            inline = cell.find(f"{_MAIN}is")
            words = content if inline is None else _words(inline)
            words = strings[int(content)] if kind == "s" else words
            escaped = words.replace('"', "'")
            content = f'"{escaped}"' if escaped else ""
        rows.setdefault(int(match[2]), {})[column] = content
    width = max((max(cells) for cells in rows.values()), default=0)
    if width * len(rows) > MOST_CELLS:
        raise ValueError(part)
    lines = [""] * max(rows, default=0)
    for number, cells in rows.items():
        filled = [cells.get(column, "") for column in range(1, width + 1)]
        lines[number - 1] = ",".join(filled) if any(filled) else ""
    return "\n".join(lines) + "\n"

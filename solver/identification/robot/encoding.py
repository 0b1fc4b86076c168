"""The encoding of a URDF: whatever it is, the text goes on in UTF-8.

PowerShell's ``>`` writes UTF-16, and editors write what their country used before.
"""

import codecs
import re

from ....errors import MukcaError

_DECLARATION = re.compile(rb"\A\s*<\?xml\b[^>]*\?>")
_ENCODING = re.compile(rb"(\bencoding\s*=\s*)([\"'])([^\"']*)\2")
_MARKS = {
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF32_LE: "utf-32-le",
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
"""Encoding by the first bytes; UTF-32 before UTF-16, whose mark it begins with."""
_LIKE_UTF8 = ("utf", "ucs", "us-ascii", "ascii")
"""Beginnings of declared encodings under which a declaration in ASCII is followed by UTF-8."""
_OTHERS = {
    rb"\s*(?i:<!doctype html|<html)": "a web page, not a URDF; download the raw file",
    rb"404: Not Found": "what a server says of a file that it lacks; look at the address",
    rb"\x1f\x8b|PK\x03\x04": "an archive; unpack it, and give the URDF in it",
}
"""What other files begin with, and what is said of them."""


class ModelError(MukcaError):
    """A robot model cannot be read, or is not what calibration needs."""


def in_utf8(data: bytes, source: str) -> bytes:
    """Return a model's text in UTF-8, whose declaration says so; nothing else is changed.

    Blanks before the declaration, which XML forbids, are read all the same: the declaration goes.

    Raises:
        ModelError: The text is not in the encoding that it declares, or in UTF-8; or the file
            is a web page or an archive.
    """
    for beginning, words in _OTHERS.items():
        if re.match(beginning, data):
            raise ModelError(f"{source}: {words}")
    mark = next((mark for mark in _MARKS if data.startswith(mark)), b"")
    wide = _MARKS.get(mark) or _without_mark(data)
    if wide is not None:
        data = _recoded(data.removeprefix(mark), wide, source)
    declaration = _DECLARATION.match(data)
    if declaration is None:
        return _recoded(data, "utf-8", source)
    head = declaration[0]
    body = data[declaration.end() :]
    declared = _ENCODING.search(head)
    name = declared[3].decode("ascii", "replace") if declared else "utf-8"
    in_utf8_by_now = wide is not None or name.lower().startswith(_LIKE_UTF8)
    body = _recoded(
        body, "utf-8" if in_utf8_by_now else name, source, head.count(b"\n")
    )
    if head[:1].isspace():
        return b"\n" * head.count(b"\n") + body
    same = name.lower() in ("utf-8", "us-ascii", "ascii")
    return head + body if same else _ENCODING.sub(rb"\1\2UTF-8\2", head) + body


def _without_mark(data: bytes) -> str | None:
    """Return the encoding of a UTF-16 text without a mark, which has a zero in each ASCII sign."""
    if b"\0" not in data[:2]:
        return None
    return "utf-16-be" if data[:1] == b"\0" else "utf-16-le"


def _recoded(
    data: bytes,
    encoding: str,
    source: str,
    lines_before: int = 0,
) -> bytes:
    try:
        return data.decode(encoding).encode()
    except UnicodeDecodeError as error:
        line = 1 + lines_before + data[: error.start].count(b"\n")
        raise ModelError(
            f"{source}:{line}: not in {encoding}, as which it is read; save the file as UTF-8"
        ) from None
    except (LookupError, ValueError):
        raise ModelError(
            f"{source}: its first line declares the encoding {encoding!r:.40}, which is unknown; "
            "save the file as UTF-8"
        ) from None

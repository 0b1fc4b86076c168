"""What is refused: the base of all errors that a user can mend, and bounds of files and numbers.

Numbers in messages, and wherever else people read them, are written by :func:`fixed`.

Files that others wrote are opened by one function: no device, no pipe, nothing without end. Degrees
typed for radians, millimetres for metres and grams for kilograms lead to other numbers without a
word: whoever reads such a number asks its :class:`Quantity` whether it can be.
"""

import errno
import json
import math
import os
import re
import stat
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


class MukcaError(Exception):
    """Base of all errors that a user can mend; the message is one line.

    The line says what is wrong, where (file, line, joint), and what would work.

    Attributes:
        failed: The input was good, and the work ran, but its result is not to be used.
    """

    failed: bool = False

    def __str__(self) -> str:
        return shortened(super().__str__())


class NotConverged(MukcaError):  # noqa: N818 (the situation's name)
    """A fit gave up, and where it stopped is not to be used."""

    failed = True


LONGEST_WORD, LONGEST_LINE = 400, 4000
"""Characters of what a message quotes, and of a whole message."""


def shortened(text: str) -> str:
    """Return a message whose long words have lost their middles, and the whole if it is long."""
    text = re.sub(
        rf"\S{{{LONGEST_WORD},}}", lambda word: _ends(word[0], LONGEST_WORD), text
    )
    return _ends(text, LONGEST_LINE)


def _ends(text: str, most: int) -> str:
    """Return a text's beginning and end, which are at most so many characters."""
    half = most // 2 - 3
    return text if len(text) <= most else f"{text[:half]} ... {text[-half:]}"


_STEERING = re.compile(
    "[\0-\x08\x0b-\x1f\x7f-\x9f\udc80-\udc9f"  # control characters, also as single bytes
    "\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]"  # what ends or turns a line
)


def cleaned(text: str) -> str:
    """Return a text in which nothing steers the terminal that shows it.

    Names in files, and of files, are a stranger's: an ESC in them could set the window's title or
    the clipboard. Ends of lines and tabs stay.
    """
    return _STEERING.sub("?", text)


def fixed(value: float, digits: int, sign: str = "") -> str:
    """Return a number with so many decimals, as people read it; what rounds to zero has no sign."""
    text = f"{value:{sign}.{digits}f}"
    return text if float(text) else text.lstrip("+-")


def millimetres(metres: float | None, digits: int = 3) -> str:
    """Return a length in millimetres without its unit, as it stands in tables; - for None."""
    return "-" if metres is None else fixed(1e3 * metres, digits)


LARGEST_FILE = 200_000_000
"""Size that no table, log or image exceeds [bytes]."""
LARGEST_DOCUMENT = 20_000_000
"""Size that no model and no JSON file exceeds, which take far more memory [bytes]."""
LFS = b"version https://git-lfs"
"""Begin of a file that stands for another one, which git did not bring."""
_KINDS = {
    stat.S_IFDIR: (errno.EISDIR, "a folder"),
    stat.S_IFIFO: (errno.ESPIPE, "a pipe"),
    stat.S_IFSOCK: (errno.ENXIO, "a socket of the system"),
    stat.S_IFCHR: (errno.ENODEV, "a device"),
    stat.S_IFBLK: (errno.ENODEV, "a device"),
}


class RefusedFileError(MukcaError, OSError):
    """A path is no file, or a file is too large to read; whoever handles missing files has it."""

    def __str__(self) -> str:
        return shortened(f"{self.filename}: {self.strerror}")


def require_file(file: Path, largest: int | None = LARGEST_FILE) -> None:
    """See that a path, or what it links to, is a file, before anything opens it.

    Args:
        file: The path.
        largest: The size that is read at most [bytes]; None for files that are read in parts.

    Raises:
        OSError: There is nothing, or a :class:`RefusedFileError`, it is no file or is too large.
    """
    status = file.stat()
    if not stat.S_ISREG(status.st_mode):
        number, kind = _KINDS.get(
            stat.S_IFMT(status.st_mode), (errno.EINVAL, "no file")
        )
        raise RefusedFileError(number, f"is {kind}", str(file))
    with file.open("rb") as stream:
        if stream.read(len(LFS)) == LFS:
            words = "is a Git LFS pointer, not the data: git lfs pull brings that"
            raise RefusedFileError(errno.ENODATA, words, str(file))
    if largest is not None and status.st_size > largest:
        words = f"holds {status.st_size / 1e6:,.1f} MB; at most {largest / 1e6:,.0f} MB are read"
        raise RefusedFileError(errno.EFBIG, words, str(file))


def read_bytes(file: str | os.PathLike[str], largest: int = LARGEST_FILE) -> bytes:
    """Return the content of a file; see :func:`require_file` for what is refused."""
    path = Path(file)
    require_file(path, largest)
    return path.read_bytes()


LARGEST_NUMBER = 1e20
"""Absolute value that no number in a file exceeds, nanoseconds since 1970 among them."""


def is_number(value: float) -> bool:
    """Return whether a number can have been measured: finite, its powers too."""
    return abs(value) <= LARGEST_NUMBER


def reason_of(error: Exception) -> str:
    """Return why a file cannot be read, without the number and the path of an OSError."""
    return getattr(error, "strerror", None) or str(error)


def read_json(file: str | os.PathLike[str]) -> Any:
    """Return what a JSON file holds.

    Raises:
        OSError: As by :func:`require_file`.
        ValueError: The file is no JSON, nested too deeply, or holds a number beyond all bounds.
    """
    content = read_bytes(file, LARGEST_DOCUMENT)
    try:
        return json.loads(
            content,
            parse_int=_integer,
            parse_float=_number,
            parse_constant=_number,
        )
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def read_beside(module: str, name: str) -> Any:
    """Return what a JSON file beside a module, by the module's ``__file__``, holds."""
    return read_json(Path(module).with_name(name))


def _number(text: str) -> float:
    """Return the number that a text is; refuse one that nobody can measure."""
    value = float(text)
    if not is_number(value):
        raise ValueError(f"it holds {text:.20}, and numbers end at {LARGEST_NUMBER:g}")
    return value


def _integer(text: str) -> int:
    """Return the integer that a text is, as :func:`_number` does."""
    _number(text)
    return int(text)


@dataclass(frozen=True)
class Quantity:
    """A kind of number, its unit, and the unit that is typed by mistake."""

    unit: str
    largest: float
    """Absolute value that none exceeds."""
    mistaken: str

    def doubt(
        self, values: Iterable[float], largest: float | None = None
    ) -> str | None:
        """Return what is doubtful of the largest number, or None where all of them can be.

        Args:
            values: Numbers in the quantity's unit.
            largest: A narrower range than the quantity's own, as an arm's reach.
        """
        worst = max(values, key=abs, default=0.0)
        if abs(worst) <= (self.largest if largest is None else largest):
            return None
        return f"{worst:.6g}: {self.unit} are expected (are these {self.mistaken}?)"


ROTATION = Quantity("radians", 2 * math.pi + 1e-3, "degrees")
"""Roll, pitch or yaw of a pose, a tool or a link."""
JOINT_POSITION = Quantity("radians", 8 * math.pi, "degrees")
"""Position of a joint that turns."""
ON_FLANGE = Quantity("metres", 5.0, "millimetres")
"""Place of a tool, ball or payload in the flange's frame."""
LENGTH = Quantity("metres", 20.0, "millimetres")
"""Length of a link, or distance of a frame from the arm's base."""
PAYLOAD = Quantity("kilograms", 1000.0, "grams")
"""Mass that an arm carries beyond its model's."""
MASS = Quantity("kilograms", 5000.0, "grams")
"""Mass of all that an arm moves."""

"""Names of columns: their units, their words, and those that only count or date the rows."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import read_json

_TABLE: dict[str, Any] = read_json(Path(__file__).with_name("units.json"))
DEGREES: list[str] = _TABLE["degrees"]
ANGLES: dict[str, float] = _TABLE["angles"]
"""Units of angles [rad]."""
LENGTHS: dict[str, float] = _TABLE["lengths"]
"""Units of lengths [m]."""
SIZES = ANGLES | LENGTHS
UNITS: list[str] = _TABLE["known"]
"""All of them, each by one name."""
OTHER_UNITS: list[str] = _TABLE["others"]
"""Units of what else stands in tables."""


PENDANTS: list[list[str]] = _TABLE["pendants"]
"""Joints as pendants call them, base to tip: Universal Robots', and Yaskawa's."""
_UNIT = re.compile(
    r"(.*?)[\s_]*(?:\[\s*([^\d\W][^\]]*|°)\]|\(\s*([^\d\W][^)]*|°)\)|"
    r"[\s_/]+(deg(?:rees?)?|grad|rad(?:ians?)?|[°º]|mm|cm))",
    re.IGNORECASE,
)
_METRES = re.compile(r"((?:.*[\W_])?(?:[xyz]|distance|deviation))_m", re.IGNORECASE)
_DEGREES = re.compile(r"(?:^|[\W_])(deg(?:rees?)?)(?:[\W_]|$)", re.IGNORECASE)
_WORDS = re.compile(r"[^\W\d_]+|\d+")
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")

_ASIDE = re.compile(
    "times?|(time)?stamp|datetime|date|t|secs?|seconds|n(ano)?sec|msec|[mun]s|index|idx|id|no|nr|"
    "number|row|unnamed|seq|header|field|frame|image|file|filename|name|level"
)
"""Words of columns that count or date the rows."""

Names = Sequence[str]
"""Names of columns, or of joints."""
Words = tuple[str, ...]


@dataclass(frozen=True)
class Column:
    """A column of a table: the name without its unit, and the unit in small letters."""

    index: int
    name: str
    unit: str = ""

    @property
    def words(self) -> Words:
        """Return the words of the name."""
        return words_of(self.name)

    @property
    def may_be_joint(self) -> bool:
        """True where it has a name, and no unit that no joint has."""
        return bool(self.words) and (not self.unit or _is_unit(self.unit))

    @property
    def aside(self) -> bool:
        """True where it counts or dates the rows, or has a unit that no joint has."""
        letters = list(filter(is_word, self.words))
        return not self.may_be_joint or (bool(letters) and all_match(_ASIDE, letters))


def column_of(index: int, cell: str, below: str = "") -> Column:
    """Return the column that a header's cell names, and the cell below it where units stand."""
    name = cell.strip()
    unit = below.strip(" []()")
    match = _UNIT.fullmatch(name)
    metres = _METRES.fullmatch(name)
    degrees = _DEGREES.search(name)
    if match and (match[3] is None or _is_unit(match[3])):
        name = match[1]
        unit = match[2] or match[3] or match[4]
    elif metres:
        name = metres[1]
        unit = "m"
    elif not unit and degrees:
        unit = degrees[1]
    return Column(index, name.strip(), unit.strip().lower())


def _is_unit(text: str) -> bool:
    return text.strip().lower() in SIZES


def words_of(name: str) -> Words:
    """Return the words and numbers of a name in small letters, without its unit."""
    words: list[str] = _WORDS.findall(_CAMEL.sub("_", name).lower())
    numbers = [word.lstrip("0") or "0" if word.isdecimal() else word for word in words]
    names = [word for word in numbers if word not in ANGLES]
    return tuple(names or numbers)


def is_word(word: str) -> bool:
    """Tell whether a word of a name is no number."""
    return not word.isdecimal()


def all_match(kind: re.Pattern[str], words: Sequence[str]) -> bool:
    """Tell whether all words are of a kind."""
    return all(map(kind.fullmatch, words))

"""Words of the names of columns, and units, by ``words.json``."""

import re
from collections.abc import Sequence
from typing import Any

from ..errors import read_beside

_TABLE: dict[str, Any] = read_beside(__file__, "words.json")
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
COORDINATES: dict[str, str] = _TABLE["coordinates"]
"""Names of coordinates and what they are called here."""
LETTERS: dict[str, str] = _TABLE["letters"]
"""Words before an axis, and the letter that stands for them here, as in qx."""
WORDS = {kind: re.compile("|".join(words)) for kind, words in _TABLE["words"].items()}
"""Words of names by what they tell."""
_WORDS = re.compile(r"[^\W\d_]+|\d+")
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")

Names = Sequence[str]
"""Names of columns, or of joints."""
Words = tuple[str, ...]


def words_of(name: str) -> Words:
    """Return the words and numbers of a name in small letters, without its unit."""
    words: list[str] = _WORDS.findall(_CAMEL.sub("_", name).lower())
    numbers = [word.lstrip("0") or "0" if word.isdecimal() else word for word in words]
    names = [word for word in numbers if word not in ANGLES]
    return tuple(names or numbers)


def any_match(kind: re.Pattern[str], words: Sequence[str]) -> bool:
    """Tell whether a word is of a kind."""
    return any(map(kind.fullmatch, words))


def is_word(word: str) -> bool:
    """Tell whether a word of a name is no number."""
    return not word.isdecimal()


def all_match(
    kind: re.Pattern[str],
    words: Sequence[str],
) -> bool:
    """Tell whether all words are of a kind."""
    return all(map(kind.fullmatch, words))

"""Numbers in words and round numbers, the same wherever a report speaks."""

import math
from collections.abc import Sequence

from ...errors import fixed
from ...errors import millimetres as millimetres
from ..results import Apart


def mm(metres: float, digits: int = 2) -> str:
    """Return a length in millimetres."""
    return f"{fixed(1e3 * metres, digits)} mm"


def percent(fraction: float) -> str:
    """Return a share in percent; 0 % and 100 % are written only where they are exact."""
    rounded = round(100 * fraction)
    if 0 < fraction < 1:
        rounded = min(max(rounded, 1), 99)
    return f"{rounded} %"


def plural(count: int, word: str) -> str:
    """Return a count with its noun, as in "1 sample" and "2 samples"."""
    return f"{count} {word}" if count == 1 else f"{count} {word}s"


def joined(words: Sequence[str]) -> str:
    """Return a list in words, as in "front, left and right"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} and {words[-1]}"


def short_names(names: Sequence[str]) -> list[str]:
    """Return placements' names without the folder that all of them share."""
    if len({name.rpartition("/")[0] for name in names}) > 1:
        return list(names)
    return [name.rpartition("/")[2] for name in names]


def area(position: Sequence[float], *, brief: bool = False) -> str:
    """Return where a point [m] lies as the robot sees it: its x is ahead, its y to the left."""
    unit, side, below = ("", "", "down") if brief else (" m", "to its ", "below")
    ways = (("ahead", "behind"), (f"{side}left", f"{side}right"), ("up", below))
    words = [
        f"{abs(v):.2f}{unit} {way[v < 0]}"
        for v, way in zip(position, ways, strict=True)
        if abs(v) >= 5e-3
    ]
    return ", ".join(words) or ("at the base" if brief else "at its base")


def short_where(where: str) -> str:
    """Return a file and line with no more folders than tell placements apart."""
    return "/".join(where.split("/")[-3:])


def nice_above(value: float, digits: Sequence[float] = (1, 2, 2.5, 5, 10)) -> float:
    """Return the smallest round number, a digit times a power of ten, not below one above zero."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(d * power for d in digits if d * power >= value * (1 - 1e-9))


def apart_words(difference: Apart | None) -> str:
    """Return how far two calibrations are apart, and by chance, in millimetres without the unit."""
    if difference is None:
        return "-"
    chance = f"{millimetres(difference.chance)} +- {millimetres(difference.deviation)}"
    return f"{millimetres(difference.value)}{'!' * difference.beyond_chance} (by chance {chance})"

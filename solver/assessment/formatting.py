"""Numbers in words and round numbers, the same wherever a report speaks."""

import math
from collections.abc import Sequence

from ...errors import fixed
from ..results import Apart, Better, Interval


def mm(metres: float, digits: int = 2) -> str:
    """Return a length in millimetres."""
    return f"{fixed(1e3 * metres, digits)} mm"


def millimetres(metres: float | None, digits: int = 3) -> str:
    """Return a length in millimetres without its unit, as it stands in tables; - for None."""
    return "-" if metres is None else fixed(1e3 * metres, digits)


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


def in_100(probability: float) -> str:
    """Return a probability as "99 in 100"; it is never 0 or 100."""
    return f"{min(max(round(100 * probability), 1), 99)} in 100"


def short_mm(metres: float) -> str:
    """Return millimetres with two digits that count, such as 2.8, 0.23 and 12."""
    value = 1e3 * metres
    return fixed(value, 0 if value >= 9.95 else 1 if value >= 0.995 else 2)


def interval_text(interval: Interval) -> str:
    """Return a 68 % interval [m] in millimetres, as in "68 %: 0.33 to 0.81"."""
    return f"68 %: {short_mm(interval.low)} to {short_mm(interval.high)}"


def figures_in_words(better: Better) -> str:
    """Return the errors of distances before and now."""
    everywhere, recorded = better.workspace, better.recorded_places
    words = (
        f"A distance anywhere in the workspace is now wrong by about "
        f"{short_mm(everywhere.now.value)} mm (was {short_mm(everywhere.before.value)})"
    )
    if recorded is not None:
        words += f"; near the recorded places by {short_mm(recorded.now.value)}"
    return f"{words}."


def intervals_in_words(better: Better | None) -> list[str]:
    """Return the errors of distances with their intervals, a line for each kind of places."""
    lines: list[str] = []
    if better is None:
        return lines
    for where, errors in (
        ("in the workspace", better.workspace),
        ("near the recorded places", better.recorded_places),
    ):
        if errors is None:
            continue
        named = [("now", errors.now), ("corrected joints", errors.corrected)]
        figures = [f"was {_with_interval(errors.before)}"]
        figures += [f"{name} {_with_interval(one)}" for name, one in named if one]
        lines.append(f"Error of distances {where}, mm: {'; '.join(figures)}.")
    return lines


def _with_interval(error: Interval) -> str:
    return f"{short_mm(error.value)} ({interval_text(error)})"


def corrected_joints_in_words(better: Better, probability: float) -> str:
    """Return where to command with corrected joints, which are better than the nominal model."""
    everywhere, recorded = better.workspace, better.recorded_places
    anywhere = everywhere.corrected
    near = recorded and recorded.corrected
    assert anywhere is not None  # its probability is known
    if anywhere.value <= everywhere.now.value:
        return (
            f"Command with corrected joints: a distance is then wrong by about "
            f"{short_mm(anywhere.value)} mm ({in_100(probability)} that this is better)."
        )
    if recorded is None or near is None or near.value > recorded.now.value:
        return "Corrected joints are no better than this."
    return (
        f"Command with corrected joints near the recorded places only: "
        f"{short_mm(near.value)} mm there, {short_mm(anywhere.value)} elsewhere."
    )

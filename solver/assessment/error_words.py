"""Words for the errors of distances, before a calibration and by it."""

from ...errors import fixed
from ..results import Better, Interval


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
    now, before = [short_mm(e.value) for e in (everywhere.now, everywhere.before)]
    if recorded is not None and now == before:
        return (
            f"With the new URDF, a distance near the recorded places is wrong by about "
            f"{short_mm(recorded.now.value)} mm (was {short_mm(recorded.before.value)}); "
            f"elsewhere by {now}, as before."
        )
    words = (
        f"With the new URDF, a distance anywhere in the workspace is wrong by about "
        f"{now} mm (was {before})"
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

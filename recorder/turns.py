"""Positions of joints that turn: a whole turn is nothing.

Encoders lose or gain turns when they are switched on, and drivers publish -pi to pi or 0 to 2 pi;
the arm stands the same. A joint that slides has no turns.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

TURN = 2 * math.pi
_ROUNDING = 1e-9
ALL_ROUND = TURN - 0.2
"""A joint whose limits are farther apart can stand anywhere on the circle [rad]."""


def without_turn(difference: float) -> float:
    """Return a difference of two positions of a joint that turns, -pi to pi [rad]."""
    return difference - TURN * round(difference / TURN)


def around(differences: np.ndarray, turning: Sequence[bool]) -> np.ndarray:
    """Return differences of joint positions the short way round the circle, shape (..., m)."""
    turns = np.rint(differences / TURN)
    return differences - np.where(turning, TURN * turns, 0.0)


def within(
    position: float,
    lower: float,
    upper: float,
) -> bool:
    """Return whether a joint that turns is inside its limits, some whole turns on."""
    if not math.isfinite(upper - lower):
        return True
    turns = math.floor((position - lower) / TURN)
    return lower <= position - TURN * turns <= upper


def arc(intervals: Iterable[tuple[float, float]]) -> tuple[float, float]:
    """Return the least arc, from low to high, that holds some arcs of the circle [rad].

    Single positions are arcs from a position to itself.
    """
    lows, highs = np.array([*intervals]).T
    starts = lows % TURN
    ends = starts + highs - lows
    order = np.lexsort((lows, ends, starts))
    starts = starts[order]
    reaches = np.maximum.accumulate(ends[order])
    next_starts = np.append(starts[1:], starts[0] + TURN)
    gaps_before = np.roll(next_starts - reaches, 1)
    gap = float(gaps_before.max())
    first = int(gaps_before.argmax()) if gap > 0 else 0
    begin = float(lows[order[first]])
    return begin, begin + TURN - max(gap, 0.0)


def without_turns(
    positions: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    turning: Sequence[bool],
) -> np.ndarray:
    """Return joint positions, shape (N, m) [rad], each column on the least arc that holds it.

    A joint that cannot go all round is put inside its limits instead, if its whole column can be.
    Positions that need no change stay as they are to the last digit.
    """
    unwound = np.array(positions, dtype=float)
    for i in np.flatnonzero(turning).tolist():
        q, low, high = unwound[:, i].copy(), float(lower[i]), float(upper[i])
        choices = [q]
        if high - low >= ALL_ROUND:
            choices = [*_on_arc(q), q]
        if math.isfinite(high - low):
            choices.append(low + (q - low) % TURN)
        for choice in choices:
            if low <= choice.min() and choice.max() <= high:
                unwound[:, i] = np.where(np.abs(choice - q) < 1.0, q, choice)
                break
    return unwound


def _on_arc(q: np.ndarray) -> list[np.ndarray]:
    """Return positions of one joint on the least arc that holds them, some whole turns on.

    First comes the turn on which most of the positions are.
    """
    start, end = arc((x, x) for x in q.tolist())
    on_arc = q
    if np.ptp(q) > end - start + _ROUNDING:
        on_arc = start + (q - start + _ROUNDING) % TURN - _ROUNDING
    turns = np.rint((q - on_arc) / TURN)
    numbers, counts = np.unique(turns, return_counts=True)
    usual_first = numbers[np.argsort(-counts)].tolist()
    return [on_arc + TURN * k for k in (*usual_first, -1, 1, -2, 2)]

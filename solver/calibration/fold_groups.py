"""Groups of samples that one fold leaves out: placements of one place, or a region of joint space.

Neighbours stay together, since what a fit has seen beside a sample tells it of that sample.
"""

from collections.abc import Sequence
from itertools import chain, combinations

import numpy as np

from ..identification.data import NEAREST, Measurement, is_copy

MOST = 10
"""Folds at most: where there are more places, those side by side are left out together."""
REGIONS = 5
"""Folds of a single set-up of an instrument."""
FEWEST = 4 * REGIONS
"""Points below which a set-up is not divided."""
SLACK = 0.1
"""Share of a region by which its border may move to where the samples leave a gap."""

Group = dict[int, np.ndarray]
"""Samples of placements by the placements' indices, as ranks in the order of recording."""


def groups_of(
    measurements: Sequence[Measurement], places: Sequence[np.ndarray]
) -> list[Group]:
    """Return the groups that folds leave out; none where nothing else would be left.

    Args:
        measurements: Placements, in sockets or by an instrument.
        places: Middle of each placement's balls [m].
    """
    together = _by_place(measurements, places)
    if len(together) > MOST:
        middles = [np.mean([places[i] for i in group], axis=0) for group in together]
        merged: list[list[int]] = []
        for region in regions(np.array(middles), MOST):
            ranks: list[int] = region.tolist()
            merged.append([*chain.from_iterable(together[k] for k in ranks)])
        together = merged
    if len(together) > 1:
        return [
            {i: np.arange(len(measurements[i].positions)) for i in sorted(group)}
            for group in together
        ]
    first = measurements[0]
    count = len(first.positions)
    if len(measurements) > 1 or first.kind == "sockets" or count < FEWEST:
        return []
    return [{0: first.order[rows]} for rows in regions(first.positions, REGIONS)]


def _by_place(
    measurements: Sequence[Measurement], places: Sequence[np.ndarray]
) -> list[list[int]]:
    """Return the indices of placements, those of one place together, and copies."""
    groups = [[i] for i in range(len(measurements))]
    for i, j in combinations(range(len(measurements)), 2):
        pair = measurements[i], measurements[j]
        in_sockets = all(m.kind == "sockets" for m in pair)
        gap = float(np.linalg.norm(places[i] - places[j]))
        if not (in_sockets and gap < NEAREST) and not is_copy(*pair):
            continue
        first, second = (
            next(group for group in groups if index in group) for index in (i, j)
        )
        if first is not second:
            first += second
            groups.remove(second)
    return groups


def regions(points: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the rows of points, shape (N, n), in so many regions of about as many points each.

    A region is cut in two across its longest side, at the widest gap near the middle.
    """
    parts: list[np.ndarray] = []
    pending = [(np.arange(len(points)), count)]
    while pending:
        rows, number = pending.pop(0)
        if number == 1:
            parts.append(np.sort(rows))
            continue
        half = number // 2
        lower, upper = _cut(points, rows, half / number, SLACK / number)
        pending += [(lower, half), (upper, number - half)]
    return sorted(parts, key=lambda rows: int(rows[0]))


def _cut(
    points: np.ndarray, rows: np.ndarray, share: float, slack: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return rows on either side of a plane that has about a share of them below."""
    along = points[rows, np.argmax(np.ptp(points[rows], axis=0))]
    order = np.argsort(along, kind="stable")
    steps = np.diff(along[order])
    middle = round(share * len(rows))
    reach = int(slack * len(rows))
    first = max(middle - reach - 1, 0)
    cut = first + int(np.argmax(steps[first : middle + reach])) + 1
    return rows[order[:cut]], rows[order[cut:]]

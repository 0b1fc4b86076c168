"""Folds of a calibration: whole fits that each leave out a place, or a region of joint space.

Checks of the recordings are made once, before. Each fold chooses its effects anew.

A fold leaves out the placements of one place, or a region of joint space. Neighbours stay
together, since what a fit has seen beside a sample tells it of that sample.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain, combinations
from math import dist

import numpy as np

from ...errors import MukcaError
from ..identification import Prior, Progress
from ..identification.data import NEAREST, Measurement, is_copy
from ..results import Fit, Fold
from ..tables import in_placements
from .fit import CalibrationProblem, Methods, ball_refitted, fit_robot

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
    is_small = len(first.positions) < FEWEST
    if len(measurements) > 1 or first.kind == "sockets" or is_small:
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
        gap = dist(places[i], places[j])
        if not (in_sockets and gap < NEAREST) and not is_copy(*pair):
            continue
        first, second = [next(g for g in groups if index in g) for index in (i, j)]
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


def with_folds(
    problem: CalibrationProblem,
    fit: Fit,
    prior: Callable[[CalibrationProblem], Prior] = lambda _: None,
    progress: Progress = lambda _: None,
    *,
    methods: Methods,
) -> CalibrationProblem:
    """Return a problem with a fold for each group of samples that its fit is proven by.

    A fold that cannot be fitted is left out, with a warning. Where placements are held out, they
    prove the fit, and there are no folds.

    Args:
        problem: What the fit is to.
        fit: The fit to all.
        prior: What is known of the robot before; see :func:`.calibrate_robot`.
        progress: Called with a word for each fold.
        methods: Those of the fit.
    """
    if problem.test or problem.options.no_proof:
        return problem
    measurements = problem.measurements
    places = [fit.calibrated.predict(m).mean(axis=0) for m in measurements]
    folds: list[Fold] = []
    warnings = list(problem.warnings)
    for group in groups_of(measurements, places):
        names = ", ".join(measurements[i].name for i in group)
        progress(f"to prove the fit, leaves out {names}")
        part, left_out = _divided(problem, group)
        try:
            known = prior(part)
            arm = fit_robot(
                part, part.options, methods, prior=known, require_scale=False
            )
        except (MukcaError, np.linalg.LinAlgError) as error:
            words = "the fit to all others fails, so nothing proves it there"
            warnings.append(f"{names}: {words}: {error}")
            continue
        fold = Fold(arm, ball_refitted(part), tuple(part.measurements), left_out)
        folds.append(fold)
    return replace(problem, folds=tuple(folds), warnings=tuple(warnings))


def _divided(
    problem: CalibrationProblem, group: Group
) -> tuple[CalibrationProblem, tuple[Measurement, ...]]:
    """Return the problem without a group of samples, and these."""
    trained: list[Measurement] = []
    left_out: list[Measurement] = []
    for i, measured in enumerate(problem.measurements):
        ranks = group.get(i, np.zeros(0, int))
        remaining = np.setdiff1d(np.arange(len(measured.positions)), ranks)
        for part, rows in ((trained, remaining), (left_out, ranks)):
            if rows.size:
                is_whole = len(rows) == len(measured.positions)
                part.append(measured if is_whole else measured.only(rows))
    names = {m.name for m in trained}
    options = problem.options
    located = options.located
    every_place = [socket.socket[0] for socket in located]
    options = replace(
        options,
        known=[k for k in options.distances if {k.first[0], k.second[0]} <= names],
        sockets_at=in_placements(located, sorted(names), every_place),
    )
    part = replace(problem, measurements=tuple(trained), options=options)
    return part, tuple(left_out)

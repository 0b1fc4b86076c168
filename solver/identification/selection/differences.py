"""The choice of what differs between places, by the evidence of the whole fit."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from heapq import nlargest
from itertools import chain, groupby
from math import inf, log

import numpy as np

from ....errors import NotConverged
from ..data import Observations
from ..inference import FitPosterior, refit
from ..model import BALL, BASE, PLACES, Difference
from .candidates import (
    RUNS,
    Rises,
    contradict,
    courses_of,
    steps_between,
    steps_of,
    steps_of_base,
)

INDEPENDENT = 0.5
"""Share of the evidence that counts but of steps of a base: poses in a row are alike, and so are
their errors, which look like a drift, or like a joint or a ball that differs."""
KEPT = 3.0
"""Rise of the logarithm of the evidence from which a difference is in the model."""
CLOSELY = 3
"""How many families are looked at closely, the best of each by a fit of its own."""
LARGEST = 20.0
"""Factor of the usual size from which on a difference stands for something else."""
SECANTS = 2
"""Fits by which a zero comes to its size, since large turns are not linear."""


def with_differences(posterior: FitPosterior) -> FitPosterior:
    """Return the fit with all differences that the data support."""
    families = _families(posterior.data, posterior.model.robot.joint_names)
    present = posterior.objective.differences
    families = [family for family in families if not {*family} & {*present}]
    while families:
        best, gain = _best_of(posterior, families)
        if gain < KEPT:
            break
        new = best.objective.differences[-1]
        families = [
            [difference for difference in family if not contradict(difference, new)]
            for family in families
            if new not in family
        ]
        families = [*filter(None, families)]
        posterior = _without_idle(_at_its_size(best), present)
    return posterior


def _without_idle(
    posterior: FitPosterior, present: Sequence[Difference]
) -> FitPosterior:
    """Return the fit without differences, but those present, that the last one explains as well."""
    for difference in posterior.objective.differences[:-1]:
        if difference in present:
            continue
        with suppress(NotConverged):
            fewer = [d for d in posterior.objective.differences if d is not difference]
            without = refit(posterior, differences=fewer, average_widths=False)
            if posterior.log_evidence - without.log_evidence < KEPT:
                posterior = without
    return posterior


def _at_its_size(posterior: FitPosterior) -> FitPosterior:
    """Return the fit with the last difference, if it is a joint's zero, about its size."""
    *others, new = posterior.objective.differences
    if new.part in PLACES:
        return posterior
    for _ in range(SECANTS):
        zero = float(posterior.state.x[-1])
        sized = replace(new, zero=zero, values=posterior.arm.values)
        differences = (*others, sized)
        posterior = refit(posterior, differences=differences, average_widths=False)
    return posterior


def _families(data: Observations, joints: Sequence[str]) -> list[list[Difference]]:
    """Return what may differ, of which one in each family may hold."""
    placements = data.placements
    families: list[list[Difference]] = []
    for placement in placements:
        for lengths in (inf,), RUNS:
            families.append(steps_of_base(data, placement, lengths))
        families += courses_of(data, placement)
    for steps in steps_of, steps_between:
        families.append(steps(data, BALL))
        families.append([*chain(*(steps(data, joint) for joint in joints))])
    if len(placements) > 1:
        families.append([Difference("each", placements, BALL)])
    return [family for family in families if family]


def _best_of(
    posterior: FitPosterior,
    families: Sequence[Sequence[Difference]],
) -> tuple[FitPosterior, float]:
    """Return the fit with the best further difference, and the rise of the evidence by it."""
    hints: list[tuple[float, int, int]] = []
    linear = Rises(posterior)
    for number, family in enumerate(families):
        try:
            worths = _worths(_by_parts(linear, family), family)
        except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
            continue
        k = int(np.argmax(worths))
        hints.append((worths[k], number, k))
    best, gain = posterior, -np.inf
    for hint, number, k in nlargest(CLOSELY, hints):
        if hint < 0:
            break
        with suppress(NotConverged):
            differences = (*posterior.objective.differences, families[number][k])
            candidate = refit(posterior, differences=differences, average_widths=False)
            rise = candidate.log_evidence - posterior.log_evidence
            worth = _worths(rise, families[number])[k]
            width = candidate.state.groups[-1].width
            if worth > gain and width < LARGEST * differences[-1].width:
                best, gain = candidate, worth
    return best, gain


def _by_parts(linear: Rises, family: Sequence[Difference]) -> np.ndarray:
    """Return the rise of the evidence by each of a family, to first order, shape (K,)."""
    by_part = groupby(family, lambda difference: difference.part)
    return np.concatenate([linear.by([*of_part]) for _, of_part in by_part])


def _worths(rises: np.ndarray | float, family: Sequence[Difference]) -> np.ndarray:
    """Return how much of a rise of the evidence by each of a family counts, shape (K,).

    A step at one of many samples has to gain more, since it could be at any. One that needs the
    sockets in the reverse order has to gain :data:`KEPT` more than by that of their files.
    """
    first = family[0]
    moved = first.part == BASE and first.course == "step"
    share = 1.0 if moved else INDEPENDENT
    reverse = np.array([difference.clock == "reverse" for difference in family])
    in_one_order = max(reverse.sum(), len(family) - reverse.sum())
    return share * rises - log(in_one_order) - KEPT * reverse

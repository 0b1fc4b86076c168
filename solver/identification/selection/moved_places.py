"""The choice of how places moved while they were recorded, by the evidence of the whole fit."""

from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from heapq import nlargest
from itertools import chain
from math import log

import numpy as np

from ....errors import NotConverged, fixed
from ..inference import FitPosterior, movement_gain, refit
from ..model import FoundMovement, Movement, movements_of

INDEPENDENT = 0.5
"""Share of the evidence of slow courses that counts: poses in a row are alike, and their errors."""
REPORTED, KEPT = 0.0, 3.0
"""Rise of the logarithm of the evidence from which a movement is reported, and is modelled."""
HINT, CLOSELY = -2.0, 3
"""Rise by a linear model from which one is looked at closely, and how many of a round."""
WORDS = {
    "step": "its place moved at a change of socket",
    "drift": "its place drifted steadily",
    "slow": "its place drifted to and fro",
}


def movements_by_evidence(
    posterior: FitPosterior,
) -> tuple[tuple[Movement, ...], tuple[FoundMovement, ...]]:
    """Return the movements to put into the model beside its own, and all that are reported."""
    data = posterior.data
    candidates = {place: movements_of(data, place) for place in data.placements}
    lines: list[FoundMovement] = []
    while candidates:
        movements = [*chain(*candidates.values())]
        best, gain = _best_of(posterior, movements)
        if best is posterior:
            break
        new = best.objective.movements[-1]
        if new.kind != "step":
            gain *= INDEPENDENT
        if gain < REPORTED:
            break
        del candidates[new.placement]
        lines.append(_line(best, gain))
        if gain >= KEPT:
            posterior = best
    return tuple(posterior.objective.movements), tuple(lines)


def _best_of(
    posterior: FitPosterior,
    movements: Sequence[Movement],
) -> tuple[FitPosterior, float]:
    """Return the fit with the best further movement, or the same, and the evidence's rise by it.

    A step at one of many changes has to gain more, since it could be at any.
    """
    kinds = [(movement.placement, movement.kind) for movement in movements]
    counts = Counter(kinds)
    prices = [log(counts[kind]) for kind in kinds]
    hints: list[tuple[float, int]] = []
    for i, movement in enumerate(movements):
        hints.append((_rise(posterior, movement) - prices[i], i))
    best, gain = posterior, -np.inf
    for hint, i in nlargest(CLOSELY, hints):
        if hint < HINT:
            break
        with suppress(NotConverged):
            extended = (*posterior.objective.movements, movements[i])
            candidate = refit(posterior, movements=extended, average_widths=False)
            rise = candidate.log_evidence - posterior.log_evidence - prices[i]
            if rise > gain:
                best, gain = candidate, rise
    return best, gain


def _rise(posterior: FitPosterior, movement: Movement) -> float:
    """Return the rise of the logarithm of the evidence by a movement, by a linear model."""
    try:
        return movement_gain(posterior, movement)
    except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
        return -np.inf


def _line(posterior: FitPosterior, gain: float) -> FoundMovement:
    """Return the report on the last movement of a result."""
    movement, data = posterior.objective.movements[-1], posterior.data
    unknowns = posterior.state.x[-movement.size :]
    course = movement.course(data) @ unknowns.reshape(-1, 3)
    size = 1e3 * float(np.linalg.norm(np.ptp(course, axis=0)))
    follows = "" if movement.clock == "time" else f", with {movement.clock}"
    rank = None
    if movement.kind == "step":
        times = data.clock("time")[data.rows_of(movement.placement)]
        rank = int(np.sum(times < movement.at))
        follows = ", before its {first}"
    kept = gain >= KEPT
    use = "; the fit takes it into account"
    if not kept:
        use = ", too unsure to be taken into account"
    cause = f"{WORDS[movement.kind]} by {size:.2f} mm{follows}"
    text = f"{cause} (log evidence {fixed(gain, 1, '+')}){use}"
    return FoundMovement(movement.placement, text, kept, rank)

"""The choice of how places moved while they were recorded, by the evidence of the whole fit."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import log

import numpy as np

from ...paper import NotConverged
from ..inference import JointPosterior, movement_gain, refit
from ..model import Movement, movements_of

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


@dataclass(frozen=True)
class FoundMovement:
    """A movement that the data support."""

    placement: str
    text: str
    kept: bool
    """True where it is in the model."""
    rank: int | None = None
    """Of a step, the number of samples that were recorded before."""


def movements_by_evidence(
    found: JointPosterior,
) -> tuple[tuple[Movement, ...], tuple[FoundMovement, ...]]:
    """Return the movements to put into the model, and all that are to be reported."""
    if len(found.arms) > 1:
        return (), ()
    left, chosen, lines = list(found.scene.placements), list[Movement](), list[FoundMovement]()
    data = found.scene.arms[0]
    candidates = {place: movements_of(data, place) for place in left}
    while left:
        tried = [one for place in left for one in candidates[place]]
        rises = [_rise(found, one) - _price(one, tried) for one in tried]
        ranked = sorted((rise, i) for i, rise in enumerate(rises))
        best, gain = found, -np.inf
        for rough, i in ranked[: -CLOSELY - 1 : -1]:
            if rough < HINT:
                break
            with suppress(NotConverged):
                with_it = refit(found, movements=(*chosen, tried[i]))
                rise = with_it.log_evidence - found.log_evidence - _price(tried[i], tried)
                best, gain = (with_it, rise) if rise > gain else (best, gain)
        if best is found:
            break
        new = best.objective.movements[-1]
        gain = gain if new.kind == "step" else INDEPENDENT * gain
        if gain < REPORTED:
            break
        left.remove(new.placement)
        lines.append(_line(best, gain))
        if gain >= KEPT:
            found = best
            chosen.append(new)
    return tuple(chosen), tuple(lines)


def _rise(found: JointPosterior, one: Movement) -> float:
    """Return the rise of the logarithm of the evidence by a movement, by a linear model."""
    try:
        return movement_gain(found, one)
    except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
        return -np.inf


def _price(one: Movement, tried: Sequence[Movement]) -> float:
    """Return what a step at one of many changes needs to gain, since it could be at any."""
    return log(sum((m.placement, m.kind) == (one.placement, one.kind) for m in tried))


def _line(found: JointPosterior, gain: float) -> FoundMovement:
    """Return the report on the last movement of a result."""
    movement, data = found.objective.movements[-1], found.scene.arms[0]
    course = movement.course(data) @ found.state.x[-movement.size :].reshape(-1, 3)
    size = 1e3 * float(np.linalg.norm(np.ptp(course, axis=0)))
    follows = "" if movement.clock == "time" else f", with {movement.clock}"
    rank = None
    if movement.kind == "step":
        rank = int(np.sum(data.time[data.rows_of(movement.placement)] < movement.at))
        follows = ", before its {first}"
    kept = gain >= KEPT
    share = "; the fit takes it into account" if kept else ", too unsure to be taken into account"
    return FoundMovement(
        movement.placement,
        f"{WORDS[movement.kind]} by {size:.2f} mm{follows} (log evidence {gain:+.1f}){share}",
        kept,
        rank,
    )

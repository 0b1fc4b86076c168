"""Columns that are not the model's joints: which signs, orders and offsets are worth a fit.

A hypothesis on columns is far from linear. The model as it is, but for its ball, sorts them; fits
to the best of each kind then have their evidence compared with all other explanations.
"""

from collections.abc import Iterable

import numpy as np

from .column_hypotheses import (
    ColumnHypothesis,
    several_offsets,
    signs,
    swaps,
    unchanged,
    with_best_offsets,
)
from .robust_fit import RigidModel, Samples

TOLERANCE = 0.02
"""A right model is off by less than this on average, once the ball's place is fitted [m]."""
TRIED = 90
"""Samples used to try a hypothesis."""
MOST_SIGNS = 8
"""Arms with more joints than this: their signs are tried one at a time only."""
PROMISING = 0.8
"""Share of the error as it is that a hypothesis worth a fit leaves at most."""
OFFSETS = np.deg2rad(np.arange(-165, 181, 30))

Scored = tuple[float, ColumnHypothesis]
"""A hypothesis, and the error that the model as it is has with it [m]."""


def promising(model: RigidModel, samples: Samples) -> list[ColumnHypothesis]:
    """Return the best hypotheses of each kind, if they leave clearly less than what is there."""
    few = samples.thinned(max(TRIED // samples.count, 4))
    robot, right = model.robot, unchanged(model.robot)
    joints = len(robot.actuated)
    now = model.nominal_error(few)

    def best(hypotheses: Iterable[ColumnHypothesis], count: int = 1) -> list[Scored]:
        scored = [(model.nominal_error(h.apply(few)), h) for h in hypotheses]
        return sorted(scored, key=lambda one: one[0])[:count]

    found = [*best(signs(robot, 1), 2), *best(swaps(robot), 2), *best(_orders(right))]
    # A turn of the first or the last joint is one of the base frame or of the ball.
    turning = [j for j in range(1, joints - 1) if robot.actuated[j].type != "prismatic"]
    if not model.zeros:
        starts = [best(right.with_offset(j, o) for o in OFFSETS.tolist())[0][1] for j in turning]
        single = best(
            (with_best_offsets(model, few, s, np.flatnonzero(s.offsets).tolist()) for s in starts),
            2,
        )
        found += single
        starts = [right, *signs(robot, 1), *swaps(robot), *(one for _, one in single)]
        if min(found, key=lambda one: one[0])[0] > TOLERANCE / 2 and few.is_overdetermined(
            3 + len(turning)
        ):
            several = several_offsets(model, few, starts, turning)
            found += best([several] if several is not None else [])
    for count in range(2, joints if joints <= MOST_SIGNS else 0):
        if min(found, key=lambda one: one[0])[0] > TOLERANCE:
            found += best(signs(robot, count))
    found.sort(key=lambda one: one[0])
    return [h for error, h in found if error < PROMISING * now][:4]


def _orders(right: ColumnHypothesis) -> Iterable[ColumnHypothesis]:
    """Return the hypotheses that all columns come in another order: turned round, or shifted."""
    m = len(right.order)
    for order in [right.order[::-1], *(np.roll(right.order, k) for k in range(1, m))]:
        yield ColumnHypothesis(right.robot, order, right.signs, right.offsets)

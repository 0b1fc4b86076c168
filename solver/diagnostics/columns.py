"""Check of the columns: signs, swaps and offsets by which the model would fit much better.

A wrong hypothesis about a wrist that turns near the ball costs little, so fits decide, not the
model as it is.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from ..data import Measurement
from .column_hypotheses import (
    USUAL_OFFSET,
    ColumnHypothesis,
    several_offsets,
    signs,
    swaps,
    unchanged,
)
from .diagnostic import Diagnostic, where_of
from .robust_fit import UNEXPLAINED, RigidFit, RigidModel, Samples, samples_of

TOLERANCE = 0.02
"""A right model is off by less than this on average, once the ball's place is fitted [m]."""
FAR_OFF = 1e-2
"""Several offsets are sought where the best simpler hypothesis leaves more than this [m]."""
ODDS, BETTER = 30.0, 0.9
"""A sign is wrong if the opposite one makes the samples at least e^30 times as likely, and the
noise at most 0.9 times as large."""
MUCH = 0.5
"""A right hypothesis reduces the nominal model's error to this share of it, or less."""
CLEARLY = 0.4
"""A less simple hypothesis is preferred if it leaves this share of a simpler one's error."""
TRIED, FITTED = 90, 400
"""Samples used to try a hypothesis, and to fit the arm with it."""
MOST_SIGNS = 8
"""Arms with more joints than this: their signs are tried one at a time only."""
OFFSETS, SMALL = np.deg2rad(np.arange(-180, 180, 15)), np.deg2rad(31)
FINEST = np.deg2rad(0.2)
"""Offsets that are tried, which of them are likelier, and how finely the best one is searched."""

Scored = tuple[float, ColumnHypothesis]
"""A hypothesis, and the error that the model as it is has with it [m]."""


def column_diagnostics(
    model: RigidModel, measurements: Sequence[Measurement], samples: Samples | None = None
) -> list[Diagnostic]:
    """Return the sign, swap or offset of columns that would explain placements better.

    Args:
        model: The arm.
        measurements: Placements that share the mistake, if there is one.
        samples: Theirs, where some that lie elsewhere stand apart; None for all as recorded.
    """
    samples = samples or samples_of(measurements)
    few = samples.thinned(max(FITTED // samples.count, 4))
    fewest = samples.thinned(max(TRIED // samples.count, 4))
    fit, nominal = model.fit(few), model.nominal_error(fewest)
    where = where_of(measurements)
    if nominal < TOLERANCE and fit.error < UNEXPLAINED:
        return _weak_signs(model, few, fit, where)
    best = _best(model, fewest)
    fixed, remaining = model.fit(best.apply(few)), model.nominal_error(best.apply(fewest))
    if fixed.error < min(UNEXPLAINED, 0.5 * fit.error):
        return [_diagnostic(best, where, fit.error, fixed.error)]
    if remaining < MUCH * nominal and fixed.error < UNEXPLAINED:
        # The geometry bends as far, but no arm does: what the model says counts.
        return [_diagnostic(best, where, nominal, remaining)]
    text = (
        f"the model is {1e3 * nominal:.0f} mm off with the best place of the ball, and "
        f"{1e3 * fit.error:.1f} mm when fitted; no sign, swap or zero of its joints explains it"
    )
    advice = "is it this robot's model, with the right --base and --tip, and the joints in order?"
    level = "error" if fit.error > UNEXPLAINED else "warning"
    return [Diagnostic(level, "model", where, text, advice)]


def column_behind_scale(
    model: RigidModel, measurements: Sequence[Measurement]
) -> tuple[Diagnostic, RigidFit] | None:
    """Return the column that may be behind a wrong size of the arm, and a fit without it.

    A wrong distance between the sockets changes nothing but the size. A wrong column changes what
    the model says of the samples as well, so it is one if without it the model as it is fits much
    better.
    """
    samples = samples_of(measurements)
    fewest = samples.thinned(max(TRIED // samples.count, 4))
    best = _best(model, fewest)
    before, after = model.nominal_error(fewest), model.nominal_error(best.apply(fewest))
    if after > MUCH * before or 0 < abs(best.offsets).max() < USUAL_OFFSET:
        return None
    found = _diagnostic(best, where_of(measurements), before, after)
    return found, model.fit(best.apply(samples))


def _diagnostic(found: ColumnHypothesis, where: str, before: float, after: float) -> Diagnostic:
    text = f"{found.text} the error falls from {_mm(before)} to {_mm(after)} mm"
    return Diagnostic("error", found.code, where, text, found.advice)


def _mm(error: float) -> str:
    return f"{1e3 * error:.0f}" if error > 0.01 else f"{1e3 * error:.2g}"


def _weak_signs(model: RigidModel, samples: Samples, fit: RigidFit, where: str) -> list[Diagnostic]:
    """Return a joint near whose axis the ball is, if the samples fit better with its other sign."""
    if not samples.is_overdetermined(len(fit.x)):
        return []
    least = fit.noise * min(BETTER, np.exp(-ODDS / (3 * len(samples.sockets))))
    found: list[Diagnostic] = []
    for hypothesis in signs(model.robot, 1):
        other = hypothesis.apply(samples)
        if model.nominal_error(other) > TOLERANCE:
            continue
        flipped = model.fit(other)
        if flipped.noise < least:
            least = flipped.noise
            found = [_diagnostic(hypothesis, where, fit.error, flipped.error)]
    return found


def _best(model: RigidModel, samples: Samples) -> ColumnHypothesis:
    """Return the hypothesis by which the nominal model, but for its ball, explains samples best.

    One mistake first, a sign before a swap before an offset where they explain as much; then, if
    none does, signs of several joints, then offsets of some with a sign or a swap at most.
    """
    robot = model.robot
    joints = len(robot.actuated)

    def score(hypothesis: ColumnHypothesis) -> Scored:
        return model.nominal_error(hypothesis.apply(samples)), hypothesis

    # A turn of the first or the last joint is one of the base frame or of the ball.
    turning = [j for j in range(1, joints - 1) if robot.actuated[j].type != "prismatic"]
    right = unchanged(robot)
    offsets = [_best_offset(right, j, score) for j in turning]
    best = _least(map(score, signs(robot, 1)))
    best = _clearly(best, _least(map(score, swaps(robot))))
    best = _clearly(best, _least(offsets)) if offsets else best
    for count in range(2, joints if joints <= MOST_SIGNS else 0):
        if best[0] > TOLERANCE:
            best = _clearly(best, _least(map(score, signs(robot, count))))
    if best[0] > FAR_OFF and not model.zeros and samples.is_overdetermined(3 + len(turning)):
        starts = [right, *signs(robot, 1), *swaps(robot), *(found for _, found in offsets)]
        several = several_offsets(model, samples, starts, turning)
        if several is not None and score(several)[0] < TOLERANCE:
            best = _clearly(best, score(several))
    return best[1]


def _least(scored: Iterable[Scored]) -> Scored:
    return min(scored, key=lambda one: one[0])


def _clearly(simpler: Scored, other: Scored) -> Scored:
    """Return the simpler hypothesis, unless the other is clearly better."""
    return other if other[0] < CLEARLY * simpler[0] else simpler


def _best_offset(
    right: ColumnHypothesis, joint: int, score: Callable[[ColumnHypothesis], Scored]
) -> Scored:
    """Return the best offset of a joint: a small one, unless a large one is clearly better.

    Near a wrist, one that is half a turn off may look almost right.
    """
    tried = [score(right.with_offset(joint, offset)) for offset in OFFSETS.tolist()]
    small = _least(one for one in tried if abs(one[1].offsets[joint]) < SMALL)
    any_size = _least(tried)
    found = _refined(joint, small, score)
    if any_size is small:
        return found
    return _clearly(found, _refined(joint, any_size, score))


def _refined(joint: int, best: Scored, score: Callable[[ColumnHypothesis], Scored]) -> Scored:
    """Return the best offset near that of a hypothesis, searched by halves."""
    step = float(OFFSETS[1] - OFFSETS[0]) / 2
    while step > FINEST:
        middle = float(best[1].offsets[joint])
        beside = [best[1].with_offset(joint, middle + side) for side in (-step, step)]
        best = _least([best, *map(score, beside)])
        step /= 2
    return best

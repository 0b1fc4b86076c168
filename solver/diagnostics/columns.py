"""Columns of a recording that do not mean what the model's joints mean: signs, swaps, zeros.

Each guess changes the joint positions, and is judged by how much better the model then fits. A
wrong guess about a wrist that turns near the ball costs little, so fits decide, not the model as
it is.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from ..data import Measurement
from ..robot import Robot
from .column_hypotheses import ColumnHypothesis, signs, swaps, unchanged, with_zero
from .diagnostic import Diagnostic, where_of
from .offsets import USUAL, several
from .robust_fit import RigidFit, RigidModel, Samples, samples_of

TOLERANCE = 0.02
"""A right model is off by less than this on average, once the ball's place is fitted [m]."""
UNEXPLAINED = 5e-3
"""A fit to sound recordings leaves less than this [m]."""
FAR_OFF = 1e-2
"""Zeros of several joints are sought where the best simpler guess leaves more than this [m]."""
ODDS, BETTER = 30.0, 0.9
"""A sign is wrong if the opposite one makes the samples at least e^30 times as likely, and the
noise at most 0.9 times as large."""
MUCH = 0.5
"""A right guess reduces the nominal model's error to this share of it, or less."""
CLEARLY = 0.4
"""A less simple guess is preferred if it leaves this share of a simpler one's error, or less."""
GLANCE, LOOK = 90, 400
"""How many samples are used to try a guess, and how many to fit the arm with it."""
MOST_SIGNS = 8
"""Arms with more joints than this: their signs are tried one at a time only."""
ZEROS, SMALL = np.deg2rad(np.arange(-180, 180, 15)), np.deg2rad(31)
FINEST = np.deg2rad(0.2)
"""Zeros that are tried, which of them are likelier, and how finely the best one is searched."""

Judged = tuple[float, ColumnHypothesis]
"""A guess, and the error that the model as it is has with it [m]."""


def column_findings(
    model: RigidModel, measurements: Sequence[Measurement], samples: Samples | None = None
) -> list[Diagnostic]:
    """Return which sign, swap or zero of the columns would explain placements better.

    Args:
        model: The arm.
        measurements: Placements that share the mistake, if there is one.
        samples: Theirs, where some that lie elsewhere stand apart; None for all as recorded.
    """
    samples = samples or samples_of(measurements)
    few = samples.thinned(max(LOOK // samples.count, 4))
    glance = samples.thinned(max(GLANCE // samples.count, 4))
    fit, nominal = model.fit(few), model.nominal_error(glance)
    where = where_of(measurements)
    if nominal < TOLERANCE and fit.error < UNEXPLAINED:
        return _weak_signs(model, few, fit, where)
    guess = _best(model, glance)
    fixed, remaining = model.fit(guess.of(few)), model.nominal_error(guess.of(glance))
    if fixed.error < min(UNEXPLAINED, 0.5 * fit.error):
        return [_finding(guess, where, fit.error, fixed.error)]
    if remaining < MUCH * nominal and fixed.error < UNEXPLAINED:
        # The geometry bends as far, but no arm does: what the model says counts.
        return [_finding(guess, where, nominal, remaining)]
    text = (
        f"the model is {1e3 * nominal:.0f} mm off with the best place of the ball, and "
        f"{1e3 * fit.error:.1f} mm when fitted; no sign, swap or zero of its joints explains it"
    )
    advice = "is it this robot's model, with the right --base and --tip, and the joints in order?"
    level = "error" if fit.error > UNEXPLAINED else "warning"
    return [Diagnostic(level, "model", where, text, advice)]


def columns_behind(
    model: RigidModel, measurements: Sequence[Measurement]
) -> tuple[Diagnostic, RigidFit] | None:
    """Return which sign, swap or zero may be behind a wrong size of the arm, and a fit without it.

    A wrong distance between the sockets changes nothing but the size. A wrong column changes what
    the model says of the samples as well, so it is one if without it the model as it is fits much
    better.

    Args:
        model: The arm.
        measurements: Placements by which its size is wrong.
    """
    samples = samples_of(measurements)
    glance = samples.thinned(max(GLANCE // samples.count, 4))
    guess = _best(model, glance)
    before, after = model.nominal_error(glance), model.nominal_error(guess.of(glance))
    if after > MUCH * before or 0 < abs(guess.zeros).max() < USUAL:
        return None
    return _finding(guess, where_of(measurements), before, after), model.fit(guess.of(samples))


def _finding(guess: ColumnHypothesis, where: str, before: float, after: float) -> Diagnostic:
    text = f"{guess.text} the error falls from {_mm(before)} to {_mm(after)} mm"
    return Diagnostic("error", guess.code, where, text, guess.advice)


def _mm(error: float) -> str:
    return f"{1e3 * error:.0f}" if error > 0.01 else f"{1e3 * error:.2g}"


def _weak_signs(model: RigidModel, samples: Samples, fit: RigidFit, where: str) -> list[Diagnostic]:
    """Return a joint near whose axis the ball is, if the samples fit better with its other sign."""
    if not samples.tell(len(fit.x)):
        return []
    least = fit.noise * min(BETTER, np.exp(-ODDS / (3 * len(samples.sockets))))
    findings: list[Diagnostic] = []
    for guess in signs(model.robot, 1):
        other = guess.of(samples)
        if model.nominal_error(other) > TOLERANCE:
            continue
        flipped = model.fit(other)
        if flipped.noise < least:
            least = flipped.noise
            findings = [_finding(guess, where, fit.error, flipped.error)]
    return findings


def _best(model: RigidModel, samples: Samples) -> ColumnHypothesis:
    """Return the guess by which the model explains samples best, with nothing but its ball free.

    One mistake first, a sign before a swap before a zero where they explain as much; then, if none
    does, signs of several joints, then zeros of some with a sign or a swap at most.
    """
    robot = model.robot
    joints = len(robot.actuated)

    def judged(guess: ColumnHypothesis) -> Judged:
        return model.nominal_error(guess.of(samples)), guess

    # A turn of the first or the last joint is one of the base frame or of the ball.
    turning = [j for j in range(1, joints - 1) if robot.actuated[j].type != "prismatic"]
    zeros = [_best_zero(robot, j, judged) for j in turning]
    best = _least(map(judged, signs(robot, 1)))
    best = _clearly(best, _least(map(judged, swaps(robot))))
    best = _clearly(best, _least(zeros)) if zeros else best
    for count in range(2, joints if joints <= MOST_SIGNS else 0):
        if best[0] > TOLERANCE:
            best = _clearly(best, _least(map(judged, signs(robot, count))))
    if best[0] > FAR_OFF and not model.zeros and samples.tell(3 + len(turning)):
        far = [guess for _, guess in zeros]
        starts = [unchanged(robot), *signs(robot, 1), *swaps(robot), *far]
        found = several(model, samples, starts, turning)
        if found is not None and judged(found)[0] < TOLERANCE:
            best = _clearly(best, judged(found))
    return best[1]


def _least(guesses: Iterable[Judged]) -> Judged:
    return min(guesses, key=lambda judged: judged[0])


def _clearly(simpler: Judged, other: Judged) -> Judged:
    """Return the simpler guess, unless the other is clearly better."""
    return other if other[0] < CLEARLY * simpler[0] else simpler


def _best_zero(robot: Robot, joint: int, judged: Callable[[ColumnHypothesis], Judged]) -> Judged:
    """Return the best guess of a joint's zero: a small one, unless a large one is clearly better.

    Near a wrist, one that is half a turn off may look almost right.
    """
    right = unchanged(robot)
    tried = [judged(with_zero(right, joint, zero)) for zero in ZEROS.tolist()]
    small = _least(one for one in tried if abs(one[1].zeros[joint]) < SMALL)
    any_size = _least(tried)
    found = _searched(joint, small, judged)
    if any_size is small:
        return found
    return _clearly(found, _searched(joint, any_size, judged))


def _searched(joint: int, best: Judged, judged: Callable[[ColumnHypothesis], Judged]) -> Judged:
    """Return the best zero near that of a guess, searched by halves."""
    step = float(ZEROS[1] - ZEROS[0]) / 2
    while step > FINEST:
        guess = best[1]
        beside = (float(guess.zeros[joint]) + side for side in (-step, step))
        best = _least([best, *(judged(with_zero(guess, joint, zero)) for zero in beside)])
        step /= 2
    return best

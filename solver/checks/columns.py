"""Columns of a recording that do not mean what the model's joints mean: signs, swaps, zeros.

Each guess changes the joint positions, and is judged by how much better the model then fits. A
wrong guess about a wrist that turns near the ball costs little, so fits decide, not the model as
it is.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..data.measurements import Measurement
from ..robot.urdf import Robot
from .finding import Finding, where_of
from .rigid import RigidFit, RigidModel, Samples, samples_of

__all__ = ["UNEXPLAINED", "column_findings", "columns_behind"]

TOLERANCE = 0.02
"""A right model is off by less than this on average, once the ball's place is fitted [m]."""
UNEXPLAINED = 5e-3
"""A fit to sound recordings leaves less than this [m]."""
ODDS, BETTER = 30.0, 0.9
"""A sign is wrong if the opposite one makes the samples at least e^30 times as likely, and the
noise at most 0.9 times as large."""
USUAL = np.deg2rad(1.5)
"""Joints' zeros may be off by less than this."""
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


@dataclass(frozen=True)
class _Guess:
    """What the columns may be instead: q[order] * signs - zeros."""

    code: str
    text: str
    advice: str
    order: np.ndarray
    signs: np.ndarray
    zeros: np.ndarray

    def of(self, samples: Samples) -> Samples:
        """Return samples as they would be."""
        q = samples.positions[:, self.order] * self.signs - self.zeros
        return Samples(q, samples.sockets)


def column_findings(model: RigidModel, measurements: Sequence[Measurement]) -> list[Finding]:
    """Return which sign, swap or zero of the columns would explain placements better.

    Args:
        model: The arm.
        measurements: Placements that share the mistake, if there is one.
    """
    samples = samples_of(measurements)
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
    return [Finding(level, "model", where, text, advice)]


def columns_behind(
    model: RigidModel, measurements: Sequence[Measurement]
) -> tuple[Finding, RigidFit] | None:
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


def _finding(guess: _Guess, where: str, before: float, after: float) -> Finding:
    text = f"{guess.text} the error falls from {_mm(before)} to {_mm(after)} mm"
    return Finding("error", guess.code, where, text, guess.advice)


def _mm(error: float) -> str:
    return f"{1e3 * error:.0f}" if error > 0.01 else f"{1e3 * error:.2g}"


def _weak_signs(model: RigidModel, samples: Samples, fit: RigidFit, where: str) -> list[Finding]:
    """Return a joint near whose axis the ball is, if the samples fit better with its other sign."""
    least = fit.noise * min(BETTER, np.exp(-ODDS / (3 * len(samples.sockets))))
    findings: list[Finding] = []
    for guess in _signs(model.robot, 1):
        other = guess.of(samples)
        if model.nominal_error(other) > TOLERANCE:
            continue
        flipped = model.fit(other)
        if flipped.noise < least:
            least = flipped.noise
            findings = [_finding(guess, where, fit.error, flipped.error)]
    return findings


def _best(model: RigidModel, samples: Samples) -> _Guess:
    """Return the guess by which the model explains samples best, with nothing but its ball free.

    One joint's mistake first, a sign before a swap before a zero where they explain as much; then,
    if none does, signs of several.
    """
    robot = model.robot
    joints = len(robot.actuated)

    def error(guess: _Guess) -> float:
        return model.nominal_error(guess.of(samples))

    # A turn of the first or the last joint is one of the base frame or of the ball.
    turning = [j for j in range(1, joints - 1) if robot.actuated[j].type != "prismatic"]
    kinds = [_signs(robot, 1), _swaps(robot), [_best_zero(robot, j, error) for j in turning]]
    best, least = None, np.inf
    for guesses in kinds:
        guess = min(guesses, key=error)
        if error(guess) < CLEARLY * least:
            best, least = guess, error(guess)
    for count in range(2, joints if joints <= MOST_SIGNS else 0):
        if least > TOLERANCE:
            guess = min(_signs(robot, count), key=error)
            if error(guess) < CLEARLY * least:
                best, least = guess, error(guess)
    assert best is not None
    return best


def _best_zero(robot: Robot, joint: int, error: Callable[[_Guess], float]) -> _Guess:
    """Return the best guess of a joint's zero: a small one, unless a large one is clearly better.

    Near a wrist, one that is half a turn off may look almost right.
    """
    small = _searched(robot, joint, ZEROS[abs(ZEROS) < SMALL], error)
    large = _searched(robot, joint, ZEROS, error)
    return large if error(large) < CLEARLY * error(small) else small


def _searched(
    robot: Robot, joint: int, zeros: np.ndarray, error: Callable[[_Guess], float]
) -> _Guess:
    """Return the best of some zeros, searched by halves there."""
    guess = min((_zero(robot, joint, zero) for zero in zeros.tolist()), key=error)
    step = float(ZEROS[1] - ZEROS[0]) / 2
    while step > FINEST:
        zero = float(guess.zeros[joint])
        guess = min((_zero(robot, joint, z) for z in (zero, zero - step, zero + step)), key=error)
        step /= 2
    return guess


def _signs(robot: Robot, count: int) -> Iterator[_Guess]:
    m = len(robot.actuated)
    for joints in combinations(range(m), count):
        signs = np.ones(m)
        signs[list(joints)] = -1
        yield _Guess(
            "sign",
            f"{_names(robot, joints)} sign-flipped: with -q",
            "change the sign in the recording, or of the axis in the model",
            np.arange(m),
            signs,
            np.zeros(m),
        )


def _swaps(robot: Robot) -> Iterator[_Guess]:
    m = len(robot.actuated)
    for i, j in combinations(range(m), 2):
        order = np.arange(m)
        order[[i, j]] = j, i
        yield _Guess(
            "swap",
            f"{_names(robot, (i, j))} swapped: with their columns exchanged",
            "bring the columns into the order of the model's chain",
            order,
            np.ones(m),
            np.zeros(m),
        )


def _zero(robot: Robot, joint: int, zero: float) -> _Guess:
    m = len(robot.actuated)
    zeros = np.zeros(m)
    zeros[joint] = zero
    return _Guess(
        "zero",
        f"{_names(robot, (joint,))} off by {np.rad2deg(zero):+.1f} deg: with that taken off",
        "set the joint's zero, or choose the model of this robot's version",
        np.arange(m),
        np.ones(m),
        zeros,
    )


def _names(robot: Robot, joints: Sequence[int]) -> str:
    numbers = " and ".join(str(joint + 1) for joint in joints)
    names = ", ".join(robot.joint_names[joint] for joint in joints)
    many = len(joints) > 1
    return f"joint{'s' * many} {numbers} ({names}) look{'s' * (not many)}"

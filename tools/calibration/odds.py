"""Whether a calibration still holds, by a few poses in one socket, and how sure that is.

Three kinds of explanation compete for the errors e of the new samples, each less the mean of its
socket:

* nothing changed: e is as large as when the calibration was made, times a factor near 1;
* joint j has shifted by an offset d (a knock, a new mastering): e = a_j d + the same, with a_j the
  derivative of the balls by the joint;
* something else changed: e is several times as large, in no such pattern.

Each has a probability of the data, averaged over its unknown factor and offset (its evidence), and
so by Bayes' rule a probability after them. The errors of a calibrated arm are alike in poses that
are alike, so only a share of them counts as independent.
"""

import math
from dataclasses import dataclass

import numpy as np

from ...solver.calibrated import CalibratedRobot
from ...solver.data.measurements import Measurement
from ...solver.data.metrics import socket_centres

__all__ = ["Odds", "odds_of"]

MEAN_OF_SIGMA = 2 * math.sqrt(2 / math.pi)
"""Mean length of an error whose axes each have the standard deviation 1."""
USUAL, CHANGED = (math.log(1.3), 0.5), (math.log(6.0), 0.7)
"""Logarithm of the factor on the errors, mean and standard deviation: nothing, or all, changed."""
OFFSET = math.radians(0.5)
"""Standard deviation of a joint's offset, if it has shifted [rad], [m]."""
PRIOR = {"unchanged": 0.5, "joint": 0.25, "else": 0.25}
"""What is believed beforehand."""
INDEPENDENT = 0.5
"""Share of the errors that count as independent."""
MATTERS = 2.0
"""Errors below so many times those at the calibration itself are no drift that matters; nor are
those below the limit for such an arm."""
STEP = 1e-5
"""Of the derivative by a joint position [rad], [m]."""


@dataclass(frozen=True)
class Odds:
    """What the new samples say of an old calibration."""

    error: float
    """Mean absolute error of the new samples [m]."""
    before: float
    """The same when the calibration was made [m]."""
    limit: float
    """What is allowed for such an arm [m]."""
    unchanged: float
    """Probability that nothing changed."""
    joint: str | None
    """The likeliest joint to have shifted; None where another cause is likelier."""
    offset: float
    """By how much it did [rad], [m]."""

    @property
    def valid(self) -> bool:
        """Whether the calibration still holds."""
        return self.unchanged >= 0.5 or self.error <= max(self.limit, MATTERS * self.before)

    @property
    def text(self) -> str:
        """The verdict in words."""
        found = f"{_mm(self.error)} mm now, {_mm(self.before)} mm when it was made"
        if self.valid and self.unchanged >= 0.5:
            wrong = _percent(1 - self.unchanged)
            return f"Still valid: {found}; probability that this is wrong: {wrong}."
        if self.valid:
            return (
                f"Still valid: {found}; something may have changed, with a probability of "
                f"{_percent(1 - self.unchanged)}, but by too little to matter."
            )
        cause = "no single joint explains it"
        if self.joint is not None:
            cause = f"likeliest cause: {self.joint}, off by {math.degrees(self.offset):+.2f} deg"
        return (
            f"Drifted: {found}; {cause}. Probability that nothing changed: "
            f"{_percent(self.unchanged)}. Calibrate again."
        )


def odds_of(
    calibrated: CalibratedRobot, measured: Measurement, before: float, limit: float = 0.0
) -> Odds:
    """Return what new samples say of a calibration.

    Args:
        calibrated: Its robot.
        measured: The new samples.
        before: Its mean absolute error when it was made, held out if it was [m].
        limit: What is allowed for such an arm [m].
    """
    errors = _errors(calibrated, measured, 0.0, 0)
    count = INDEPENDENT * 3 * (len(errors) - len(measured.sockets))
    share = count / errors.size
    sigma = before / MEAN_OF_SIGMA
    square = share * float(np.sum(errors**2))
    joints = calibrated.robot.joint_names
    slopes = [(_errors(calibrated, measured, STEP, j) - errors) / STEP for j in range(len(joints))]
    along = [share * float(np.sum(a * errors)) for a in slopes]
    steep = [share * float(np.sum(a * a)) for a in slopes]
    logs = [math.log(PRIOR["unchanged"]) + _evidence(square, count, sigma, USUAL)]
    logs.append(math.log(PRIOR["else"]) + _evidence(square, count, sigma, CHANGED))
    for a, s in zip(along, steep, strict=True):
        log = _evidence(square, count, sigma, USUAL, a, s)
        logs.append(math.log(PRIOR["joint"] / len(joints)) + log)
    odds = np.exp(np.array(logs) - max(logs))
    odds = odds / odds.sum()
    best = int(np.argmax(odds[1:]))
    joint = None if best == 0 else joints[best - 1]
    offset = 0.0 if best == 0 else -along[best - 1] / max(steep[best - 1], 1e-30)
    lengths: np.ndarray = np.linalg.norm(errors, axis=1)
    mean = float(lengths.mean())
    return Odds(mean, before, limit, float(odds[0]), joint, -offset)


def _errors(
    calibrated: CalibratedRobot, measured: Measurement, step: float, joint: int
) -> np.ndarray:
    """Return each ball less its socket's mean, one joint moved by a step, shape (N, 3) [m]."""
    q = measured.positions.copy()
    q[:, joint] += step
    balls = calibrated.ball(q)
    return balls - np.repeat(socket_centres(balls, measured), measured.counts, axis=0)


def _evidence(
    square: float,
    count: float,
    sigma: float,
    factor: tuple[float, float],
    along: float = 0.0,
    steep: float = 0.0,
) -> float:
    """Return the logarithm of the probability of the errors, averaged over factor and offset.

    Args:
        square: Sum of their squares [m^2].
        count: How many independent ones there are.
        sigma: Standard deviation of one, when the calibration was made [m].
        factor: Mean and standard deviation of the logarithm of the factor on it.
        along: Their product with the derivative by a joint; 0 without an offset.
        steep: The square of that derivative.
    """
    u = np.linspace(-4, 4, 161)
    variance = (sigma * np.exp(factor[0] + factor[1] * u)) ** 2
    left = square - OFFSET**2 * along**2 / (variance + OFFSET**2 * steep)
    log = -0.5 * count * np.log(2 * np.pi * variance) - 0.5 * left / variance
    log = log - 0.5 * np.log1p(OFFSET**2 * steep / variance) - 0.5 * u**2
    top = float(log.max())
    return top + math.log(float(np.mean(np.exp(log - top))))


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f}"


def _percent(share: float) -> str:
    return "below 0.1 %" if share < 1e-3 else f"{100 * share:.1f} %"

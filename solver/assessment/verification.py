"""Validity of a calibration after a few poses in one socket, as a probability.

Several explanations compete for the errors e of the new samples, each less the mean of its socket:

* nothing changed: e is as large as when the calibration was made, times a factor near 1;
* the ball was taken off and put on again, and sits elsewhere by b: e = B b + the same, with B the
  derivative of the balls by that place. The arm is as it was, so the calibration still holds;
* joint j has shifted by an offset d (a knock, a new mastering): e = a_j d + the same, with a_j the
  derivative of the balls by the joint; with the ball where it was, or elsewhere as well;
* something else changed: e is several times as large, in no such pattern.

Each has a probability of the data, averaged over its unknown factor and offsets (its evidence), and
so by Bayes' rule a probability after them. The errors of a calibrated arm are alike in poses that
are alike, so only a share of them counts as independent. An offset of the last joint, and a ball
elsewhere on its flange, look the same.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Measurement, evaluate, mean_metrics, socket_centres, targets
from ..diagnostics import Block, LinearEvidence
from ..results import CalibratedRobot
from ..robot import BallModel
from .formatting import mm
from .limits import limit_row
from .verdict import Verdict, judge

MEAN_OF_SIGMA = 2 * math.sqrt(2 / math.pi)
"""Mean length of an error whose axes each have the standard deviation 1."""
USUAL, CHANGED = (math.log(1.3), 0.5), (math.log(6.0), 0.7)
"""Logarithm of the factor on the errors, mean and standard deviation: nothing, or all, changed."""
OFFSET = math.radians(0.5)
"""Standard deviation of a joint's offset, if it has shifted [rad], [m]."""
BALL = 1e-3
"""Standard deviation of where the ball sits, if it was put on again [m]."""
PRIOR = {"unchanged": 0.5, "joint": 0.25, "else": 0.25}
"""Prior probabilities."""
PUT_ON_AGAIN = 0.4
"""Prior probability that the ball was put on again, whatever else happened."""
INDEPENDENT = 0.5
"""Share of the errors that count as independent."""
MATTERS = 2.0
"""Errors below so many times those at the calibration itself are no drift that matters; nor are
those below the limit for such an arm."""
STEP = 1e-5
"""Of the derivative by a joint position [rad], or by the ball's place [m]."""
ROUNDS = 4
"""Gauss-Newton steps for one offset; the problem is nearly linear."""


@dataclass(frozen=True)
class ValidityPosterior:
    """Posterior probability that an old calibration is valid, after new samples."""

    error: float
    """Mean absolute error of the new samples [m]."""
    before: float
    """The same when the calibration was made [m]."""
    limit: float
    """Limit for such an arm [m]."""
    unchanged: float
    """Probability that the arm is as it was."""
    joint: str | None
    """The likeliest joint to have shifted; None where another cause is likelier."""
    offset: float
    """By how much it did [rad], [m]."""
    ball: float | None = None
    """Likely displacement of the ball [m]; None if it sits where it was."""
    last: str = ""
    """The last joint, whose offset would look like a ball elsewhere."""

    @property
    def valid(self) -> bool:
        """True if the calibration still holds."""
        return self.unchanged >= 0.5 or self.error <= max(self.limit, MATTERS * self.before)

    @property
    def verdict(self) -> Verdict:
        """The verdict on the calibration, by the one judge."""
        status = "pass" if self.valid else "fail"
        return judge([limit_row("validity", "validity", status, self.text, text=self.text[:-1])])

    @property
    def text(self) -> str:
        """The verdict in words."""
        errors = f"{mm(self.error)} now, {mm(self.before)} when it was made"
        if self.valid and self.unchanged >= 0.5:
            elsewhere = ""
            if self.ball is not None:
                elsewhere = f"; the ball sits {mm(self.ball)} from where it was (or {self.last} "
                elsewhere += "is off, which looks the same)"
            wrong = _percent(1 - self.unchanged)
            return f"Still valid: {errors}{elsewhere}; probability that this is wrong: {wrong}."
        if self.valid:
            return (
                f"Still valid: {errors}; something may have changed, with a probability of "
                f"{_percent(1 - self.unchanged)}, but by too little to matter."
            )
        cause = "no single joint explains it"
        if self.joint is not None:
            cause = f"likeliest cause: {self.joint}, off by {math.degrees(self.offset):+.2f} deg"
        return (
            f"Drifted: {errors}; {cause}. Probability that the arm is as it was: "
            f"{_percent(self.unchanged)}. Calibrate again."
        )


def odds_of(
    calibrated: CalibratedRobot, data: Sequence[Measurement], before: float, limit: float = 0.0
) -> ValidityPosterior:
    """Return what new samples say of a calibration.

    Args:
        calibrated: Its robot.
        data: The new samples.
        before: Its mean absolute error when it was made, held out if it was [m].
        limit: What is allowed for such an arm [m].
    """
    balls = _balls(calibrated, data)
    e = _errors(balls, data)
    share = INDEPENDENT * (1 - 3 * sum(len(measured.sockets) for measured in data) / e.size)
    sigma = before / MEAN_OF_SIGMA
    names = calibrated.robot.joint_names
    beside = [_errors(_balls(calibrated, data, j, STEP), data) for j in range(len(names))]
    slopes = OFFSET * (np.array(beside) - e)[:, :, None] / STEP
    joints = Block(slice(0, e.size), slopes, [{} for _ in names])
    nothing, by_ball = np.zeros((e.size, 0)), BALL * _by_ball(calibrated, balls, data)
    where, again = (LinearEvidence(e, B, share) for B in (nothing, by_ball))
    logs = np.array(
        [
            np.log(1 - PUT_ON_AGAIN) + _evidence(where, joints, sigma),
            np.log(PUT_ON_AGAIN) + _evidence(again, joints, sigma),
        ]
    )
    odds: np.ndarray = np.exp(logs - logs.max())
    odds = odds / odds.sum()
    other, shifted = np.unravel_index(int(np.argmax(odds[:, 1:])), odds[:, 1:].shape)
    offset = 0.0
    if shifted:
        one = joints.only([int(shifted) - 1])
        offset = OFFSET * float((where, again)[other].posterior(one, sigma)[0][0])
    put_on = Block(slice(0, e.size), by_ball[None], [{}])
    ball = BALL * float(np.linalg.norm(where.posterior(put_on, sigma)[0]))
    return ValidityPosterior(
        error=_mean(balls, data),
        before=before,
        limit=limit,
        unchanged=float(odds[:, 0].sum()),
        joint=names[int(shifted) - 1] if shifted else None,
        offset=offset,
        ball=ball if odds[1, 0] > odds[0, 0] else None,
        last=names[-1],
    )


def _evidence(evidence: LinearEvidence, joints: Block, sigma: float) -> np.ndarray:
    """Return prior and likelihood of nothing, all, and each joint changed, shape (2 + J,)."""
    u = np.linspace(-4, 4, 161)
    usual, changed = (sigma * np.exp(mean + width * u) for mean, width in (USUAL, CHANGED))
    at_usual = evidence.log_likelihood(usual)
    ratios = evidence.log_ratios(joints, evidence.terms(joints), usual)[:, 0, :]
    logs = np.column_stack([at_usual, evidence.log_likelihood(changed), at_usual[:, None] + ratios])
    logs = logs - 0.5 * u[:, None] ** 2
    top = logs.max(axis=0)
    count = ratios.shape[1]
    priors = [PRIOR["unchanged"], PRIOR["else"], *[PRIOR["joint"] / count] * count]
    return np.log(priors) + top + np.log(np.exp(logs - top).mean(axis=0))


@dataclass(frozen=True)
class NearestCause:
    """An offset of one joint, and the error that is left with it."""

    joint: str
    offset: float
    """To be added to what the joint reads [rad], [m] for a prismatic joint."""
    error: float
    """Mean absolute error [m]."""


def nearest_cause(
    calibrated: CalibratedRobot, data: Sequence[Measurement], before: float
) -> NearestCause | None:
    """Return the likeliest joint to have shifted; None where another cause is likelier."""
    odds = odds_of(calibrated, data, before)
    if odds.joint is None:
        return None
    j, offset = calibrated.robot.joint_names.index(odds.joint), -odds.offset
    for _ in range(ROUNDS):
        e, beside = (
            _errors(_balls(calibrated, data, j, step + offset), data) for step in (0.0, STEP)
        )
        slope = (beside - e) / STEP
        offset -= float(slope @ e) / max(float(slope @ slope), 1e-300)
    return NearestCause(odds.joint, offset, _mean(_balls(calibrated, data, j, offset), data))


def _balls(
    calibrated: CalibratedRobot, data: Sequence[Measurement], joint: int = 0, step: float = 0.0
) -> list[np.ndarray]:
    """Return the balls of each placement, one joint moved by a step, each of shape (N, 3) [m]."""
    shift = step * np.eye(len(calibrated.robot.joint_names))[joint]
    return [calibrated.ball(measured.positions + shift) for measured in data]


def _errors(balls: Sequence[np.ndarray], data: Sequence[Measurement]) -> np.ndarray:
    """Return each ball less where it should be, then errors of sockets' distances [m]."""
    parts: list[np.ndarray] = []
    for each, measured in zip(balls, data, strict=True):
        parts.append((each - targets(each, measured)).ravel())
        if measured.has_distance:
            centres = socket_centres(each, measured)
            length = float(np.linalg.norm(centres[1] - centres[0])) - measured.distance
            parts.append(np.array([length * math.sqrt(len(each))]))
    return np.concatenate(parts)


def _mean(balls: Sequence[np.ndarray], data: Sequence[Measurement]) -> float:
    """Return the mean absolute error over placements [m]."""
    metrics = [evaluate(each, measured) for each, measured in zip(balls, data, strict=True)]
    return mean_metrics(metrics).mean_absolute_error


def _by_ball(
    calibrated: CalibratedRobot, balls: Sequence[np.ndarray], data: Sequence[Measurement]
) -> np.ndarray:
    """Return the errors' derivative by the ball's place on the flange, shape (errors, 3)."""
    place = 6 * (len(calibrated.robot.joints) - 1) + np.arange(3)
    model = BallModel(calibrated.robot, place.tolist())
    slopes = [model.linearise(model.nominal, m.positions).by_parameters for m in data]
    e, columns = _errors(balls, data), range(3)
    moved = [[b + STEP * s[:, :, k] for b, s in zip(balls, slopes, strict=True)] for k in columns]
    return np.stack([(_errors(each, data) - e) / STEP for each in moved], axis=1)


def _percent(share: float) -> str:
    return "below 0.1 %" if share < 1e-3 else f"{100 * share:.1f} %"

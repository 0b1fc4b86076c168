"""What differs between places: a base that moved, a drift, a ball or a joint's zero.

It is an unknown like all others. With u its unknowns, a difference shifts the place of sample i by

    m_i = sum over k of c_ik D_i u_k

where c_ik is its course over the samples, and D_i says by how much a unit of it shifts the place.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ..data import Clock, Observations, TipSamples, tip_shifts
from ..robot import BallModel, cross_matrices
from .extended_model import ExtendedModel
from .prior_group import PriorGroup

BASE, BALL = PLACES = "base", "ball"
"""Parts that may differ, beside the joints, which are called by their names."""
SIZE, ZERO = 1e-3, 5e-3
"""Usual size of a difference of a place [m], and of a joint's zero [rad]."""
CREEP = 2e-4
"""The same of a ball's place on its flange from placement to placement [m]."""
TURNED = 10.0
"""A target that sits elsewhere by 1 m is turned by so much, where poses tell [rad/m]."""

Course = Literal["step", "drift", "slow", "each"]


@dataclass(frozen=True)
class Difference:
    """A part that differs in some of the samples."""

    course: Course
    placements: tuple[str, ...]
    """Those that it concerns."""
    part: str = BASE
    clock: Clock = "index"
    """Clock that it follows: of a step, one of the two orders."""
    at: float = 0.0
    """Of a step, the number of samples before it in the first of its placements."""
    until: float = np.inf
    """Of a step that is taken back, the number of samples before the one that is as at first."""
    waves: int = 1
    zero: float = 0.0
    """Of a joint's zero, about how large it is [rad]: D is its derivative half way there."""
    values: np.ndarray | None = field(default=None, compare=False)
    """The geometry by which D is worked out; None for the nominal one."""

    @property
    def weights(self) -> np.ndarray:
        """How large each u_k usually is, beside the first, shape (K,)."""
        if self.course == "each":
            return np.ones(len(self.placements))
        return 1 / np.arange(1, self.waves + 1) ** 2

    @property
    def width(self) -> float:
        """Its usual size [m], [rad]."""
        if self.course == "each":
            return CREEP
        return SIZE if self.part in PLACES else ZERO

    def courses(self, data: Observations) -> np.ndarray:
        """Return c_k of each sample of a robot, shape (N, K); zero for samples elsewhere."""
        if self.course == "each":
            return 1.0 * (data.recorded_at[:, None] == self.placements)
        if self.course == "step":
            return courses_of_steps([self], data)
        first = data.rows_of(self.placements[0])
        courses = np.zeros((len(data.q), self.waves))
        t = data.clock(self.clock)[first, 0]
        s = (t - t.min()) / (np.ptp(t) or 1.0)
        if self.course == "drift":
            courses[first, 0] = s - 0.5
        else:
            k = self.weights**-0.5
            courses[first] = np.cos(np.pi * k * s[:, None])
        return courses

    def slopes(self, model: ExtendedModel, data: Observations) -> np.ndarray:
        """Return the derivatives of m by all unknowns for all samples, shape (N, 3, size)."""
        courses = self.courses(data)
        if self.zero:
            joint = model.robot.joint_names.index(self.part)
            q = data.q.copy()
            q[:, joint] -= self.zero / 2 * courses[:, 0]
            data = replace(data, q=q)
        values = model.ball.nominal if self.values is None else self.values
        D = directions(self.part, model, data, values, put_on=self.course == "each")
        slopes = courses[:, None, :, None] * D[:, :, None]
        return slopes.reshape(len(courses), 3, -1)

    def prior(self, begin: int, size: int) -> PriorGroup:
        """Return the prior of its unknowns, so many from some index on."""
        variances = np.repeat(self.weights**2, size // len(self.weights))
        return PriorGroup(
            f"{self.course} of {self.part} in {self.placements[0]}",
            "m" if self.part in PLACES else "rad",
            np.arange(begin, begin + size),
            self.width,
            typical=self.width,
            shape=np.diag(variances),
        )


def courses_of_steps(steps: Sequence[Difference], data: Observations) -> np.ndarray:
    """Return the courses of K steps over the samples of a robot, shape (N, K)."""
    t = np.hstack([data.clock(step.clock) for step in steps])
    at, until = np.array([(step.at, step.until) for step in steps]).T
    of_first = [data.rows_of(step.placements[0]) for step in steps]
    as_before = np.column_stack(of_first) & ((t < at) | (t >= until))
    of_all = [data.rows_of(*step.placements) for step in steps]
    # The model has what is in most placements; of two, in the last.
    in_most = [
        step.part != BASE and 2 * len(step.placements) >= len(data.placements)
        for step in steps
    ]
    courses = 1.0 * (np.column_stack(of_all) & ~as_before)
    return courses - np.outer(~data.turned, in_most)


def directions(
    part: str,
    model: ExtendedModel,
    data: Observations,
    values: np.ndarray,
    *,
    put_on: bool = False,
) -> np.ndarray:
    """Return D of all samples, shape (N, 3, d), by the values of a geometry's parameters.

    A base is elsewhere by three numbers; an instrument may be turned about the middle of what it
    measured, too. A ball on the flange differs in the axes of its link, by -R, and so does the turn
    of a target that was ``put_on`` anew; a joint that reads too much by J_q.
    """
    ball = model.ball
    if part == BALL:
        minus_R = -ball.rotations(values, data.q).points
        if not (put_on and data.turned.any()):
            return minus_R
        turned = data.turned[:, None, None]
        by_place, by_turn = minus_R * ~turned, TURNED * minus_R * turned
        return np.concatenate([by_place, by_turn], axis=2)
    if part != BASE:
        joint = model.robot.joint_names.index(part)
        return ball.linearise(values, data.q).by_joints[:, :, [joint]]
    shifts = np.tile(np.eye(3), (len(data.q), 1, 1))
    if data.seated.all():
        return shifts
    return np.concatenate([shifts, _turns(ball.points(values, data.q), data)], axis=2)


def _turns(balls: np.ndarray, data: Observations) -> np.ndarray:
    """Return the shifts of measured points by turns of their frame, shape (N, 3, 3).

    A turn by 1 shifts the points of a placement by 1 m on average; sockets do not turn.
    """
    turns: np.ndarray = np.zeros((len(balls), 3, 3))
    for placement in data.placements:
        rows = data.rows_of(placement) & ~data.seated
        if rows.any():
            arms = balls[rows] - balls[rows].mean(axis=0)
            turns[rows] = cross_matrices(arms) / max(arms.std(), 1e-6)
    return turns


def put_on_anew(model: ExtendedModel, data: Observations, size: int) -> np.ndarray:
    """Return how far each placement's target is from their mean by the nominal robot, as unknowns.

    Its ``size`` numbers are those of all placements, each a shift in the ball's link [m], and a
    turn where turns were measured, which is zero here. It takes a frame for each placement.
    """
    shifts, _ = tip_shifts(tips_of(model.ball, data))
    unknowns = np.zeros((len(shifts), size // len(shifts)))
    unknowns[:, :3] = shifts - shifts.mean(axis=0)
    return unknowns.ravel()


def tips_of(ball: BallModel, data: Observations) -> list[TipSamples]:
    """Return the nominal robot's balls, and those measured, in each frame."""
    tips: list[TipSamples] = []
    for frame in range(len(data.frames)):
        rows = data.measured_in == frame
        q = data.q[rows]
        points = ball.points(ball.nominal, q)
        rotations = ball.rotations(ball.nominal, q).points
        tips.append(TipSamples(points, rotations, data.points[rows]))
    return tips

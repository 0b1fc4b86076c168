"""The look at a placement's numbers before anything is fitted to them.

Rows in which nothing was read are left out, each told by
its line: all joints exactly 0, a place of exactly 0, or numbers of the row before though the arm
moved. Joints that were rounded to coarse steps are told. Efforts that contradict the model are left
out.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ....recorder import Placement, measured_points
from ..robot import BallModel, Robot, gravity_moments
from .measurements import Load

LEAST_JOINTS = 3
"""Fewer joints than this may all stand at exactly 0."""
STOOD = 5e-3
"""A ball that moved by less may be measured at the same place again [m]."""
LISTED = 8
"""Rows that are told one by one."""
UNIFORM = 12**-0.5
"""Standard deviation of what is as likely anywhere in a step of 1."""
LEAST_GAPS = 4
"""Fewer differences of readings tell no step."""
LONGEST_STEP = np.deg2rad(1.01)
"""Joints in longer steps were sent to them, not rounded [rad]."""
EXACT = 0.1
"""Part of a step to which rounded readings are multiples of it: text may round them again."""
CHANCE = 1e-6
"""Probability that readings which are not rounded look so, up to which they are taken for it."""
PARTS = np.arange(1, 17)
"""The least difference of readings is so many steps."""
SHORTEST_STEP = 1e-7
"""Readings that differ by less are one [rad]."""
COARSE = 2e-4
"""Scatter of the ball per axis from which steps are told [m]."""


def without_lost_rows(placement: Placement, robot: Robot) -> Placement:
    """Return a placement without rows in which nothing was read, and a remark on each of them.

    One that has no other rows is left as it is, to be refused.

    Args:
        placement: The recording, its joints in the robot's order.
        robot: The robot.
    """
    reasons = dict(sorted(_lost_rows(placement, robot)))
    samples = [s for row, s in enumerate(placement.samples) if row not in reasons]
    if not reasons or not samples:
        return placement
    told = [
        f"{placement.samples[row].where or placement.name}: {reason}; left out"
        for row, reason in reasons.items()
    ]
    if len(told) > LISTED:
        told[LISTED:] = [f"{told[LISTED]}, one of {len(told)} such rows"]
    told[:0] = placement.remarks
    return replace(placement, samples=tuple(samples), remarks=tuple(told))


def steps_of(q: np.ndarray) -> np.ndarray:
    """Return the step in which each joint reads, shape (m,) [rad]; 0 where there is none.

    All but two of n readings are within a share e of a multiple by chance with (2 e)^(n - 2).

    Args:
        q: Joint positions, shape (N, m) [rad].
    """
    return np.array([_step_of(column) for column in q.T])


def _step_of(column: np.ndarray) -> float:
    readings = np.unique(column.round(9))
    gaps: np.ndarray = np.diff(readings)
    gaps = gaps[gaps > SHORTEST_STEP]
    if len(gaps) < LEAST_GAPS:
        return 0.0
    steps: np.ndarray = gaps.min() / PARTS
    multiples = (readings - readings[0])[:, None] / steps
    errors = np.abs(multiples - multiples.round()).max(axis=0)
    chances = (2 * errors) ** (len(readings) - 2)
    is_step = (errors < EXACT) & (chances < CHANCE) & (steps < LONGEST_STEP)
    return max(steps[is_step].tolist(), default=0.0)


def with_steps_told(placement: Placement, robot: Robot) -> Placement:
    """Return a placement with a remark where its joints read in steps that show at the ball."""
    q = placement.positions
    steps = steps_of(q)
    slopes = BallModel(robot, []).linearise(np.zeros(0), q).by_joints
    square = len(steps) * float(np.mean((slopes * steps) ** 2))
    size = UNIFORM * square**0.5
    if size < COARSE:
        return placement
    where = placement.first_file if placement.kind == "points" else placement.where
    told = (
        f"{where}: the joints read in steps of {1e3 * steps.max():.3g} mrad; "
        f"rounding to them scatters the ball by {1e3 * size:.2f} mm: write all digits"
    )
    return replace(placement, remarks=(*placement.remarks, told))


def _lost_rows(placement: Placement, robot: Robot) -> Iterator[tuple[int, str]]:
    """Yield the rows in which nothing was read, and why."""
    q = placement.positions
    zero = ~q.any(axis=1) & (q.shape[1] >= LEAST_JOINTS)
    for row in np.flatnonzero(zero).tolist():
        yield row, "all joints read exactly 0: the controller was not up"
    if placement.kind == "sockets":
        return
    points = measured_points(placement)
    nothing = ~zero & ~points.any(axis=1)
    for row in np.flatnonzero(nothing).tolist():
        yield row, "x, y and z are exactly 0: nothing was measured"
    balls = BallModel(robot, []).points(np.zeros(0), q)
    travels = np.linalg.norm(np.diff(balls, axis=0), axis=1)
    shifts = np.linalg.norm(np.diff(points, axis=0), axis=1)
    stale = (shifts == 0) & (travels > STOOD)
    stuck = ~np.diff(q, axis=0).any(axis=1) & (shifts > STOOD)
    for rows, what, other, moves in (
        (stale, "x, y and z", "the arm", travels),
        (stuck, "all joints", "the place", shifts),
    ):
        for row in np.flatnonzero(rows & ~(zero | nothing)[1:]).tolist():
            moved = f"{other} moved by {1e3 * moves[row]:.0f} mm"
            yield row + 1, f"{what} repeat the row before, though {moved}"


CLEAR = 0.9
"""Correlation beyond which efforts are the gravity torque, by some factor."""
LEAST_SLOPE, LARGEST_SLOPE = 0.2, 5.0
"""Slopes that a payload or a rough model may explain."""
CARRIES = 1.0
"""Typical gravity torque of a joint that counts [N m]."""
ENOUGH = 8
"""Fewest samples that show it."""


def with_plausible_efforts(placement: Placement, robot: Robot, load: Load) -> Placement:
    """Return a placement without efforts that contradict the model, and a remark that says so.

    At rest a joint exerts on the arm what gravity asks of it: tau(q) by the model, e as measured.
    Of joints that carry something, over all samples, the slope s and the correlation r are

        s = sum(tau e) / sum(tau^2)    r = sum(tau e) / sqrt(sum(tau^2) sum(e^2))

    A clear correlation with a slope far from 1 shows another sign or unit. No correlation shows
    nothing: a hand may have held the arm.
    """
    efforts = placement.efforts
    q = placement.positions
    if efforts is None or len(q) < ENOUGH or robot.masses_assumed:
        return placement
    tau = gravity_moments(robot, q, load.gravity, load.payload)[:, : q.shape[1]]
    loaded = np.sqrt(np.mean(tau**2, axis=0)) > CARRIES
    tau = tau[:, loaded]
    e = efforts[:, loaded]
    square = float(np.sum(tau**2))
    square_of_efforts = float(np.sum(e**2))
    if square * square_of_efforts == 0:
        return placement
    product = float(np.sum(tau * e))
    slope = product / square
    correlation = product / math.sqrt(square * square_of_efforts)
    if abs(correlation) < CLEAR or LEAST_SLOPE < slope < LARGEST_SLOPE:
        return placement
    reason = "are they in N m"
    if -LARGEST_SLOPE < slope < 0:
        reason = (
            "is their sign turned (option `effort` of the driver), "
            "or does the arm hang (--gravity)"
        )
    remark = (
        f"{placement.where}: efforts are {slope:.3g} times the model's gravity torque "
        f"(correlation {correlation:.3f}); {reason}? The model's torque takes their place"
    )
    return replace(
        placement,
        samples=tuple(replace(sample, effort=None) for sample in placement.samples),
        remarks=(*placement.remarks, remark),
    )

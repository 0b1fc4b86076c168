"""Changes since a calibration, by the evidence of samples in sockets, or of measured points."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from ...errors import fixed
from ..assessment import mm
from ..calibration import Calibration
from ..identification.data import (
    Measurement,
    Metrics,
    evaluate,
    mean_metrics,
    tip_shift,
)
from ..identification.model import probabilities_by_name
from .evidence import (
    DIVERGED,
    EVERYTHING,
    LENGTHS,
    NOTHING,
    explanations,
    linear_about,
    log_evidences,
)
from .fit import fit, next_step
from .sockets import point_task, prior_by_all_samples, socket_task
from .task import Task
from .zeros import UNIDENTIFIABLE, fit_with_zeros, zero_deviations

CHANGED = 0.5
"""Probability from which a change is reported, more probable than not: in fewer than 2 of 100 cases
where nothing changed, and in 95 of 100 where a joint moved by 1 mrad."""
MOST_SAMPLES = 150
"""Samples that are compared at most; with more, the model's own misfit would show."""
CHANGE_WORDS = {
    "tool": "the ball or tool was moved",
    "base": "the base was moved",
    LENGTHS: "the sockets' distance is off",
    EVERYTHING: "not the arm, or not the state, that was calibrated",
}
"""Changes that are no joint's."""
FAR_MOVED = 4.0
"""Standard deviations beyond which the ball is reported as moved."""
PUT_ON_AGAIN = 2e-3
"""Prior standard deviation of the place of a ball that was remounted [m]."""
SHARE = 0.5
"""Share of the errors that a shift leaves at most, if it is the cause."""


@dataclass(frozen=True)
class NearestCause:
    """An offset of one joint, and the error that remains with it."""

    joint: str
    offset: float
    """To be added to what the joint reads [rad], [m] for a prismatic joint."""
    error: float
    """Mean absolute error [m]."""
    unit: str

    def size(self, sign: str = "") -> str:
        """Return the offset with its unit, with its sign as for a format."""
        offset = self.offset if sign else abs(self.offset)
        if self.unit == "rad":
            return f"{fixed(math.degrees(offset), 2, sign)} deg"
        return f"{fixed(1e3 * offset, 2, sign)} mm"

    def text(self, share: str) -> str:
        """Return it in words, with its probability."""
        return (
            f"nearest cause {self.joint} ({share}): with {self.size('+')} added to what it reads, "
            f"{mm(self.error)} are left"
        )


@dataclass(frozen=True)
class Changes:
    """Posterior probabilities of what changed, by samples in sockets or by measured points."""

    probabilities: dict[str, float]
    """Of each explanation; empty for sockets beside points, or where no fit converged."""
    cause: NearestCause | None = None
    """The joint that changed; None for another change."""
    ball: float | None = None
    """Distance by which a remounted ball moved [m]; None where it did not."""
    untold: tuple[str, ...] = ()
    """Joints whose zeros the samples do not identify; empty where something else is to be said."""

    @property
    def likeliest(self) -> str:
        """The most probable explanation; of the changes alone, where something changed."""
        names = [
            name
            for name in self.probabilities
            if not (self.changed and name == NOTHING)
        ]
        return max(names, key=self.probabilities.__getitem__, default="")

    @property
    def share(self) -> str:
        """Probability of the most probable explanation, in words."""
        return f"{100 * self.probabilities.get(self.likeliest, 0.0):.1f} %"

    @property
    def changed(self) -> bool:
        """True where something changed."""
        return self.probability > CHANGED

    @property
    def probability(self) -> float:
        """Probability that anything changed; 0 where that was not compared."""
        return 1 - self.probabilities.get(NOTHING, 1.0)

    @property
    def change(self) -> str:
        """The most probable change in few words; empty where nothing changed."""
        if not self.changed:
            return ""
        if self.cause is not None:
            return f"{self.cause.joint} changed by {self.cause.size()}"
        return CHANGE_WORDS.get(self.likeliest, f"{self.likeliest} changed")


def changes_since(
    calibration: Calibration,
    data: Sequence[Measurement],
    stood: str,
    *,
    ball_moved: bool,
) -> tuple[Changes, Metrics | None]:
    """Return what changed, and the errors with the ball's new place where it was remounted."""
    kinds = {m.kind for m in data}
    if len(kinds) > 1:
        return Changes({}), None
    step = -(-sum(len(m.positions) for m in data) // MOST_SAMPLES)
    data = [m.only(np.arange(0, len(m.positions), step)) for m in data]
    prior = prior_by_all_samples(calibration)
    by_points = kinds == {"points"}
    task = point_task(prior, data) if by_points else socket_task(prior, data, stood)
    if ball_moved and not by_points:
        task = task.freeing(dict.fromkeys(prior.ball, PUT_ON_AGAIN))
    candidates = explanations(task)
    wide = dict[int, float]()
    for candidate in candidates:
        if candidate.name not in (LENGTHS, EVERYTHING):
            wide |= candidate.widths
    system, converged = linear_about(task, wide, lengths=True)
    if not converged:
        return Changes({}), None
    names, joints = [c.name for c in candidates], prior.robot.joint_names
    changes = Changes(probabilities_by_name(names, log_evidences(system, candidates)))
    if changes.likeliest == NOTHING:
        unidentifiable = zero_deviations(system) >= UNIDENTIFIABLE
        changes = replace(changes, untold=tuple(compress(joints, unidentifiable)))
    if changes.changed and changes.likeliest in joints:
        cause = _nearest_cause(calibration, data, task, joints.index(changes.likeliest))
        if cause is None:
            return Changes({}), None
        changes = replace(changes, cause=cause)
    if by_points or not ball_moved:
        return changes, None
    system = fit(task.with_exact_arm)
    shift = system.shift[prior.ball]
    squared_deviations = shift @ np.linalg.solve(
        system.posterior_covariance(prior.ball), shift
    )
    if squared_deviations > FAR_MOVED**2:
        changes = replace(changes, ball=math.hypot(*shift))
    distances = np.linalg.norm(system.residuals, axis=1)
    return changes, Metrics(float(distances.mean()), float(distances.max()), None)


def _nearest_cause(
    calibration: Calibration, data: Sequence[Measurement], task: Task, joint: int
) -> NearestCause | None:
    """Return the offset of a joint, by its number, that explains samples; None if no fit does."""
    system = fit_with_zeros(task, [joint])
    if next_step(system) > DIVERGED:
        return None
    zeros = task.prior.zeros
    offset = float(system.shift[zeros[joint]])
    offsets = offset * (np.arange(len(zeros)) == joint)
    shifted = [m.shifted(offsets) for m in data]
    robot = task.prior.robot
    errors = calibration.errors_of(shifted, other_tip=True)
    metrics = mean_metrics([row.calibrated for row in errors])
    unit = "m" if robot.actuated[joint].type == "prismatic" else "rad"
    return NearestCause(
        robot.joint_names[joint], offset, metrics.mean_absolute_error, unit
    )


def tip_words(calibration: Calibration, data: Sequence[Measurement]) -> str:
    """Return a sentence on a tip that sits elsewhere than the calibration's ball; empty for none.

    Any shift counts that explains the errors: a target is put on anew from day to day.
    """
    sizes = [0.0]
    for measured in data:
        if measured.kind != "points" or calibration.was_trained_on(measured):
            continue
        tips = calibration.calibrated.tips(measured)
        shift = tip_shift([tips])
        shifted = evaluate(tips.points + tips.rotations @ shift, measured)
        as_calibrated = evaluate(tips.points, measured).mean_absolute_error
        if shifted.mean_absolute_error < SHARE * as_calibrated:
            sizes.append(math.hypot(*shift))
    size = max(sizes)
    if not size:
        return ""
    return f" The tip was refitted: it sits {mm(size)} from the calibration's."

"""Cross-validation: leave each placement out of the fit once, and train on each alone.

What was left out shows how the calibration does at a new place (paper, Fig. 6).
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...recorder import Sample
from ..data import Measurement, Metrics, RobotRecordings, evaluate
from ..diagnostics import named
from ..paper import NotConverged
from ..results import CalibratedRobot
from ..robot import Robot
from .fit import fit_robots
from .options import SolveOptions


@dataclass(frozen=True)
class Plan:
    """Everything that is the same in every fit of a cross-validation."""

    robot: Robot
    measurements: tuple[Measurement, ...]
    options: SolveOptions


@dataclass(frozen=True)
class Job:
    """One fit of a cross-validation. Its errors are then measured at all placements."""

    kind: str
    """``left_out``: trained on all placements but one; ``alone``: on one; ``bootstrap``: on all,
    with samples drawn anew from them."""
    trained: tuple[int, ...]
    """Indices of the placements that it is trained on."""
    seed: int | None = None
    """Of the random draw, for a bootstrap."""


def jobs(count: int, bootstrap: int = 0) -> list[Job]:
    """Return all fits for a number of placements, with ``bootstrap`` fits to resampled data."""
    everything = tuple(range(count))
    left_out = [Job("left_out", everything[:i] + everything[i + 1 :]) for i in everything]
    alone = [Job("alone", (i,)) for i in everything]
    again = [Job("bootstrap", everything, seed) for seed in range(bootstrap)]
    return [*(left_out if count > 1 else []), *alone, *again]


@dataclass(frozen=True)
class HeldOutErrors:
    """Errors of a calibration at every placement."""

    full: tuple[Metrics, ...]
    """By the full model."""
    loaded: tuple[Metrics, ...]
    """By its URDF alone, which is what most programs load."""


def run_job(plan: Plan, job: Job) -> HeldOutErrors | None:
    """Fit, and return the errors at every placement; None if the fit did not converge."""
    try:
        robot = _fit(plan, job)
    except NotConverged:
        return None
    data = plan.measurements
    return HeldOutErrors(
        tuple(evaluate(robot.ball(m.positions, m.efforts), m) for m in data),
        tuple(evaluate(robot.geometric_ball(m.positions), m) for m in data),
    )


def _fit(plan: Plan, job: Job) -> CalibratedRobot:
    train = [plan.measurements[i] for i in job.trained]
    if job.seed is not None:
        generator = np.random.default_rng(job.seed)
        train = [resampled(measured, generator) for measured in train]
    names = {measured.name for measured in train}
    known = named(plan.measurements, plan.options.distances)
    options = replace(plan.options, known=[k for k in known if {k.first[0], k.second[0]} <= names])
    recordings = RobotRecordings(plan.robot, train, options.load)
    return fit_robots([recordings], options, require_scale=False)[0].calibrated


def resampled(measured: Measurement, generator: np.random.Generator) -> Measurement:
    """Return a placement with as many samples drawn at random from its own, with repetition.

    This is the bootstrap: how results differ between such draws shows how certain they are.
    """
    drawn: list[Sample] = []
    for socket in measured.sockets:
        samples = [s for s in measured.placement.samples if s.socket == socket]
        picks = generator.integers(len(samples), size=len(samples))
        drawn += [samples[i] for i in picks.tolist()]
    return replace(measured, placement=replace(measured.placement, samples=tuple(drawn)))


def spread(values: Iterable[Sequence[float]]) -> list[float]:
    """Return, for each placement, the standard deviation of a figure over several fits."""
    return np.std(np.array(list(values)), axis=0, ddof=1).tolist()

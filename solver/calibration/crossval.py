"""Cross-validation: leave each placement out of the fit once, and train on each alone (Fig. 6)."""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ...errors import NotConverged
from ..diagnostics import named
from ..identification.data import Measurement, one_blas_thread
from ..identification.inference import Posterior
from ..results import PlacementErrors
from .earlier import prior_of
from .errors import compared_models, placement_errors
from .fit import fit_robot
from .problem import CalibrationProblem
from .tables import METHODS

HALVES = ("odd", "even")


@dataclass(frozen=True)
class Job:
    """One fit of a cross-validation. Its errors are then measured at all placements."""

    kind: str
    """``left_out``: trained on all placements but one; ``alone``: on one; ``bootstrap``: on all,
    with samples drawn anew from them; ``odd``, ``even``: on every other sample of one."""
    trained: tuple[int, ...]
    """Indices of the placements that it is trained on."""
    seed: int | None = None
    """Of the random draw, for a bootstrap."""


@dataclass(frozen=True)
class JobResult:
    """Result of a fit of a cross-validation."""

    errors: list[PlacementErrors]
    """At every placement."""
    posterior: Posterior | None
    """None by the paper's method."""


def jobs(count: int, bootstrap: int = 0) -> list[Job]:
    """Return all fits for a number of placements, with ``bootstrap`` fits to resampled data."""
    everything = tuple(range(count))
    left_out = [
        Job("left_out", everything[:i] + everything[i + 1 :]) for i in everything
    ]
    singles = [Job("alone", (i,)) for i in everything]
    resampled = [Job("bootstrap", everything, seed) for seed in range(bootstrap)]
    halves = [Job(kind, (i,)) for kind, i in product(HALVES, everything)]
    return [*(left_out if count > 1 else []), *singles, *resampled, *halves]


@one_blas_thread
def run_job(problem: CalibrationProblem, job: Job) -> JobResult | None:
    """Fit, and return the errors at every placement; None if the fit did not converge."""
    train = [problem.measurements[i] for i in job.trained]
    if job.seed is not None:
        generator = np.random.default_rng(job.seed)
        train = [_resampled(measured, generator) for measured in train]
    if job.kind in HALVES:
        train = [_half(measured, HALVES.index(job.kind)) for measured in train]
    names = {measured.name for measured in train}
    distances = named(problem.measurements, problem.options.distances)
    known = [k for k in distances if {k.first[0], k.second[0]} <= names]
    options = replace(problem.options, known=known)
    part = replace(problem, measurements=train)
    prior = prior_of(options, [part])
    try:
        fit = fit_robot(part, options, METHODS, prior=prior, require_scale=False)
    except NotConverged:
        return None
    models = compared_models(fit.calibrated, None)
    errors = [
        placement_errors(models, "train" if i in job.trained else "test", measured)
        for i, measured in enumerate(problem.measurements)
    ]
    return JobResult(errors, fit.posterior)


def _half(measured: Measurement, first: int) -> Measurement:
    """Return every other sample of each socket, from the first or the second."""
    halves = [measured.order[rows][first::2] for rows in measured.slices]
    return measured.only(np.concatenate(halves))


def _resampled(measured: Measurement, generator: np.random.Generator) -> Measurement:
    """Return a placement with as many samples drawn from its own (the bootstrap)."""
    sockets = [measured.order[rows] for rows in measured.slices]
    drawn = [generator.choice(rows, len(rows)) for rows in sockets]
    return measured.only(np.concatenate(drawn))

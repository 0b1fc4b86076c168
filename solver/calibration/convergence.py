"""Fits that converged; where they do not, the recordings are named."""

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np

from ..identification.paper import NotConverged
from .earlier import prior_of
from .fit import Fit, fit_robots
from .options import SolveOptions
from .problem import CalibrationProblem


def converged_fits(
    problems: Sequence[CalibrationProblem],
    options: SolveOptions,
    progress: Callable[[str], None],
) -> list[Fit]:
    """Return a fit of each problem's robot, all together.

    Raises:
        NotConverged: They did not converge to finite numbers; names an error in the recordings.
    """
    findings = list(chain.from_iterable(problem.checks for problem in problems))
    contradiction = next(
        (finding for finding in findings if finding.level == "error"), None
    )
    try:
        prior = prior_of(options, problems)
        fits = fit_robots(problems, options, prior=prior, progress=progress)
    except NotConverged:
        if contradiction is None:
            raise
        raise NotConverged(f"the fit did not converge; {contradiction}") from None
    except np.linalg.LinAlgError as error:
        raise NotConverged(
            f"the fit did not converge ({error}); run mukca check"
        ) from None
    if not all(np.isfinite(fit.calibrated.values).all() for fit in fits):
        raise NotConverged(
            "the fit did not converge: its numbers are not finite; run mukca check"
        )
    return fits

"""Fits that converged; where they do not, the recordings are named."""

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np

from ...errors import NotConverged
from ..results import Fit
from .problem import CalibrationProblem


def converged_fits(
    problems: Sequence[CalibrationProblem], fitted: Callable[[], list[Fit]]
) -> list[Fit]:
    """Return the fits of problems' robots that ``fitted`` makes.

    Raises:
        NotConverged: They did not converge to finite numbers; names an error in the recordings.
    """
    findings = list(chain.from_iterable(problem.checks for problem in problems))
    contradiction = next(
        (finding for finding in findings if finding.level == "error"), None
    )
    try:
        fits = fitted()
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

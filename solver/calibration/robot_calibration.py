"""The calibration of one robot, with the checks and studies that it is handed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from ...errors import NotConverged
from ..identification import Prior, Progress
from ..identification.robot import Robot
from ..results import CalibratedRobot, CalibrationDocument, Fit, Study
from ..tables import in_placements
from .document import document_of
from .fit import NO_METHODS, CalibrationProblem, Methods, fit_robot
from .options import SolveOptions
from .preparation import Check, Recordings, problem_of


def converged_fits(
    problems: Sequence[CalibrationProblem], fitted: Callable[[], list[Fit]]
) -> list[Fit]:
    """Return the fits of problems' robots that ``fitted`` makes.

    Raises:
        NotConverged: They did not converge to finite numbers; names an error in the recordings.
    """
    try:
        fits = fitted()
    except NotConverged:
        for finding in chain.from_iterable(problem.checks for problem in problems):
            if finding.level == "error":
                words = f"the fit did not converge; {finding}"
                raise NotConverged(words) from None
        raise
    except np.linalg.LinAlgError as error:
        raise NotConverged(
            f"the fit did not converge ({error}); run mukca check"
        ) from None
    if not all(np.isfinite(fit.calibrated.values).all() for fit in fits):
        raise NotConverged(
            "the fit did not converge: its numbers are not finite; run mukca check"
        )
    return fits


PriorOf = Callable[[CalibrationProblem], Prior]
"""Returns what is known of a robot before, by its problem."""
Prove = Callable[[CalibrationProblem, Fit, PriorOf, Progress], CalibrationProblem]
"""Adds the folds that prove a fit to its problem."""


@dataclass(frozen=True, kw_only=True)
class Tables:
    """The tables of a calibration; without any, there is the fit alone."""

    checks: Sequence[Check] = ()
    """Looks at the measurements before the fit, one after the other."""
    studies: Sequence[Study] = ()
    """Sections of the document, each from the fit."""
    methods: Methods = NO_METHODS
    """Error curves, and the geometry that is exported."""
    prove: Prove = lambda problem, _fit, _prior, _progress: problem
    """Called once the fit is made."""


def calibrate_robot(
    robot: Robot,
    train: Recordings,
    test: Recordings,
    options: SolveOptions,
    tables: Tables,
    prior: PriorOf = lambda _: None,
    progress: Progress = lambda _: None,
) -> tuple[CalibrationDocument, CalibratedRobot]:
    """Return the document of a calibration, and the calibrated robot.

    Args:
        robot: The nominal robot.
        train: The placements to fit.
        test: Placements that the fit does not see.
        options: The options of ``mukca solve``.
        tables: The checks, methods and studies.
        prior: Asked once the checks are done.
        progress: Called with a word for each model that is fitted.
    """
    problem = problem_of(robot, train, test, options, tables.checks)
    names = [m.name for m in problem.measurements], [m.name for m in problem.test]
    settings = replace(
        options,
        known=problem.options.known,  # a known distance follows a placement that was split
        sockets_at=in_placements(options.located, *names),
    )

    def fitted() -> list[Fit]:
        known = prior(problem)
        return [
            fit_robot(problem, settings, tables.methods, prior=known, progress=progress)
        ]

    (fit,) = converged_fits([problem], fitted)
    proven = tables.prove(problem, fit, prior, progress)
    return document_of(proven, fit, tables.studies), fit.calibrated

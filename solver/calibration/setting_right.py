"""Recordings set right before a fit, by what explains them; see :mod:`..diagnostics`."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...recorder import Placement
from ..diagnostics import (
    Survey,
    named,
)
from ..identification.data import (
    KnownDistance,
    KnownError,
    Measurement,
    measure,
)
from ..identification.effects import GAIN
from ..identification.robot import Robot
from ..results import CalibratedRobot, Diagnostic
from .fit import Fit
from .inspector import Inspector, is_between
from .options import SolveOptions
from .problem import CalibrationProblem

NEWTON = 2
"""Steps of joint positions to where they take a difference out."""
WITH_GAIN = "; the fit has an unknown for that, which corrected joint positions follow"
"""Added to the advice on a joint's gain."""


def mended(problem: CalibrationProblem) -> tuple[CalibrationProblem, list[Diagnostic]]:
    """Set recordings right as before every fit: the one judgement of ``check`` and ``solve``.

    Args:
        problem: Recordings as they were checked. What is held out never touches those to train on,
            and is measured, never fitted: of its samples only decisions are made.

    Returns:
        The problem with all set right that can be, what is still seen of it, and coefficients of
        rare effects that the fit is to have; and what was done.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    options = problem.options
    lengths = named(problem.measurements, options.distances)
    inspector = Inspector(problem.robot, options, lengths, {})
    training, done = inspector.set_right(problem.measurements)
    held_out, of_held_out = inspector.set_right(problem.test, training, held_out=True)
    done += of_held_out
    _check_ends(lengths, training)
    survey = inspector.look(training, held_out)
    gains = _gains(inspector, training)
    problem = replace(
        problem,
        measurements=tuple(training),
        test=tuple(held_out),
        options=replace(options, known=lengths),
        survey=_with_gain(survey) if gains else survey,
        effects=tuple(GAIN.coefficient_names(sorted(gains))),
    )
    return problem, done


def seen_at_rest(problem: CalibrationProblem, fit: Fit) -> CalibrationProblem:
    """Return a problem with the differences of its fit, and what is still seen without them.

    A joint position then has the ball where it would be, had nothing differed.
    """
    if fit.selected is None or not fit.selected.full.objective.differences:
        return problem
    problem = problem.at_rest(fit.selected.full)
    options, robot, calibrated = problem.options, problem.robot, fit.calibrated
    inspector = Inspector(robot, options, options.distances, {})
    training = [_at_rest(m, calibrated) for m in problem.measurements]
    survey = inspector.look(training, problem.test)
    if problem.effects:
        survey = _with_gain(survey)
    before = problem.survey.diagnostics
    checks = [check for check in problem.checks if check not in before]
    return replace(problem, checks=(*checks, *survey.diagnostics), survey=survey)


def _at_rest(measured: Measurement, calibrated: CalibratedRobot) -> Measurement:
    """Return a placement at joint positions that take its differences out of its balls."""
    if measured.moved is None or not measured.moved.any():
        return measured
    ball, values = calibrated.model, calibrated.values
    q = measured.positions
    places = ball.points(values, q) - measured.moved
    for _ in range(NEWTON):
        balls = ball.linearise(values, q)
        errors = places - balls.points
        inverse = np.linalg.pinv(balls.by_joints)
        q = q + (inverse @ errors[:, :, None])[:, :, 0]
    return measured.shifted(measured.as_recorded(q - measured.positions))


def _gains(inspector: Inspector, training: Sequence[Measurement]) -> set[str]:
    """Return the joints whose gain the fit is to have."""
    if not inspector.sets_right:
        return set()
    return set(inspector.look(training).gains)


def _check_ends(
    lengths: Sequence[KnownDistance], training: Sequence[Measurement]
) -> None:
    """Refuse a known distance that lost an end."""
    lost = [length for length in lengths if not is_between(length, training)]
    if lost:
        raise KnownError(
            f"--known {lost[0]}: one of its sockets is left with too few samples; leave that "
            "distance out, or keep all samples by --as-recorded"
        )


def _with_gain(survey: Survey) -> Survey:
    """Return what was seen of joints whose gain the fit has: how well, the errors say."""
    shared = list(survey.shared)
    for i, diagnostic in enumerate(shared):
        if (diagnostic.code, diagnostic.level) == (GAIN.name, "error"):
            advice = f"{diagnostic.advice}{WITH_GAIN}"
            shared[i] = replace(diagnostic, level="warning", advice=advice)
    return replace(survey, shared=tuple(shared))


def placements_set_right(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> tuple[list[Placement], list[Diagnostic]]:
    """Return placements with all set right that can be, as before a fit, and what was done."""
    measured = [
        measure(p, robot, options.distance, sockets=1, load=options.load)
        for p in placements
    ]
    problem = CalibrationProblem(
        robot, (), options.load, options=options, test=measured
    )
    mending, done = mended(problem)
    return [m.placement for m in mending.test], done

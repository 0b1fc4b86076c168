"""Checks of recordings before a fit, which add findings or set the recordings right."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...recorder import Placement
from ..diagnostics import (
    Survey,
    named,
    next_placement,
    single_socket_diagnostics,
    without_unknown,
)
from ..identification.data import (
    KnownError,
    Measurement,
    measure,
)
from ..identification.robot import Robot
from ..results import CalibratedRobot, Diagnostic, NextPlacement, Scale
from .findings import reworded, sized_hypotheses
from .fit import CalibrationProblem
from .inspector import Inspector, is_between, with_gain
from .options import SolveOptions
from .set_ups import aligned, as_recorded

NEWTON = 2
"""Steps of joint positions to where they take a difference out."""


@dataclass(frozen=True, kw_only=True)
class InspectedProblem(CalibrationProblem):
    """Recordings that were looked at, and what was seen of them."""

    survey: Survey
    """Findings on the placements, one by one and together, once all was set right."""

    @classmethod
    def of(cls, problem: CalibrationProblem, survey: Survey) -> "InspectedProblem":
        """Return a problem with what was seen of its recordings."""
        fields: dict[str, Any] = {**vars(problem), "hypotheses": survey.hypotheses}
        return cls(**fields, survey=survey)

    def sized(self, scale: Scale) -> "InspectedProblem":
        """Return the problem whose explanations of the arm's size have that of a fit."""
        hypotheses = sized_hypotheses(self, scale)
        return replace(
            self,
            checks=reworded(self.checks, self.hypotheses, hypotheses),
            hypotheses=hypotheses,
            survey=replace(self.survey, hypotheses=hypotheses),
        )

    def at_rest(
        self, shifts: np.ndarray | None, calibrated: CalibratedRobot
    ) -> "InspectedProblem":
        """Return the recordings with what differs, and what is still seen without that.

        A joint position then has the ball where it would be, had nothing differed.
        """
        if shifts is None:
            return self
        moved = replace(
            self, measurements=super().at_rest(shifts, calibrated).measurements
        )
        inspector = Inspector(self.robot, self.options, self.options.distances, {})
        view, originals = aligned(self)
        training = view.measurements
        if not originals:
            training = [_at_rest(m, calibrated) for m in moved.measurements]
        survey = inspector.look(training, view.test)
        if self.effects:
            survey = with_gain(survey)
        before = self.survey.diagnostics
        checks = [check for check in self.checks if check not in before]
        checks += [  # the fit had an unknown for other things
            replace(check, advice=without_unknown(check.advice))
            for check in survey.diagnostics
        ]
        return replace(
            moved,
            checks=tuple(checks),
            hypotheses=survey.hypotheses,
            survey=survey,
        )


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


def mended(problem: CalibrationProblem) -> tuple[InspectedProblem, list[Diagnostic]]:
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
    lost = [length for length in lengths if not is_between(length, training)]
    if lost:
        raise KnownError(
            f"--known {lost[0]}: one of its sockets is left with too few samples; leave that "
            "distance out, or keep all samples by --as-recorded"
        )
    survey = inspector.look(training, held_out)
    gains = inspector.gains(training)
    problem = replace(
        problem,
        measurements=tuple(training),
        test=tuple(held_out),
        options=replace(options, known=lengths),
        effects=gains,
    )
    survey = with_gain(survey) if gains else survey
    return InspectedProblem.of(problem, survey), done


def inspected(problem: CalibrationProblem) -> InspectedProblem:
    """Return recordings set right, with all findings on them, and where to record next."""
    view, originals = aligned(problem)
    view, done = mended(view)
    problem = replace(
        view,
        measurements=tuple(as_recorded(m, originals) for m in view.measurements),
        test=tuple(as_recorded(m, originals) for m in view.test),
    )
    place = None
    if any(measured.kind == "sockets" for _, measured in problem.placements):
        place = NextPlacement(text=next_placement(problem.robot, problem.survey))
    checks = (*done, *problem.survey.diagnostics)
    return replace(problem, checks=checks, next_placement=place)


def lone_sockets(problem: CalibrationProblem) -> CalibrationProblem:
    """Return recordings of one robot with findings on placements in one socket only."""
    if problem.name or problem.options.located:
        return problem
    diagnostics = single_socket_diagnostics(
        [measured for _, measured in problem.placements], problem.options.distances
    )
    return replace(problem, checks=(*problem.checks, *diagnostics))


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

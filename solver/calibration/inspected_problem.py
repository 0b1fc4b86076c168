"""Recordings that were looked at before their fit."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..diagnostics import Survey, without_unknown
from ..identification.data import Measurement
from ..identification.effects import GAIN
from ..results import CalibratedRobot, Scale
from .findings import reworded, sized_hypotheses
from .inspector import Inspector
from .problem import CalibrationProblem
from .target_alignment import aligned

WITH_GAIN = "; the fit has an unknown for that, which corrected joint positions follow"
"""Added to the advice on a joint's gain."""
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


def with_gain(survey: Survey) -> Survey:
    """Return what was seen of joints whose gain the fit has: how well, the errors say."""
    shared = list(survey.shared)
    for i, diagnostic in enumerate(shared):
        if (diagnostic.code, diagnostic.level) == (GAIN.name, "error"):
            advice = f"{diagnostic.advice}{WITH_GAIN}"
            shared[i] = replace(diagnostic, level="warning", advice=advice)
    return replace(survey, shared=tuple(shared))

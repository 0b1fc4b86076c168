"""Recordings that were looked at before their fit."""

from dataclasses import dataclass, replace
from typing import Any

from ..diagnostics import Survey
from ..results import Scale
from .findings import reworded, sized_hypotheses
from .problem import CalibrationProblem


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

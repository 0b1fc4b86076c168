"""Findings on recordings, by what their fit says of them: movements, and the arm's size."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..diagnostics import SIZE_BY_DISTANCE, by_fit, where_of
from ..identification.data import Measurement
from ..identification.model import FoundMovement
from ..results import Diagnostic, Fit, Hypothesis, Scale, Study
from .problem import CalibrationProblem

STEADY = "screw the base down, let the arm warm up, and record it again"


def findings(
    fit: Fit, problem: CalibrationProblem, scale: Scale, distorted: Sequence[str]
) -> tuple[Diagnostic, ...]:
    """Return the findings from before the fit, and the movements of places that it found."""
    diagnostics = list(problem.checks)
    by_name = {m.name: m for m in problem.measurements}
    for movement in fit.full.movements if fit.full else ():
        measured = by_name[movement.placement]
        code = "movement" if movement.kept else "moved"
        text = _movement_text(measured, movement)
        where = where_of([measured])
        diagnostics.append(Diagnostic("warning", code, where, text, STEADY))
    sized = hypotheses(fit, problem, scale, distorted)
    return reworded(diagnostics, problem.hypotheses, sized)


def reworded(
    diagnostics: Sequence[Diagnostic],
    before: Sequence[Hypothesis],
    after: Sequence[Hypothesis],
) -> tuple[Diagnostic, ...]:
    """Return findings, those that are an explanation in its new words."""
    pairs = zip(before, after, strict=True)
    texts = {old.text: new.text for old, new in pairs}
    return tuple(replace(d, text=texts.get(d.text, d.text)) for d in diagnostics)


def hypotheses(
    _: Fit, problem: CalibrationProblem, scale: Scale, distorted: Sequence[str]
) -> tuple[Hypothesis, ...]:
    """Return the explanations of the recordings, those of the arm's size by that of the fit."""
    return problem.hypotheses if distorted else sized_hypotheses(problem, scale)


def sized_hypotheses(
    problem: CalibrationProblem, scale: Scale
) -> tuple[Hypothesis, ...]:
    """Return explanations of recordings, those of the arm's size by that of a fit.

    Where other lengths than those between a base's sockets are known, a fit follows these, and
    where something else is more probable, it may be why the fit made the arm larger.
    """
    by_bases_alone = all(m.kind == "sockets" for m in problem.measurements)
    if problem.options.distances or problem.options.located or not by_bases_alone:
        return problem.hypotheses
    if all(h.name not in SIZE_BY_DISTANCE for h in problem.hypotheses[:1]):
        return problem.hypotheses
    return tuple(by_fit(h, scale.value) for h in problem.hypotheses)


def _movement_text(measured: Measurement, movement: FoundMovement) -> str:
    """Return a movement in words, a step with the first sample after it."""
    if movement.rank is None:
        return movement.text
    in_time = measured.order[np.argsort(measured.clock("time"), kind="stable")]
    first = measured.placement.samples[int(in_time[movement.rank])]
    return movement.text.format(first=first.named)


READS = ("scale", "distorted")
CHECKS = Study("checks", findings, READS, needs_posterior=False)
HYPOTHESES = Study("hypotheses", hypotheses, READS, needs_posterior=False)

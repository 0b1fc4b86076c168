"""Recordings set right before a fit, by what explains them; see :mod:`..diagnostics`."""

from collections.abc import Collection, Sequence
from dataclasses import replace

from ..assessment import LEAST_HELD_OUT
from ..diagnostics import (
    ALL_ACTIONS,
    LEAST,
    Action,
    Survey,
    named,
)
from ..identification.data import (
    KnownDistance,
    KnownError,
    Measurement,
)
from ..identification.effects import GAIN
from ..results import Diagnostic
from .inspected_problem import InspectedProblem
from .inspector import Inspector, actions_of, by_findings, is_between
from .problem import CalibrationProblem

WITH_GAIN = "; the fit has an unknown for that, which corrected joint positions follow"
"""Added to the advice on a joint's gain."""


def mended(
    problem: CalibrationProblem, barred: Collection[Action] = ()
) -> tuple[InspectedProblem, list[Diagnostic]]:
    """Set recordings right as before every fit: the one judgement of ``check`` and ``solve``.

    Args:
        problem: Recordings as they were checked. Those to train on are never looked at with those
            held out before they are set right.
        barred: What may not be done although the options allow it.

    Returns:
        The problem with all set right that can be, what is still seen of it, known distances by the
        names that placements have now, and coefficients of rare effects that the fit is to have;
        and what was done.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    options = problem.options
    lengths = named(problem.measurements, options.distances)
    inspector = Inspector(problem.robot, options, lengths, {})
    training = list(problem.measurements)
    held_out = list(problem.test)
    done = list[Diagnostic]()
    actions = set(actions_of(options)) - set(barred)
    survey = inspector.look(training, held_out)
    is_mendable = any(inspection.corrections for inspection in survey.placements)
    if actions and (survey.unclear or is_mendable):
        training, done = _trained_set_right(inspector, survey, training, actions)
        held_out, of_held_out = inspector.set_right(
            held_out, training, LEAST_HELD_OUT, actions
        )
        done += of_held_out
        survey = inspector.look(training, held_out)
    gains = _gains(inspector, survey, training)
    problem = replace(
        problem,
        measurements=tuple(training),
        test=tuple(held_out),
        options=replace(options, known=_lengths_between(inspector, training)),
        effects=tuple(GAIN.coefficient_names(sorted(gains))),
    )
    survey = _with_gain(survey) if gains else survey
    return InspectedProblem.of(problem, survey), done


def _trained_set_right(
    inspector: Inspector,
    survey: Survey,
    training: Sequence[Measurement],
    actions: set[Action],
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return the placements to train on with all set right that can be, and what was done.

    Too few samples tell nothing by themselves: where a base moved, all placements tell together.
    """
    if inspector.options.zeros:
        # Gears with play look like an arm that drifts.
        actions = actions - {"follow"}
    set_right, done = inspector.set_right(training, actions=actions)
    if done:
        return set_right, done
    inspections = survey.placements[: len(training)]
    return by_findings(set_right, inspections, LEAST, actions)


def _gains(
    inspector: Inspector, survey: Survey, training: Sequence[Measurement]
) -> set[str]:
    """Return the joints whose gain the fit is to have: those trained on tell it by themselves."""
    if not survey.gains or actions_of(inspector.options) != ALL_ACTIONS:
        return set()
    return set(survey.gains) & set(inspector.look(training).gains)


def _lengths_between(
    inspector: Inspector, training: Sequence[Measurement]
) -> tuple[KnownDistance, ...]:
    """Return known distances by the names that placements have now; refuse one that lost an end."""
    lengths = inspector.followed(training)
    lost = [length for length in lengths if not is_between(length, training)]
    if lost:
        raise KnownError(
            f"--known {lost[0]}: one of its sockets is left with too few samples; leave that "
            "distance out, or keep all samples by --as-recorded"
        )
    return lengths


def _with_gain(survey: Survey) -> Survey:
    """Return what was seen of joints whose gain the fit has: how well, the errors say."""
    shared = list(survey.shared)
    for i, diagnostic in enumerate(shared):
        if (diagnostic.code, diagnostic.level) == (GAIN.name, "error"):
            advice = f"{diagnostic.advice}{WITH_GAIN}"
            shared[i] = replace(diagnostic, level="warning", advice=advice)
    return replace(survey, shared=tuple(shared))

"""Recordings set right before a fit, by what explains them; see :mod:`..diagnostics`."""

from collections.abc import Sequence
from dataclasses import replace

from ..diagnostics import (
    named,
)
from ..identification.data import (
    KnownDistance,
    KnownError,
    Measurement,
)
from ..identification.effects import GAIN
from ..results import Diagnostic
from .inspected_problem import InspectedProblem, with_gain
from .inspector import Inspector, is_between
from .problem import CalibrationProblem


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
    _check_ends(lengths, training)
    survey = inspector.look(training, held_out)
    gains = _gains(inspector, training)
    problem = replace(
        problem,
        measurements=tuple(training),
        test=tuple(held_out),
        options=replace(options, known=lengths),
        effects=tuple(GAIN.coefficient_names(sorted(gains))),
    )
    survey = with_gain(survey) if gains else survey
    return InspectedProblem.of(problem, survey), done


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

"""Recordings set right before a fit, by what explains them; see :mod:`..diagnostics`."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...errors import MukcaError
from ...recorder import Placement, RecordingError
from ..assessment import LEAST_HELD_OUT, repeatability_of
from ..data import (
    KnownDistance,
    KnownError,
    Measurement,
    TooFewError,
    measure,
    spaced,
    whole_name,
)
from ..diagnostics import (
    ALL_ACTIONS,
    HELD_OUT,
    LEAST,
    MENDER,
    Action,
    Given,
    Inspection,
    Survey,
    corrected,
    inspect_all,
    named,
)
from ..results import Diagnostic
from ..robot import Robot
from .options import SolveOptions

Look = Callable[..., Survey]
NOTHING_SEEN = Survey((), ())
"""Of no placements."""
WITHOUT_DRIFT = "; it is held out: the errors measured there are those without that drift"
"""In place of the advice on what is held out."""
ROUNDS = 3
"""Times that recordings are looked at and set right at most."""


@dataclass(frozen=True)
class MendedRecordings:
    """Placements with all set right that can be, what was done, and what is still seen of them."""

    train: tuple[Measurement, ...]
    test: tuple[Measurement, ...]
    done: tuple[Diagnostic, ...] = ()
    survey: Survey = NOTHING_SEEN
    known: tuple[KnownDistance, ...] = ()
    """Known distances between the placements to train on, as they are called now."""


def mended(
    robot: Robot,
    train: Sequence[Measurement],
    test: Sequence[Measurement],
    options: SolveOptions,
    without: Collection[Action] = (),
) -> MendedRecordings:
    """Set recordings right as before every fit: the one judgement of ``check`` and ``solve``.

    Args:
        robot: The robot.
        train: Placements to train on. Those held out are never looked at with them.
        test: Placements held out.
        options: What may be done, and what was said of the recordings.
        without: What may not be done all the same.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    trained, held_out = list(train), list(test)
    look = _look(robot, trained, options)
    actions = set(actions_of(options)) - set(without)
    survey, done = look(trained, held_out), list[Diagnostic]()
    wrong = survey.unclear or any(one.corrections for one in survey.placements)
    if wrong and actions:
        mend = partial(set_right, look, actions=actions)
        seen = survey.placements[: len(trained)]
        trained, done = mend(trained)
        if not done:  # too few to tell by themselves: where a base moved, all tell together
            trained, done = by_findings(trained, seen, LEAST, actions)
        held_out, more = mend(held_out, trained, LEAST_HELD_OUT)
        survey, done = look(trained, held_out), [*done, *more]
    if actions_of(options) == ALL_ACTIONS:
        held_out, survey = _without_drifts(held_out, survey)
    known = _followed(named(train, options.distances), trained)
    if lost := [k for k in known if not _is_between(k, trained)]:
        raise KnownError(
            f"--known {lost[0]}: one of its sockets is left with too few samples; leave that "
            "distance out, or keep all samples by --as-recorded"
        )
    return MendedRecordings(tuple(trained), tuple(held_out), tuple(done), survey, known)


def _without_drifts(
    held_out: Sequence[Measurement], survey: Survey
) -> tuple[list[Measurement], Survey]:
    """Return placements held out, judged without the drifts of their bases, and what says so."""
    placements = list(held_out)
    count = len(survey.placements) - len(placements)
    seen = list(survey.placements)
    for i, inspection in enumerate(seen[count:]):
        told = [d for d in inspection.diagnostics if d.code == "drift" and HELD_OUT in d.advice]
        if inspection.drift is None or not told:
            continue
        m, rank = placements[i], placements[i].order
        placements[i] = replace(
            m, moved=np.outer(rank / max(rank.max(), 1) - 0.5, inspection.drift)
        )
        diagnostics = tuple(
            replace(d, advice=d.advice.replace(HELD_OUT, WITHOUT_DRIFT)) if d in told else d
            for d in inspection.diagnostics
        )
        seen[count + i] = replace(inspection, diagnostics=diagnostics)
    return placements, replace(survey, placements=tuple(seen))


def _look(robot: Robot, train: Sequence[Measurement], options: SolveOptions) -> Look:
    """Return what looks at placements to train on, and at others held out beside them."""
    known = named(train, options.distances)
    size = repeatability_of(robot, options.repeatability_mm)
    zeros, load, mender = bool(options.zeros), options.load, _mender(options)

    def look(trained: Sequence[Measurement], held_out: Sequence[Measurement] = ()) -> Survey:
        names = [m.name for m in trained] if held_out else []
        every = [*trained, *held_out]
        lengths = [k for k in _followed(known, every) if _is_between(k, every)]
        given = Given(lengths, options.deviation, load, mender, names)
        return inspect_all(robot, every, given, zeros=zeros, repeatability=size)

    return look


def _followed(
    known: Sequence[KnownDistance], measurements: Sequence[Measurement]
) -> tuple[KnownDistance, ...]:
    """Return known distances by the first parts that hold their sockets, of what was split."""

    def part(end: tuple[str, int]) -> tuple[str, int]:
        name, socket = end
        parts = [m.name for m in measurements if whole_name(m.name) == name and socket in m.sockets]
        return (parts[0] if parts else name), socket

    return tuple(replace(k, first=part(k.first), second=part(k.second)) for k in known)


def _is_between(known: KnownDistance, measurements: Sequence[Measurement]) -> bool:
    """Tell whether both ends of a distance are sockets of some placements."""
    return {known.first, known.second} <= {(m.name, k) for m in measurements for k in m.sockets}


def _mender(options: SolveOptions) -> str:
    """Return what would set recordings right, in the words of advice."""
    if actions_of(options) == ALL_ACTIONS:
        return MENDER
    return f"{MENDER} --method auto" if options.method == "paper" else f"{MENDER} by default"


def set_right(
    look: Look,
    measurements: Sequence[Measurement],
    beside: Sequence[Measurement] = (),
    least: int = LEAST,
    *,
    actions: Collection[Action] = ALL_ACTIONS,
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return recordings with all set right that can be, and what was done.

    Args:
        look: Returns what explains placements to train on, and others held out beside them.
        measurements: The placements; those held out are never looked at with those to train on
            before the latter are set right.
        beside: Placements that are set right already.
        least: Fewest samples in a socket of a part that is kept.
        actions: What may be done.
    """
    placements, done = list(measurements), list[Diagnostic]()
    for _ in range(ROUNDS if placements else 0):
        survey = look(beside, placements) if beside else look(placements)
        seen = survey.placements[len(beside) :]
        if survey.unclear:
            seen = [look([one]).placements[0] for one in placements]
        elif len(beside) == 1:
            seen = _beside_one(survey.placements[0], seen)
        placements, more = by_findings(placements, seen, least, actions)
        if not more:
            break
        done += more
    return placements, done


def _beside_one(trained: Inspection, held_out: Sequence[Inspection]) -> list[Inspection]:
    """Return what was seen of placements held out, with what sets apart the one trained on.

    Which of two differs cannot be told: the model has the ball and the zeros of the latter.
    """
    apart = tuple(one for one in trained.corrections if one.apart is not None)
    return [replace(one, corrections=(*one.corrections, *apart)) for one in held_out]


def by_findings(
    placements: Sequence[Measurement],
    seen: Sequence[Inspection],
    least: int,
    actions: Collection[Action],
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return placements set right by what was seen of each, and what was done."""
    every = [one.corrections for one in seen]
    corrections = [[one for one in own if one.action in actions] for own in every]
    return corrected(placements, corrections, least)


def checked(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions, sockets: int
) -> tuple[tuple[Measurement, ...], list[MukcaError]]:
    """Return checked placements, and why others are left out, too short or not readable."""
    measured, refused = list[Measurement](), list[MukcaError]()
    for placement in placements:
        try:
            one = measure(placement, robot, options.distance, sockets=sockets, load=options.load)
        except (TooFewError, RecordingError) as error:
            if options.as_recorded:
                raise
            refused.append(error)
            continue
        measured.append(spaced(one, placement.name, options.located))
    return tuple(measured), refused


def actions_of(options: SolveOptions) -> tuple[Action, ...]:
    """Return what may be done to set recordings right; by Eq. (5) nothing, as in the paper."""
    if options.as_recorded or options.method == "paper":
        return ("split",) if options.split_moved else ()
    return ALL_ACTIONS


def placements_set_right(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> tuple[list[Placement], list[Diagnostic]]:
    """Return placements with all set right that can be, as before a fit, and what was done."""
    measured = [
        measure(p, robot, options.distance, sockets=1, load=options.load) for p in placements
    ]
    # a placement alone does not say what has unknowns of its own in it
    right = mended(robot, (), measured, options, without=["set apart"])
    return [m.placement for m in right.test], [*right.done]

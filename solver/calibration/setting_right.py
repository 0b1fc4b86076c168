"""Recordings set right before a fit, by what explains them; see :mod:`..diagnostics`."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, product

from ...errors import MukcaError
from ...recorder import Placement, RecordingError
from ..assessment import LEAST_HELD_OUT, repeatability_of
from ..bayes.model.effects import GAIN
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
WITH_GAIN = "; the fit has an unknown for that, which corrected joint positions follow"
"""Added to the advice on a joint's gain."""
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
    effects: tuple[str, ...] = ()
    """Coefficients of rare effects that those show, which the fit is to have."""


def mended(
    robot: Robot,
    train: Sequence[Measurement],
    test: Sequence[Measurement],
    options: SolveOptions,
    barred: Collection[Action] = (),
) -> MendedRecordings:
    """Set recordings right as before every fit: the one judgement of ``check`` and ``solve``.

    Args:
        robot: The robot.
        train: Placements to train on. Those held out are never looked at with them.
        test: Placements held out.
        options: What may be done, and what was said of the recordings.
        barred: What may not be done all the same.

    Raises:
        KnownError: A known distance names a socket that is not there.
    """
    training = list(train)
    held_out = list(test)
    look = _look(robot, training, options)
    actions = set(actions_of(options)) - set(barred)
    survey = look(training, held_out)
    done = list[Diagnostic]()
    doubtful = survey.unclear or any(inspection.corrections for inspection in survey.placements)
    if doubtful and actions:
        # what looks like a drift of an arm whose gears have play
        of_training = actions - {"follow"} if options.zeros else actions
        mend = partial(set_right, look, actions=of_training)
        inspections = survey.placements[: len(training)]
        training, done = mend(training)
        if not done:  # too few to tell by themselves: where a base moved, all tell together
            training, done = by_findings(training, inspections, LEAST, of_training)
        mend = partial(set_right, look, actions=actions)
        held_out, actions_held_out = mend(held_out, training, LEAST_HELD_OUT)
        survey = look(training, held_out)
        done = [*done, *actions_held_out]
    effects = _effects_seen(survey, look, training) if actions_of(options) == ALL_ACTIONS else ()
    survey = _with_gain(survey) if effects else survey
    lengths = _followed(named(train, options.distances), training)
    if lost := [k for k in lengths if not _is_between(k, training)]:
        raise KnownError(
            f"--known {lost[0]}: one of its sockets is left with too few samples; leave that "
            "distance out, or keep all samples by --as-recorded"
        )
    return MendedRecordings(tuple(training), tuple(held_out), tuple(done), survey, lengths, effects)


def _effects_seen(survey: Survey, look: Look, training: Sequence[Measurement]) -> tuple[str, ...]:
    """Return the coefficients for a fit that all placements show, and those trained on as well."""
    seen = set(survey.gains) and set(survey.gains) & set(look(training).gains)
    return tuple(GAIN.coefficient_names(sorted(seen)))


def _with_gain(survey: Survey) -> Survey:
    """Return what was seen of joints whose gain the fit has: how well, the errors say."""
    shared = tuple(
        replace(d, level="warning", advice=f"{d.advice}{WITH_GAIN}")
        if (d.code, d.level) == (GAIN.name, "error")
        else d
        for d in survey.shared
    )
    return replace(survey, shared=shared)


def _look(robot: Robot, train: Sequence[Measurement], options: SolveOptions) -> Look:
    """Return what looks at placements to train on, and at others held out beside them."""
    stated = named(train, options.distances)
    size = repeatability_of(robot, options.repeatability_mm)
    zeros = bool(options.zeros)
    load = options.load
    mender = _mender(options)
    surveys: dict[tuple[int, ...], tuple[list[Measurement], Survey]] = {}

    def look(training: Sequence[Measurement], held_out: Sequence[Measurement] = ()) -> Survey:
        names = [m.name for m in training] if held_out else []
        measurements = [*training, *held_out]
        # The same placements are looked at once; they are kept, so that no other takes an id.
        key = (len(names), *map(id, measurements))
        if key in surveys:
            return surveys[key][1]
        lengths = [k for k in _followed(stated, measurements) if _is_between(k, measurements)]
        premises = Given(lengths, options.deviation, load, mender, names)
        survey = inspect_all(robot, measurements, premises, zeros=zeros, repeatability=size)
        surveys[key] = measurements, survey
        return survey

    return look


def _followed(
    lengths: Sequence[KnownDistance], measurements: Sequence[Measurement]
) -> tuple[KnownDistance, ...]:
    """Return known distances by the first parts that hold their sockets, of what was split."""

    def part(end: tuple[str, int]) -> tuple[str, int]:
        name, socket = end
        parts = [m.name for m in measurements if whole_name(m.name) == name and socket in m.sockets]
        return (parts[0] if parts else name), socket

    return tuple(replace(k, first=part(k.first), second=part(k.second)) for k in lengths)


def _is_between(length: KnownDistance, measurements: Sequence[Measurement]) -> bool:
    """Tell whether both ends of a distance are sockets of some placements."""
    sockets = chain.from_iterable(product([m.name], m.sockets) for m in measurements)
    return {length.first, length.second} <= {*sockets}


def _mender(options: SolveOptions) -> str:
    """Return what would set recordings right, in the words of advice."""
    if actions_of(options) == ALL_ACTIONS:
        return MENDER
    return f"{MENDER} --method auto" if options.method == "paper" else f"{MENDER} by default"


def set_right(
    look: Look,
    measurements: Sequence[Measurement],
    reference: Sequence[Measurement] = (),
    minimum: int = LEAST,
    *,
    actions: Collection[Action] = ALL_ACTIONS,
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return recordings with all set right that can be, and what was done.

    Args:
        look: Returns what explains placements to train on, and others held out beside them.
        measurements: The placements; those held out are never looked at with those to train on
            before the latter are set right.
        reference: Placements that are set right already.
        minimum: Fewest samples in a socket of a part that is kept.
        actions: What may be done.
    """
    placements = list(measurements)
    done = list[Diagnostic]()
    for _ in range(ROUNDS if placements else 0):
        survey = look(reference, placements) if reference else look(placements)
        inspections = survey.placements[len(reference) :]
        alone = [look([placement]).placements[0] for placement in placements if survey.unclear]
        if any(inspection.corrections for inspection in alone):
            inspections = alone
        elif len(reference) == 1:
            inspections = _beside_one(survey.placements[0], inspections)
        placements, diagnostics = by_findings(placements, inspections, minimum, actions)
        if not diagnostics:
            break
        done += diagnostics
    return placements, done


def _beside_one(reference: Inspection, held_out: Sequence[Inspection]) -> list[Inspection]:
    """Return what was seen of placements held out, with what sets apart the one trained on.

    Which of two differs cannot be told: the model has the ball and the zeros of the latter.
    """
    differences = tuple(
        correction for correction in reference.corrections if correction.apart is not None
    )
    return [
        replace(inspection, corrections=(*inspection.corrections, *differences))
        for inspection in held_out
    ]


def by_findings(
    placements: Sequence[Measurement],
    inspections: Sequence[Inspection],
    least: int,
    actions: Collection[Action],
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return placements set right by what was seen of each, and what was done.

    Two sockets are taken for one only where another placement says how large the arm is.
    """
    by_placement = [inspection.corrections for inspection in inspections]
    pairs = zip(placements, by_placement, strict=True)
    if not any(len(m.sockets) > 1 and "merge" not in {c.action for c in cs} for m, cs in pairs):
        actions = {action for action in actions if action != "merge"}
    corrections = [
        [*filter(lambda correction: correction.action in actions, corrections_here)]
        for corrections_here in by_placement
    ]
    for corrections_here in corrections:
        steps = [c for c in corrections_here if c.action != "follow"]
        if steps:  # a drift of what remains is looked for afterwards
            corrections_here[:] = steps
    return corrected(placements, corrections, least)


def checked(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions, sockets: int
) -> tuple[tuple[Measurement, ...], list[MukcaError]]:
    """Return checked placements, and why others are left out, too short or not readable."""
    measured = list[Measurement]()
    errors = list[MukcaError]()
    for placement in placements:
        try:
            measurement = measure(
                placement, robot, options.distance, sockets=sockets, load=options.load
            )
        except (TooFewError, RecordingError) as error:
            if options.as_recorded:
                raise
            errors.append(error)
            continue
        measured.append(spaced(measurement, placement.name, options.located))
    return tuple(measured), errors


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
    mending = mended(robot, (), measured, options, barred=["set apart", "follow"])
    return [m.placement for m in mending.test], [*mending.done]

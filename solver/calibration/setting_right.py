"""Recordings set right before a fit, by what explains them; see :mod:`..diagnostics`."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import chain

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
    without,
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
from .problem import CalibrationProblem

WITH_GAIN = "; the fit has an unknown for that, which corrected joint positions follow"
"""Added to the advice on a joint's gain."""
ROUNDS = 3
"""Times that recordings are looked at and set right at most."""


def mended(
    problem: CalibrationProblem, barred: Collection[Action] = ()
) -> tuple[CalibrationProblem, list[Diagnostic]]:
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
    inspector = Inspector(
        problem.robot, options, named(problem.measurements, options.distances), {}
    )
    training = list(problem.measurements)
    held_out = list(problem.test)
    allowed = actions_of(options)
    actions = set(allowed) - set(barred)
    survey = inspector.look(training, held_out)
    done = list[Diagnostic]()
    doubtful = survey.unclear or any(
        inspection.corrections for inspection in survey.placements
    )
    if doubtful and actions:
        # what looks like a drift of an arm whose gears have play
        of_training = actions - {"follow"} if options.zeros else actions
        inspections = survey.placements[: len(training)]
        training, done = inspector.set_right(training, actions=of_training)
        # Too few to tell by themselves: where a base moved, all tell together.
        if not done:
            training, done = by_findings(training, inspections, LEAST, of_training)
        held_out, done_held_out = inspector.set_right(
            held_out, training, LEAST_HELD_OUT, actions
        )
        done += done_held_out
        survey = inspector.look(training, held_out)
    gains = set(survey.gains) if allowed == ALL_ACTIONS else set[str]()
    if gains:
        gains &= set(inspector.look(training).gains)
    lengths = inspector.followed(training)
    if lost := [k for k in lengths if not _is_between(k, training)]:
        raise KnownError(
            f"--known {lost[0]}: one of its sockets is left with too few samples; leave that "
            "distance out, or keep all samples by --as-recorded"
        )
    problem = replace(
        problem,
        measurements=tuple(training),
        test=tuple(held_out),
        options=replace(options, known=lengths),
        survey=_with_gain(survey) if gains else survey,
        effects=tuple(GAIN.coefficient_names(sorted(gains))),
    )
    return problem, done


def _with_gain(survey: Survey) -> Survey:
    """Return what was seen of joints whose gain the fit has: how well, the errors say."""
    shared = list(survey.shared)
    for i, diagnostic in enumerate(shared):
        if (diagnostic.code, diagnostic.level) == (GAIN.name, "error"):
            advice = f"{diagnostic.advice}{WITH_GAIN}"
            shared[i] = replace(diagnostic, level="warning", advice=advice)
    return replace(survey, shared=tuple(shared))


@dataclass(frozen=True)
class Inspector:
    """Looks at recordings, and sets them right."""

    robot: Robot
    options: SolveOptions
    lengths: Sequence[KnownDistance]
    """Known distances, as they were named before anything was split."""
    surveys: dict[tuple[int, ...], tuple[list[Measurement], Survey]]
    """Inspections of placements, which are kept, so that no other takes an id."""

    def look(
        self, training: Sequence[Measurement], held_out: Sequence[Measurement] = ()
    ) -> Survey:
        """Return what explains placements to train on, and others held out beside them."""
        names = [m.name for m in training] if held_out else []
        measurements = [*training, *held_out]
        key = (len(names), *map(id, measurements))
        if key not in self.surveys:
            options = self.options
            followed = self.followed(measurements)
            lengths = [k for k in followed if _is_between(k, measurements)]
            given = Given(
                lengths, options.deviation, options.load, _mender(options), names
            )
            survey = inspect_all(
                self.robot,
                measurements,
                given,
                zeros=bool(options.zeros),
                repeatability=repeatability_of(self.robot, options.repeatability_mm),
            )
            self.surveys[key] = measurements, survey
        return self.surveys[key][1]

    def followed(
        self, measurements: Sequence[Measurement]
    ) -> tuple[KnownDistance, ...]:
        """Return known distances by the first parts that hold their sockets, of what was split."""
        part: dict[tuple[str, int], tuple[str, int]] = {}
        for name, socket in chain.from_iterable(m.labels for m in measurements):
            part.setdefault((whole_name(name), socket), (name, socket))
        return tuple(
            replace(
                k, first=part.get(k.first, k.first), second=part.get(k.second, k.second)
            )
            for k in self.lengths
        )

    def set_right(
        self,
        measurements: Sequence[Measurement],
        reference: Sequence[Measurement] = (),
        minimum: int = LEAST,
        actions: Collection[Action] = ALL_ACTIONS,
    ) -> tuple[list[Measurement], list[Diagnostic]]:
        """Return recordings with all set right that can be, and what was done.

        Args:
            measurements: The placements; those held out are never looked at with those to train on
                before the latter are set right.
            reference: Placements that are set right already.
            minimum: Fewest samples in a socket of a part that is kept.
            actions: What may be done.
        """
        placements = list(measurements)
        done = list[Diagnostic]()
        for _ in range(ROUNDS if placements else 0):
            survey = (
                self.look(reference, placements) if reference else self.look(placements)
            )
            inspections = survey.placements[len(reference) :]
            alone = [self.look([m]).placements[0] for m in placements if survey.unclear]
            if any(inspection.corrections for inspection in alone):
                inspections = alone
            elif len(reference) == 1:
                inspections = _beside_one(survey.placements[0], inspections)
            placements, diagnostics = by_findings(
                placements, inspections, minimum, actions
            )
            if not diagnostics:
                break
            done += diagnostics
        return placements, done


def _is_between(length: KnownDistance, measurements: Sequence[Measurement]) -> bool:
    """Tell whether both ends of a distance are sockets of some placements."""
    labels = chain.from_iterable(m.labels for m in measurements)
    return {length.first, length.second} <= set(labels)


def _mender(options: SolveOptions) -> str:
    """Return what would set recordings right, in the words of advice."""
    if actions_of(options) == ALL_ACTIONS:
        return MENDER
    return (
        f"{MENDER} --method auto"
        if options.method == "paper"
        else f"{MENDER} by default"
    )


def _beside_one(
    reference: Inspection, held_out: Sequence[Inspection]
) -> list[Inspection]:
    """Return what was seen of placements held out, with what sets apart the one trained on.

    Which of two differs cannot be told: the model has the ball and the zeros of the latter.
    """
    differences = [c for c in reference.corrections if c.apart is not None]
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
    corrections = [list(inspection.corrections) for inspection in inspections]
    pairs = zip(placements, corrections, strict=True)
    if not any(
        len(m.sockets) > 1 and "merge" not in {c.action for c in cs} for m, cs in pairs
    ):
        actions = {action for action in actions if action != "merge"}
    for corrections_here in corrections:
        allowed = [c for c in corrections_here if c.action in actions]
        steps = [c for c in allowed if c.action != "follow"]
        # A drift of what remains is looked for afterwards.
        corrections_here[:] = steps or allowed
    return corrected(placements, corrections, least)


def checked(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> tuple[tuple[Measurement, ...], list[MukcaError]]:
    """Return checked placements, and why others are left out, too short or not readable."""
    sockets = 1 if options.method == "auto" else 2
    measured = list[Measurement]()
    errors = list[MukcaError]()
    for placement in without(placements, options.leave_out):
        try:
            m = measure(
                placement, robot, options.distance, sockets=sockets, load=options.load
            )
            measured.append(spaced(m, placement.name, options.located))
        except (TooFewError, RecordingError) as error:
            if options.as_recorded:
                raise
            errors.append(error)
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
        measure(p, robot, options.distance, sockets=1, load=options.load)
        for p in placements
    ]
    problem = CalibrationProblem(
        robot, (), options.load, options=options, test=measured
    )
    # a placement alone does not say what has unknowns of its own in it
    mending, done = mended(problem, barred=["set apart", "follow"])
    return [m.placement for m in mending.test], done

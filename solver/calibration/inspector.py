"""An inspector of recordings: what explains them, and what sets them right."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from ..assessment import repeatability_of
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
)
from ..identification.data import KnownDistance, Measurement, whole_name
from ..identification.robot import Robot
from ..results import Diagnostic
from .options import SolveOptions

ROUNDS = 3
"""Times that recordings are looked at and set right at most."""


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
            self.surveys[key] = measurements, self._survey(measurements, names)
        return self.surveys[key][1]

    def _survey(
        self, measurements: Sequence[Measurement], trained: Sequence[str]
    ) -> Survey:
        """Return what explains placements; ``trained`` names some, where others are held out."""
        options = self.options
        followed = self.followed(measurements)
        lengths = [length for length in followed if is_between(length, measurements)]
        mender = _mender(options)
        given = Given(lengths, options.deviation, options.load, mender, trained)
        return inspect_all(
            self.robot,
            measurements,
            given,
            zeros=bool(options.zeros),
            repeatability=repeatability_of(self.robot, options.repeatability_mm),
        )

    def followed(
        self, measurements: Sequence[Measurement]
    ) -> tuple[KnownDistance, ...]:
        """Return known distances by the first parts that hold their sockets, of what was split."""
        part: dict[tuple[str, int], tuple[str, int]] = {}
        for name, socket in chain.from_iterable(m.labels for m in measurements):
            part.setdefault((whole_name(name), socket), (name, socket))
        lengths: list[KnownDistance] = []
        for length in self.lengths:
            first = part.get(length.first, length.first)
            second = part.get(length.second, length.second)
            lengths.append(replace(length, first=first, second=second))
        return tuple(lengths)

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
            groups = (reference, placements) if reference else (placements,)
            survey = self.look(*groups)
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


def is_between(length: KnownDistance, measurements: Sequence[Measurement]) -> bool:
    """Tell whether both ends of a distance are sockets of some placements."""
    labels = chain.from_iterable(m.labels for m in measurements)
    return {length.first, length.second} <= set(labels)


def _mender(options: SolveOptions) -> str:
    """Return what would set recordings right, in the words of advice."""
    if actions_of(options) == ALL_ACTIONS:
        return MENDER
    if options.method == "paper":
        return f"{MENDER} --method auto"
    return f"{MENDER} by default"


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
    sound = [
        len(m.sockets) > 1 and all(c.action != "merge" for c in inspection.corrections)
        for m, inspection in zip(placements, inspections, strict=True)
    ]
    if not any(sound):
        actions = {action for action in actions if action != "merge"}
    corrections = [list(inspection.corrections) for inspection in inspections]
    for corrections_here in corrections:
        allowed = [c for c in corrections_here if c.action in actions]
        steps = [c for c in allowed if c.action != "follow"]
        # A drift of what remains is looked for afterwards.
        corrections_here[:] = steps or allowed
    return corrected(placements, corrections, least)


def actions_of(options: SolveOptions) -> tuple[Action, ...]:
    """Return what may be done to set recordings right; by Eq. (5) nothing, as in the paper."""
    if options.as_recorded or options.method == "paper":
        return ("split",) if options.split_moved else ()
    return ALL_ACTIONS

"""An inspector of recordings: what explains them, and what sets them right."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

from ..assessment import LEAST_HELD_OUT, repeatability_of
from ..diagnostics import (
    LEAST,
    MENDER,
    Correction,
    Given,
    Inspection,
    Survey,
    corrected,
    inspect_all,
)
from ..identification.data import KnownDistance, Measurement
from ..identification.effects import GAIN
from ..identification.robot import Robot
from ..results import Diagnostic
from .options import SolveOptions

ROUNDS = 3
"""Times that recordings are looked at and set right at most."""
WITH_GAIN = "mukca command corrects this, calibrated.urdf cannot"
"""Advice on a joint's gain; added to that on one that would be an error."""


@dataclass(frozen=True)
class Inspector:
    """Looks at recordings, and sets them right."""

    robot: Robot
    options: SolveOptions
    lengths: Sequence[KnownDistance]
    """Known distances."""
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
            survey = self._survey(measurements, names)
            if survey.unclear and len(measurements) > 1:
                survey = survey.told_by(
                    [self._survey([m], names) for m in measurements]
                )
            self.surveys[key] = measurements, survey
        return self.surveys[key][1]

    def _survey(
        self, measurements: Sequence[Measurement], trained: Sequence[str]
    ) -> Survey:
        """Return what explains placements; ``trained`` names some, where others are held out."""
        options = self.options
        lengths = [
            length for length in self.lengths if is_between(length, measurements)
        ]
        mender = MENDER
        if not self.sets_right:
            by = "--method auto" if options.method == "paper" else "by default"
            mender = f"{MENDER} {by}"
        given = Given(
            lengths,
            options.deviation,
            options.load,
            mender,
            trained,
            weighs=self.sets_right,
        )
        return inspect_all(
            self.robot,
            measurements,
            given,
            zeros=bool(options.zeros),
            repeatability=repeatability_of(self.robot, options.repeatability_mm),
        )

    def gains(self, training: Sequence[Measurement]) -> tuple[str, ...]:
        """Return the coefficients of joints' gains that the fit is to have."""
        joints = self.look(training).gains if self.sets_right else ()
        return tuple(GAIN.coefficient_names(sorted(set(joints))))

    @property
    def sets_right(self) -> bool:
        """True unless recordings stay as they are; by Eq. (5) they do, as in the paper."""
        return not self.options.as_recorded and self.options.method != "paper"

    def set_right(
        self,
        measurements: Sequence[Measurement],
        reference: Sequence[Measurement] = (),
        *,
        held_out: bool = False,
    ) -> tuple[list[Measurement], list[Diagnostic]]:
        """Return recordings with all set right that can be, and what was done.

        Args:
            measurements: The placements.
            reference: Placements that are set right already.
            held_out: Few samples of a socket do not count in errors.
        """
        placements = list(measurements)
        minimum = LEAST_HELD_OUT if held_out else LEAST
        done = list[Diagnostic]()
        for _ in range(ROUNDS if placements and self.sets_right else 0):
            groups = (reference, placements) if reference else (placements,)
            survey = self.look(*groups)
            inspections = survey.placements[len(reference) :]
            alone = [self.look([m]).placements[0] for m in placements if survey.unclear]
            if any(inspection.corrections for inspection in alone):
                inspections = alone
            placements, diagnostics = _by_findings(placements, inspections, minimum)
            if not diagnostics:
                break
            done += diagnostics
        return placements, done


def is_between(length: KnownDistance, measurements: Sequence[Measurement]) -> bool:
    """Tell whether both ends of a distance are sockets of some placements."""
    labels = chain.from_iterable(m.labels for m in measurements)
    return {length.first, length.second} <= set(labels)


def _by_findings(
    placements: Sequence[Measurement],
    inspections: Sequence[Inspection],
    least: int,
) -> tuple[list[Measurement], list[Diagnostic]]:
    """Return placements set right by what was seen of each, and what was done.

    Two sockets are taken for one only where another placement says how large the arm is.
    """
    sound = [
        len(m.sockets) > 1 and all(c.action != "merge" for c in inspection.corrections)
        for m, inspection in zip(placements, inspections, strict=True)
    ]
    corrections: list[list[Correction]] = []
    for inspection in inspections:
        allowed = [
            c for c in inspection.corrections if any(sound) or c.action != "merge"
        ]
        corrections.append(allowed)
    return corrected(placements, corrections, least)


def with_gain(survey: Survey) -> Survey:
    """Return what was seen of joints whose gain the fit has: how well, the errors say."""
    shared = list(survey.shared)
    for i, diagnostic in enumerate(shared):
        if diagnostic.code == GAIN.name:
            is_error = diagnostic.level == "error"
            advice = f"{diagnostic.advice}; {WITH_GAIN}" if is_error else WITH_GAIN
            shared[i] = replace(diagnostic, level="warning", advice=advice)
    return replace(survey, shared=tuple(shared))

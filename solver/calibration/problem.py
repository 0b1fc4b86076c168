"""The problem of a calibration: a robot, its checked recordings, and the options."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import results
from ..diagnostics import SIZE_BY_DISTANCE, Survey, by_fit, where_of
from ..identification.data import Measurement, RobotRecordings
from ..identification.model import set_apart
from ..identification.selection import FoundMovement
from .options import SolveOptions

STEADY = "screw the base down, let the arm warm up, and record it again"
NOTHING_SEEN = Survey((), ())
"""Of no placements."""


@dataclass(frozen=True, kw_only=True)
class CalibrationProblem(RobotRecordings):
    """A robot, checked recordings of it to train on, and the options of their fit."""

    options: SolveOptions
    test: Sequence[Measurement] = ()
    warnings: tuple[str, ...] = ()
    checks: tuple[results.Diagnostic, ...] = ()
    """Diagnostics of the recordings, from before the fit."""
    survey: Survey = NOTHING_SEEN
    """Findings on the placements, one by one and together, once all was set right."""
    next_placement: results.NextPlacement | None = None
    """None where an instrument measured all samples."""

    @property
    def placements(self) -> list[tuple[results.Role, Measurement]]:
        """All placements, those to train on first."""
        return [
            *(("train", m) for m in self.measurements),
            *(("test", m) for m in self.test),
        ]

    def sized(self, scale: results.Scale) -> "CalibrationProblem":
        """Return the problem whose explanations of the arm's size have that of a fit.

        Where other lengths than those between a base's sockets are known, a fit follows these, and
        where something else is more probable, it may be why the fit made the arm larger.
        """
        survey = self.survey
        by_bases_alone = all(m.kind == "sockets" for m in self.measurements)
        if self.options.distances or self.options.located or not by_bases_alone:
            return self
        if all(h.name not in SIZE_BY_DISTANCE for h in survey.hypotheses[:1]):
            return self
        hypotheses = tuple(by_fit(h, scale.value) for h in survey.hypotheses)
        pairs = zip(survey.hypotheses, hypotheses, strict=True)
        texts = {before.text: after.text for before, after in pairs}
        checks = [replace(c, text=texts.get(c.text, c.text)) for c in self.checks]
        sized = replace(survey, hypotheses=hypotheses)
        return replace(self, checks=tuple(checks), survey=sized)

    def at_rest(
        self,
        shifts: np.ndarray | None,
        movements: Iterable[FoundMovement],
        calibrated: results.CalibratedRobot,
    ) -> "CalibrationProblem":
        """Return the recordings with the movements of their places, row by row, as diagnostics.

        Where a placement that is held out differs throughout follows from its own samples.
        """
        checks = list(self.checks)
        by_name = {m.name: m for m in self.measurements}
        for movement in movements:
            measured = by_name[movement.placement]
            code = "movement" if movement.kept else "moved"
            text = _movement_text(measured, movement)
            where = where_of([measured])
            checks.append(results.Diagnostic("warning", code, where, text, STEADY))
        train = self.measurements
        if shifts is not None:  # orientations come last
            ends = np.cumsum([len(m.positions) for m in train])
            parts = zip(train, np.split(shifts, ends), strict=False)
            train = [replace(m, moved=shift) for m, shift in parts]
        test = [_set_apart(m, calibrated) for m in self.test]
        return replace(
            self, checks=tuple(checks), measurements=tuple(train), test=tuple(test)
        )


def _set_apart(
    measured: Measurement, calibrated: results.CalibratedRobot
) -> Measurement:
    """Return a held-out placement with what is otherwise in it."""
    if not measured.apart:
        return measured
    balls = calibrated.predict(measured)
    return replace(measured, moved=set_apart(calibrated.robot, measured, balls))


def _movement_text(measured: Measurement, movement: FoundMovement) -> str:
    """Return a movement in words, a step with the first sample after it."""
    if movement.rank is None:
        return movement.text
    in_time = measured.order[np.argsort(measured.clock("time"), kind="stable")]
    first = measured.placement.samples[int(in_time[movement.rank])]
    return movement.text.format(first=first.named)

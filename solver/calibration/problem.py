"""The problem of a calibration: a robot, its checked recordings, and the options."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import fixed
from .. import results
from ..diagnostics import SIZE_BY_DISTANCE, Survey, by_fit, where_of
from ..identification.data import Measurement, Observations, RobotRecordings
from ..identification.inference import FitPosterior
from ..identification.model import BALL, BASE, Difference
from .options import SolveOptions

WORDS = {
    "step": "its place moved by {}, {}",
    "drift": "its place drifted steadily by {}",
    "slow": "its place drifted to and fro by {}{}",
}
DIFFERENCE = "movement"
"""Code of what differs between places, for which the fit has an unknown."""
MENDED = "mend it, or calibrate by recordings from one side of it"
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

    def at_rest(self, fit: FitPosterior) -> "CalibrationProblem":
        """Return the recordings with what differs between places, row by row, and in words."""
        differences = fit.objective.differences
        shifts = fit.arm.moved
        if shifts is None:
            return self
        found = [self._told(fit, k) for k in range(len(differences))]
        ends = np.cumsum([len(m.positions) for m in self.measurements])
        # orientations come last
        parts = zip(self.measurements, np.split(shifts, ends), strict=False)
        train = tuple(replace(m, moved=shift) for m, shift in parts)
        return replace(self, checks=(*self.checks, *found), measurements=train)

    def _told(self, fit: FitPosterior, k: int) -> results.Diagnostic:
        """Return the k-th difference of a fit as a diagnostic."""
        difference = fit.objective.differences[k]
        name = difference.placements[0]
        measured = next(m for m in self.measurements if m.name == name)
        text = _in_words(fit, k)
        if difference.at:
            first = measured.placement.samples[int(difference.at)]
            text = text.format(first=first.named)
        advice = STEADY if difference.part == BASE else MENDED
        where = where_of([measured])
        return results.Diagnostic("warning", DIFFERENCE, where, text, advice)


def _in_words(posterior: FitPosterior, k: int) -> str:
    """Return the k-th difference of a fit in words."""
    objective, data = posterior.objective, posterior.data
    difference = objective.differences[k]
    begin = sum(objective.sizes[:k])
    of_difference = slice(begin, begin + objective.sizes[k])
    shifts = objective.by_differences[:, :, of_difference]
    size = objective.model.size
    members = slice(size + begin, size + of_difference.stop)
    unknowns = posterior.state.x[members]
    variances = np.diag(posterior.whole[members, members])
    deviation = float(variances.max()) ** 0.5
    since = _since(difference, data)
    if difference.part == BASE:
        course = (shifts @ unknowns)[data.rows_of(difference.placements[0])]
        moved = float(np.linalg.norm(np.ptp(course, axis=0)))
        words = WORDS[difference.course].format(_millimetres(moved, deviation), since)
    elif difference.part == BALL:
        sizes = np.linalg.norm(unknowns.reshape(-1, 3), axis=1)
        amount = _millimetres(float(sizes.max()), deviation)
        words = f"the ball sits {amount} elsewhere on its flange {since}"
    else:
        zero, error = np.rad2deg([unknowns[0], deviation]).tolist()
        amount = f"{fixed(zero, 2, '+')} +- {fixed(error, 2)} deg"
        words = f"{difference.part} reads {amount} more {since}"
    return f"{words}; the fit has an unknown for that"


def _millimetres(size: float, deviation: float) -> str:
    """Return a size [m] in words."""
    return f"{fixed(1e3 * size, 2)} +- {fixed(1e3 * deviation, 2)} mm"


def _since(difference: Difference, data: Observations) -> str:
    """Return in words where a step is; {{first}} stands for a sample."""
    first, last = difference.placements[0], difference.placements[-1]
    if difference.course == "slow":
        return ", with temperature" * (difference.clock == "temperature")
    if difference.course == "each":
        return "from placement to placement"
    if difference.at:
        return "from {first} on"
    if last == data.placements[-1]:
        return f"from {first} on"
    return f"in {first}" if first == last else f"from {first} to {last}"

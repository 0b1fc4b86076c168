"""Sufficiency of samples while recording: the verdict of ``mukca solve``, and when to stop."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...errors import MukcaError
from ...recorder import Placement, Sample
from ...recorder.session import Advice
from ...solver.assessment import LEAST_SAMPLES
from ...solver.calibration import calibrate
from ...solver.diagnostics import size_level
from ...solver.identification.data import RobotRecordings, measure, observe
from ...solver.identification.inference import Posterior, estimate
from ...solver.identification.model import ExtendedModel
from ...solver.studies import scale

WORKSPACE, NEAR = "predicted_distance", "predicted_distance_near"
"""Rows of a verdict on distances in the workspace, and near the recorded places."""


@dataclass(frozen=True)
class Sufficiency:
    """The part of a verdict that rests on how much was recorded."""

    predicted: float | None
    """Upper end of the 68 % interval of the error of distances in the workspace [m]; None where
    ``mukca solve`` refuses the samples."""
    error: float | None
    """That error itself [m]."""
    asked: float | None
    """The limit on it [m]; None where nothing is known of the arm's repeatability."""
    enough: bool
    """True where no row fails, and none says that the data are not enough."""
    sized: bool
    """True where the arm's size would still be believed if it were off by a deviation more."""
    fails: str
    """The reason of a refusal, or the first of a FAIL; empty where there is none."""


class End(NamedTuple):
    """End of a placement."""

    enough: bool
    """True if the samples are a calibration."""
    near_only: bool
    """True if that is so near the recorded places, and not yet in the whole workspace."""
    exhausted: bool
    """True if they are not, and more of them at this placement would hardly help."""


class StoppingRule:
    """Rule that does not take back that samples are enough while ``mukca solve`` agrees.

    ``near_suffices`` is False where the operator gave a goal, which stands.
    """

    def __init__(self, *, near_suffices: bool) -> None:
        self._near_suffices = near_suffices
        self._enough = False

    def end(
        self, solved: Sufficiency | None, *, exhausted: bool, reaches_goal: bool
    ) -> End:
        """Return the end by a verdict on all samples so far, None where a fault is seen.

        The first time, samples are enough by a margin, so that further ones do not take it back.
        Near the recorded places they are enough if no more can be had here, or once they were:
        more samples tell more of the noise, so that an error can be predicted larger.
        """
        passes = solved is not None and solved.enough and (solved.sized or self._enough)
        allows_near = self._near_suffices and (exhausted or self._enough)
        self._enough = passes and (reaches_goal or allows_near)
        return End(
            enough=self._enough,
            near_only=self._enough and not reaches_goal,
            exhausted=exhausted and not self._enough,
        )


def sufficiency_of(
    model: ExtendedModel, placements: Sequence[Placement], *, zeros: bool
) -> Sufficiency | None:
    """Return the verdict on placements, of which the last goes on; None without a prediction."""
    try:
        solved = calibrate(
            model.robot, _whole(placements), zeros=zeros or None, no_proof=True
        )
    except MukcaError as error:
        return Sufficiency(
            None, None, None, enough=False, sized=False, fails=str(error)
        )
    verdict = solved.verdict
    row = next((row for row in verdict.limits if row.name == WORKSPACE), None)
    if row is None or row.found is None:
        return None
    passes_near = verdict.status_of(NEAR) == "pass"
    failing = [
        r
        for r in (*verdict.limits, *verdict.reasons)
        if r.status in ("fail", "not enough")
        and not (passes_near and r.name == WORKSPACE)
    ]
    counts = np.bincount(placements[-1].sockets)[:2]
    size = solved.document.scale
    deviation = size.deviation or 0.0 if size else 0.0
    return Sufficiency(
        predicted=row.found if row.interval is None else row.interval.high,
        error=row.found,
        asked=row.limit,
        enough=bool(verdict.use and not failing and counts.min() >= LEAST_SAMPLES),
        sized=not size or size_level(abs(size.value) + deviation, deviation) is None,
        fails=verdict.text.partition(". ")[0] if verdict.status == "fail" else "",
    )


def rigid_fit(
    model: ExtendedModel, placements: Sequence[Placement]
) -> Posterior | None:
    """Return a fit of the geometry, the last placement first; None where it does not converge."""
    try:
        *parts, current = _whole(placements)
        measured = [measure(part, model.robot) for part in (current, *parts)]
        return estimate(model, observe(RobotRecordings(model.robot, measured))).arm
    except (MukcaError, np.linalg.LinAlgError):
        return None


def with_fit(advice: Advice, posterior: Posterior, samples: Sequence[Sample]) -> Advice:
    """Return advice with the errors, scale and distance of a fit to the samples."""
    # The residuals are in the order of sockets.
    order = np.argsort([sample.socket for sample in samples], kind="stable")
    errors = np.linalg.norm(posterior.residuals[: len(order)], axis=1)
    return replace(
        advice,
        fitted=True,
        last_error=float(errors[order.argmax()]),
        mean_error=float(errors.mean()),
        scale=scale(posterior).value,
        distance=float(np.linalg.norm(posterior.centres[1] - posterior.centres[0])),
    )


def _whole(placements: Sequence[Placement]) -> list[Placement]:
    """Return the last placement, and those before with two sockets, none with a single sample."""
    *parts, current = placements
    whole: list[Placement] = []
    for part in parts:
        counts = np.bincount(part.sockets)
        if np.count_nonzero(counts) > 1 and 1 not in counts:
            whole.append(part)
    return [*whole, current]

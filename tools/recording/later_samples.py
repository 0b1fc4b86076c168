"""Samples that are recorded later, held against a calibration."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial as partial_of
from typing import Any

from ...recorder import Placement
from ...solver import calibration, partial, results


def judged(
    calibrated: calibration.Calibration,
    placements: Sequence[Placement],
    settings: calibration.SolveOptions,
    **options: Any,
) -> tuple[partial.Validity, list[results.Diagnostic]]:
    """Return what changed since a calibration, and what was set right of the samples for that.

    They are set right where they do not pass as recorded. Options are those of ``what_changed``.
    """
    allowed_mm = settings.validated().repeatability_mm
    judge = partial_of(
        partial.what_changed,
        calibrated,
        distance=settings.distance,
        repeatability=None if allowed_mm is None else 1e-3 * allowed_mm,
        **options,
    )
    validity = judge(placements)
    if validity.verdict.status == "pass" or settings.as_recorded:
        return validity, []
    load = calibrated.load
    settings = replace(settings, payload=load.payload, gravity=load.gravity)
    robot = calibrated.robot
    mending, done = calibration.placements_set_right(robot, placements, settings)
    return judge(mending) if done else validity, done

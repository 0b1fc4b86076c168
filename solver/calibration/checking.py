"""Placements checked one by one, and those that are left out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import MukcaError
from ...recorder import Placement, RecordingError, Sample
from ..identification.data import Measurement, TooFewError, measure, spaced
from ..identification.robot import Robot
from ..tables import without
from .options import SolveOptions


def checked(
    robot: Robot, placements: Sequence[Placement], options: SolveOptions
) -> tuple[tuple[Measurement, ...], list[MukcaError]]:
    """Return checked placements, and why others are left out, too short or not readable."""
    sockets = 1 if options.method == "auto" else 2
    measured = list[Measurement]()
    errors = list[MukcaError]()
    for recorded in without(placements, options.leave_out):
        placement = at_scale(recorded, options.scale)
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


def at_scale(placement: Placement, scale: float | None) -> Placement:
    """Return a placement whose measured points are divided by an instrument's scale."""
    if placement.kind != "points" or scale is None:
        return placement
    samples = list[Sample]()
    for sample in placement.samples:
        x, y, z = np.divide(sample.point or np.nan, scale).tolist()
        samples.append(replace(sample, point=(x, y, z)))
    return replace(placement, samples=tuple(samples))

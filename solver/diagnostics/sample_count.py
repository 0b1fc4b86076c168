"""How much there is in recordings, what a calibration on them would know, and what is missing."""

from collections.abc import Sequence

import numpy as np

from ..bayes.inference import estimate
from ..bayes.model import extend
from ..bayes.model.effects import JOINT_OFFSET
from ..bayes.results import workspace_deviation
from ..data import CALIPER_DEVIATION, KnownDistance, KnownError, Load, Measurement, observe
from ..paper import NotConverged
from ..robot import Parameter, Robot
from .diagnostic import Diagnostic, where_of
from .distances import named

FEWEST, ADVISED = 10, 30
"""Samples in a socket below which it tells little, and that are advised."""


def few_findings(measured: Measurement) -> list[Diagnostic]:
    """Return sockets of a placement with too few samples."""
    return [
        Diagnostic(
            "warning",
            "few",
            where_of([measured]),
            f"{count} samples in socket {socket}",
            f"record {ADVISED - count} more: {ADVISED} are advised, {FEWEST} are the least",
        )
        for socket, count in zip(measured.sockets, measured.counts, strict=True)
        if count < FEWEST
    ]


def single_placement_diagnostics(
    measurements: Sequence[Measurement], known: Sequence[KnownDistance] = ()
) -> list[Diagnostic]:
    """Return placements with one socket, which no known distance ties to a length."""
    whole = named(measurements, known)
    tied = {name for k in whole for name, _ in (k.first, k.second)}
    return [
        Diagnostic(
            "error",
            "lone",
            where_of([m]),
            f"only socket {m.sockets[0]} has samples, so solve refuses it",
            "record the other socket too, or tie it by a known distance, solve --known",
        )
        for m in measurements
        if m.kind == "sockets" and not m.has_distance and m.name not in tied
    ]


def predicted_error(
    robot: Robot,
    parameters: Sequence[Parameter],
    measurements: Sequence[Measurement],
    load: Load | None = None,
    known: Sequence[KnownDistance] = (),
    deviation: float = CALIPER_DEVIATION,
    *,
    zeros: bool = False,
) -> float | None:
    """Return the error of distances in the workspace that a calibration would have [m].

    The median over random poses, one standard deviation; None where it cannot be told.
    """
    load = load or Load()
    try:
        data = observe(measurements, robot, known=known, deviation=deviation, load=load)
        posterior = estimate(extend(robot, parameters, (JOINT_OFFSET.name,) if zeros else ()), data)
    except (KnownError, NotConverged):
        return None
    median = workspace_deviation(posterior, load)[0]
    return median if np.isfinite(median) else None

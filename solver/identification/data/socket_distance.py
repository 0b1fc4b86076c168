"""The distance between a placement's sockets: as given, as recorded, or assumed."""

import math
from typing import NamedTuple

from ....recorder import DEFAULT_DISTANCE, Placement
from .lengths import Readings, agreed_length, agreeing, readings_of
from .measurements import MeasurementError

_SHORTEST_BASE, _LONGEST_BASE = 5e-3, 1.0
"""Balls have a diameter, and arms a reach [m]."""


class StatedLength(NamedTuple):
    """A distance between two sockets, and what it rests on."""

    distance: float
    """[m]."""
    source: str
    """``given`` by the user, the ``recording``, or nothing but the ``default``."""
    readings: int
    """Number of readings that agree on it."""


def stated_length(
    placement: Placement,
    distance: Readings | None,
    warnings: list[str],
) -> StatedLength:
    """Return the distance of a placement's sockets; one given counts more than one recorded."""
    recorded = None if placement.distance_assumed else placement.distance
    typed = [check_distance(reading) for reading in readings_of(distance)]
    readings = typed.copy()
    if recorded is not None:
        readings += [d for d in placement.readings or (recorded,) if d not in typed]
    if typed:
        source = "given"
        length = agreed_length(typed)
        if recorded not in (None, length):
            warnings.append(
                f"{placement.name}: distance {length:.7g} m as given, not the recording's "
                f"{placement.distance} m"
            )
    elif recorded is not None:
        source = "recording"
        length = check_distance(recorded, f"{placement.where}: ")
    else:
        source = "default"
        length = check_distance(placement.distance or DEFAULT_DISTANCE)
    return StatedLength(length, source, agreeing(length, readings))


def check_distance(distance: float, where: str = "") -> float:
    """Return a distance between sockets if it is possible [m]; messages begin with ``where``."""
    try:
        metres = float(distance)
    except (TypeError, ValueError):
        metres = math.inf
    if not metres > 0:
        raise MeasurementError(
            f"{where}distance {distance}: the distance between the sockets' centres is a positive "
            "number of metres, for example 0.05"
        )
    if not _SHORTEST_BASE <= metres <= _LONGEST_BASE:
        advice = ", for example 0.05"
        if _SHORTEST_BASE <= metres / 1e3 <= _LONGEST_BASE:
            advice = f"; did you mean {metres / 1e3:g}?"
        raise MeasurementError(
            f"{where}distance {distance!r}: metres are expected{advice}"
        )
    return metres

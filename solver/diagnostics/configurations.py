"""Checks that need no fit: few or like samples, joints that stood still, and known distances."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice, product
from typing import Literal

import numpy as np

from ..identification.data import (
    CALIPER_DEVIATION,
    SAMPLES_ADVISED,
    KnownDistance,
    Measurement,
    find_socket,
)
from ..identification.robot import Robot
from ..results import Diagnostic, Hypothesis
from .hypotheses import ARMS, KINDS, SIZE_BY_DISTANCE, sockets_by_share

SUSPECT = 0.003
"""Share by which an arm may differ in size from its model; more is doubtful."""
WRONG = 0.01
"""The same; more is a mistake."""
DEVIATIONS = 3
GROSS = 0.03
"""Share of readings that are grossly wrong."""
GROSS_SIZE = 5e-4
"""By how much such a reading is wrong [m]."""
DOUBTED = 0.05
"""Probability of a gross error above which a second reading is asked for."""
NEAR = np.deg2rad(1.0)
"""Two configurations closer than this on every joint are nearly the same."""
LISTED = 5
"""Near-duplicates of a socket that are named one by one."""
STILL = np.deg2rad(5.0)
"""A joint that moved less than this in a placement tells hardly anything."""
EVERYWHERE = "all placements"
"""Place of a diagnostic that concerns several placements."""
FEWEST = 10
"""Samples in a socket below which it tells little."""


def size_level(
    value: float,
    deviation: float | None,
    distance: float = 0.0,
    readings: int = 1,
) -> Literal["error", "unknown", "warning"] | None:
    """Return how doubtful an arm's size is, larger by a share ``value``; None for not at all.

    Arms scatter by 0.2 %: off by more than three deviations of that and of what is known of it, one
    has most likely a wrong distance. Short of that, a distance between sockets [m] that was read
    twice is right, and of one that was read once it is asked how probable a gross error is.
    """
    size, sigma = abs(value), deviation or 0.0
    allowed = DEVIATIONS * math.hypot(sigma, ARMS)
    if size > allowed:
        return "error"
    if distance and readings > 1:
        return None
    if size > WRONG:
        return "unknown"
    if distance:
        return "warning" if gross_error(value, sigma, distance) > DOUBTED else None
    return "warning" if size > max(SUSPECT, DEVIATIONS * sigma) else None


def gross_error(
    value: float,
    deviation: float,
    distance: float,
) -> float:
    """Return how probable a gross error of a distance that was read once is.

    Args:
        value: By how large a share the arm came out larger than its model.
        deviation: How well the samples and a caliper tell that.
        distance: The reading [m].
    """
    measured = math.hypot(deviation, ARMS, CALIPER_DEVIATION / distance)
    gross = math.hypot(deviation, ARMS, GROSS_SIZE / distance)
    odds = GROSS / (1 - GROSS) * measured / gross
    odds *= math.exp(0.5 * value**2 * (measured**-2 - gross**-2))
    return odds / (1 + odds)


def named(
    measurements: Sequence[Measurement],
    lengths: Sequence[KnownDistance],
) -> list[KnownDistance]:
    """Return known distances with the whole names of their placements.

    Raises:
        KnownError: One names a socket that is not there.
    """
    labels = [*chain.from_iterable(m.labels for m in measurements)]
    resolved = list[KnownDistance]()
    for k in lengths:
        a, b = [labels[find_socket(labels, end)] for end in (k.first, k.second)]
        resolved.append(replace(k, first=a, second=b))
    return resolved


def of_placement(
    robot: Robot,
    measured: Measurement,
) -> Iterator[Diagnostic]:
    """Return what a placement by itself lacks: samples, other configurations, joints that moved."""
    where = where_of([measured])
    for words in measured.placement.kept_alarms:
        text = f"an alarm said while it was recorded: {words}"
        yield Diagnostic(
            "warning", "kept", where, text, "the operator kept the samples"
        )
    if measured.kind == "sockets":
        yield from _of_sockets(measured)
    travels = np.ptp(measured.positions, axis=0).tolist()
    for joint, travel in zip(robot.joint_names, travels, strict=True):
        if travel < STILL:
            motion = f"moved by {np.rad2deg(travel):.1f} deg only"
            text = (
                f"joint {joint!r} {'did not move at all' if travel < 1e-9 else motion}"
            )
            yield Diagnostic(
                "warning",
                "still",
                where,
                text,
                "its parameters stay near nominal: move every joint by 60 deg or more",
            )


def _of_sockets(measured: Measurement) -> Iterator[Diagnostic]:
    """Return sockets with few samples, and samples that are nearly the same."""
    where = where_of([measured])
    for socket, count in zip(measured.sockets, measured.counts, strict=True):
        if count < FEWEST:
            text = f"{count} samples in socket {socket}"
            advice = f"record {SAMPLES_ADVISED}; {FEWEST} are the least"
            yield Diagnostic("warning", "few", where, text, advice)
    for socket, rows in zip(measured.sockets, measured.by_socket, strict=True):
        samples = [s for s in measured.placement.samples if s.socket == socket]
        twins = near_duplicates(rows)
        addition = f", one of {len(twins)} such" if len(twins) > LISTED else ""
        for second, first in islice(twins.items(), LISTED):
            text = f"nearly the configuration of {samples[first].named}{addition}"
            advice = "it adds little: guide the arm to other configurations"
            yield Diagnostic(
                "warning", "duplicate", row_of(measured, socket, second), text, advice
            )


def near_duplicates(rows: np.ndarray) -> dict[int, int]:
    """Return each row that is nearly one before it, with the first such row; cells keep it fast."""
    widest = np.argsort(-np.ptp(rows, axis=0))[:3]
    places = rows[:, widest] / (2 * NEAR)
    cells = np.floor(places)
    sides = np.where(places - cells < 0.5, -1, 1)
    steps = np.array([*product((0, 1), repeat=len(widest))])
    neighbours = cells[:, None] + steps * sides[:, None]
    of_rows = [
        [tuple(cell) for cell in cells_of_row] for cells_of_row in neighbours.tolist()
    ]
    members: dict[tuple[float, ...], list[int]] = {}
    nearest: dict[int, int] = {}
    for i, row in enumerate(rows):
        beside = (members.get(cell, ()) for cell in of_rows[i])
        candidates = np.array(sorted(chain.from_iterable(beside)), dtype=np.int64)
        distances = np.abs(rows[candidates] - row).max(axis=1)
        close = np.flatnonzero(distances < NEAR)
        if len(close):
            nearest[i] = int(candidates[close[0]])
        else:
            members.setdefault(of_rows[i][0], []).append(i)
    return nearest


def single_socket_diagnostics(
    measurements: Sequence[Measurement],
    lengths: Sequence[KnownDistance] = (),
) -> list[Diagnostic]:
    """Return placements with one socket, which no known distance ties to a length.

    Beside one with two sockets they tell of the arm's shape alone.
    """
    ends = chain.from_iterable(
        (k.first, k.second) for k in named(measurements, lengths)
    )
    tied = {name for name, _ in ends}
    sized = {m.name for m in measurements if m.has_distance or m.name in tied}
    lone = [m for m in measurements if m.kind == "sockets" and m.name not in sized]
    level, code, use = "warning", "few", "it tells of the arm's shape, not of its size"
    if not sized:
        level, code, use = "error", "lone", "so solve refuses it"
    return [
        Diagnostic(
            level,
            code,
            where_of([m]),
            f"only socket {m.sockets[0]} has samples, {use}",
            "record the other socket too, or tie it by a known distance, solve --known",
        )
        for m in lone
    ]


def where_of(measurements: Sequence[Measurement]) -> str:
    """Return the name of some placements: the folder where it is one."""
    if len(measurements) > 1:
        return EVERYWHERE
    return str(measurements[0].placement.where)


def row_of(
    measured: Measurement,
    socket: int,
    sample: int,
) -> str:
    """Return file and line of a sample, or its name, by its index in its socket."""
    rows = [s for s in measured.placement.samples if s.socket == socket]
    return rows[sample].where or f"{measured.name} {rows[sample].named}"


def by_fit(
    hypothesis: Hypothesis,
    share: float,
) -> Hypothesis:
    """Return an explanation of the arm's size with the share by which a fit made it longer.

    One that explains no size, or that of an instrument's points, stays.
    """
    parameters = hypothesis.parameters
    if hypothesis.name not in SIZE_BY_DISTANCE or "likely" not in parameters:
        return hypothesis
    given = parameters["given"]
    assert isinstance(given, float)
    sized = {**parameters, **sockets_by_share(share, given)}
    kind = next(kind for kind in KINDS if kind.name == hypothesis.name)
    return replace(hypothesis, parameters=sized, text=kind.text(sized))

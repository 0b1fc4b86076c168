"""Tables of sockets against the nominal arm: exchanged or mirrored, one fits better."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..identification.data import Measurement, SocketAt, is_called, kabsch
from ..identification.robot import BallModel, Robot
from ..results import Diagnostic
from .fit import CalibrationProblem

LEAST = 4
"""Sockets of a frame of which fewer lie on one plane."""
WORSE, FAR = 3.0, 5e-3
"""A table is wrong that leaves so many times as much as another reading of it, and more [m]."""
ADVICE = "mend the table, or say it as it is: the fit keeps to these coordinates"


def tables_of_sockets(problem: CalibrationProblem) -> CalibrationProblem:
    """Return recordings with an error on each table that another reading of it fits better.

    The nominal arm has the sockets to some millimetres, wherever the table's frame lies.
    """
    findings = tuple(_findings(problem))
    return replace(problem, checks=(*problem.checks, *findings))


def _findings(problem: CalibrationProblem) -> Iterator[Diagnostic]:
    by_frame: dict[str, list[SocketAt]] = {}
    for socket in problem.options.located:
        by_frame.setdefault(socket.frame, []).append(socket)
    placements = [measured for _, measured in problem.placements]
    seats = _nominal_seats(problem.robot, placements)
    for frame, sockets in by_frame.items():
        pairs = [(s.coordinates, seats[k]) for s in sockets if (k := _key(s, seats))]
        if len(pairs) < LEAST or len(pairs) != len(sockets):
            continue
        table, arm = map(np.array, zip(*pairs, strict=True))
        errors = {"": _error(table, arm)}
        exchanged = _exchanged(sockets)
        if exchanged:
            errors["its sockets 0 and 1 are exchanged"] = _error(table[exchanged], arm)
        errors["an axis points the other way"] = _error(table, arm, mirrored=True)
        reading = min(errors, key=errors.__getitem__)
        least, as_given = errors[reading], errors[""]
        if as_given > max(WORSE * least, FAR):
            millimetres = f"{1e3 * least:.1f} mm for {1e3 * as_given:.1f}"
            words = (
                f"the samples fit this table of sockets if {reading} ({millimetres})"
            )
            yield Diagnostic("error", "frame", f"frame {frame}", words, ADVICE)


Key = tuple[str, int]


def _nominal_seats(
    robot: Robot, placements: Sequence[Measurement]
) -> dict[Key, np.ndarray]:
    """Return where the nominal arm has each socket, by placement and number, shape (3,) [m]."""
    ball = BallModel(robot, [])
    seats: dict[Key, np.ndarray] = {}
    for measured in placements:
        placement = measured.placement
        points = ball.points(np.zeros(0), placement.positions)
        for number in measured.sockets:
            in_socket = points[placement.sockets == number]
            seats[measured.name, number] = np.median(in_socket, axis=0)
    return seats


def _key(socket: SocketAt, seats: dict[Key, np.ndarray]) -> Key | None:
    """Return the placement and number of a socket of a table; None where none was recorded."""
    name, number = socket.socket
    keys = (key for key in seats if key[1] == number and is_called(key[0], name))
    return next(keys, None)


def _exchanged(sockets: Sequence[SocketAt]) -> list[int]:
    """Return where the other socket of each one's base stands; nothing where one lacks."""
    labels = [socket.socket for socket in sockets]
    others = [(name, 1 - number) for name, number in labels]
    return (
        [labels.index(other) for other in others] if set(others) <= set(labels) else []
    )


def _error(table: np.ndarray, arm: np.ndarray, *, mirrored: bool = False) -> float:
    """Return the root mean square distance that the best pose of a table leaves [m]."""
    errors = kabsch(table, arm, mirrored=mirrored).apply(table) - arm
    return float(np.linalg.norm(errors)) / len(arm) ** 0.5

"""Tables of sockets against the nominal arm: exchanged or mirrored, one fits better."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..identification.data import Measurement, SocketAt, is_called, kabsch
from ..identification.robot import BallModel, Robot
from ..results import Diagnostic, rms
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
    return replace(problem, checks=(*problem.checks, *_findings(problem)))


def _findings(problem: CalibrationProblem) -> Iterator[Diagnostic]:
    by_frame: dict[str, list[SocketAt]] = {}
    for socket in problem.options.located:
        by_frame.setdefault(socket.frame, []).append(socket)
    placements = [measured for _, measured in problem.placements]
    seats = _nominal_seats(problem.robot, placements)
    for frame, sockets in by_frame.items():
        keys = [key for socket in sockets for key in _keys(socket, seats)]
        if len(keys) < max(LEAST, len(sockets)):
            continue
        table = np.array([socket.coordinates for socket in sockets])
        arm = np.array([seats[key] for key in keys])
        as_given = _error(table, arm)
        errors = {
            words: _error(table[rows], arm) for words, rows in _exchanges(sockets)
        }
        errors["an axis points the other way"] = _error(table, arm, mirrored=True)
        reading = min(errors, key=errors.__getitem__)
        least = errors[reading]
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


def _keys(socket: SocketAt, seats: dict[Key, np.ndarray]) -> list[Key]:
    """Return the placement and number of a socket of a table; none where it was not recorded."""
    name, number = socket.socket
    return [key for key in seats if key[1] == number and is_called(key[0], name)][:1]


def _exchanges(sockets: Sequence[SocketAt]) -> Iterator[tuple[str, list[int]]]:
    """Yield exchanges of a table's rows in words, with the row that each takes the place of.

    That is of both sockets of all bases, of one, and of two bases as a whole.
    """
    labels = [socket.socket for socket in sockets]
    names = sorted({name for name, _ in labels})
    others = {(name, number): (name, 1 - number) for name, number in labels}
    exchanges = {"its sockets 0 and 1 are exchanged": others}
    for name in names:
        of_base = {key: other for key, other in others.items() if key[0] == name}
        exchanges[f"sockets 0 and 1 of {name} are exchanged in it"] = of_base
    for pair in combinations(names, 2):
        other = dict(zip(pair, reversed(pair), strict=True))
        of_bases = {(n, k): (other[n], k) for n, k in labels if n in pair}
        exchanges[f"{' and '.join(pair)} are exchanged in it"] = of_bases
    for words, exchange in exchanges.items():
        if set(exchange.values()) <= set(labels):
            yield words, [labels.index(exchange.get(label, label)) for label in labels]


def _error(table: np.ndarray, arm: np.ndarray, *, mirrored: bool = False) -> float:
    """Return the root mean square distance that the best pose of a table leaves [m]."""
    errors = kabsch(table, arm, mirrored=mirrored).apply(table) - arm
    return rms(np.linalg.norm(errors, axis=1))

"""Known distances between sockets, and known coordinates of sockets in a frame.

A user names sockets and frames; a fit has their indices, ``Known[int]`` and ``Located[int, int]``.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from ...errors import MukcaError
from .metrics import CALIPER_DEVIATION

SEAT_DEVIATION = 1e-5
"""Standard deviation of the distance between a base's sockets from one placement to the next [m]:
bolting it down bends it a little, and dust keeps the ball from its seat."""

WORLD = -1
"""Stands for the world in place of a frame's index: the base of the first robot."""

Label = tuple[str, int]
"""Placement and number of a socket."""
Socket = TypeVar("Socket")
Frame = TypeVar("Frame")


class KnownError(MukcaError):
    """A known distance that cannot be understood, or whose sockets are not there."""


@dataclass(frozen=True)
class Known(Generic[Socket]):
    """A measured distance between two sockets."""

    first: Socket
    second: Socket
    distance: float
    """[m]."""
    deviation: float = CALIPER_DEVIATION
    """Its standard deviation [m]."""
    on_base: bool = False
    """True for two sockets of one base, which may have been recorded at several places."""


class KnownDistance(Known[Label]):
    """A measured distance between two sockets, which are named as a user names them."""

    def __str__(self) -> str:
        """Return the words that :func:`parse_known` reads."""
        (a, i), (b, j) = self.first, self.second
        return f"{a}:{i}-{b}:{j}={self.distance!r}+-{self.deviation!r}"


@dataclass(frozen=True)
class Located(Generic[Frame, Socket]):
    """Measured coordinates of a socket in a frame."""

    frame: Frame
    """:data:`WORLD` for the base of the first robot."""
    socket: Socket
    coordinates: tuple[float, float, float]
    """In that frame [m]."""
    deviation: float
    """Standard deviation of each coordinate [m]."""
    where: str = ""
    """File and line, for messages."""


class SocketAt(Located[str, Label]):
    """Measured coordinates of a socket in a frame, which are named as a user names them.

    The frame ``base`` is the robot's own base, of several robots ``NAME:base``.
    """

    def __str__(self) -> str:
        """Return the words that :func:`.sockets_at.parse_socket_at` reads."""
        (name, socket), (x, y, z) = self.socket, self.coordinates
        return f"{self.frame}/{name}:{socket}={x!r},{y!r},{z!r}+-{self.deviation!r}"


def distance_covariance(known: Sequence[Known[int]]) -> np.ndarray:
    """Return the covariance of the errors of K known distances, shape (K, K) [m^2].

    A base that was measured once with a wrong result is wrong by the same amount wherever it
    stands: placements whose stated distances are equal share that error.
    """
    covariance = np.zeros((len(known), len(known)))
    for i, one in enumerate(known):
        for j, other in enumerate(known):
            if i == j or (one.on_base and other.on_base and one.distance == other.distance):
                covariance[i, j] = one.deviation * other.deviation
        covariance[i, i] += min(SEAT_DEVIATION, one.deviation) ** 2 * one.on_base
    return covariance


_KNOWN = re.compile(r"(.+):(\d+)-(.+):(\d+)=([^+]+?)(?:\+-(.+))?")


def parse_known(text: str) -> KnownDistance:
    """Return the distance in words like ``left:0-right:0=0.175+-0.0001`` (metres)."""
    match = _KNOWN.fullmatch(text.strip())
    form = "expected A:0-B:0=0.175+-0.0001: placement, socket, distance and deviation in metres"
    if match is None:
        raise KnownError(f"known distance {text!r}: {form}")
    try:
        distance = float(match[5])
        deviation = CALIPER_DEVIATION if match[6] is None else float(match[6])
    except ValueError:
        raise KnownError(f"known distance {text!r}: {form}") from None
    if not (0 < distance < 20 and 0 < deviation < math.inf):
        raise KnownError(f"known distance {text!r}: distance and deviation are positive metres")
    return KnownDistance((match[1], int(match[2])), (match[3], int(match[4])), distance, deviation)


def read_known(known: Sequence[str | Path | KnownDistance]) -> Iterator[str | KnownDistance]:
    """Yield known distances, one by one; a word that is a file stands for its lines."""
    for one in known:
        if isinstance(one, KnownDistance) or not Path(one).is_file():
            yield one if isinstance(one, KnownDistance) else str(one)
        else:
            lines = Path(one).read_text(encoding="utf-8").splitlines()
            yield from (line for text in lines if (line := text.split("#")[0]).strip())


def find_socket(
    labels: Sequence[Label], end: Label, error: type[MukcaError] = KnownError, where: str = ""
) -> int:
    """Return the index of the socket that a user names; the folder's own name is enough."""
    name, socket = end
    fits = [i for i, (n, s) in enumerate(labels) if s == socket and name in (n, n.split("/")[-1])]
    if len(fits) != 1:
        there = ", ".join(f"{n}:{s}" for n, s in labels)
        kind = "is ambiguous" if fits else "is not there"
        raise error(f"{where}socket {name}:{socket} {kind}; sockets: {there}")
    return fits[0]

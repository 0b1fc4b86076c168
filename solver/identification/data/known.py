"""Known distances between sockets, and known coordinates of sockets in a frame.

A user names sockets and frames; a fit has their indices, ``Known[int]`` and ``Located[int, int]``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from ....errors import MukcaError
from .measurements import Measurement

CALIPER_DEVIATION = 3e-5
"""Standard deviation of a socket distance measured with a caliper [m]."""
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

    @property
    def seat_variance(self) -> float:
        """Its variance on a base from placement to placement [m^2]."""
        return min(SEAT_DEVIATION, self.deviation) ** 2 if self.on_base else 0.0


class KnownDistance(Known[Label]):
    """A measured distance between two sockets, which are named as a user names them."""

    def __str__(self) -> str:
        """Return the words that :func:`parse_known` reads."""
        a, i = self.first
        b, j = self.second
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
        """Return the words that :func:`parse_socket_at` reads."""
        name, socket = self.socket
        x, y, z = self.coordinates
        return f"{self.frame}/{name}:{socket}={x!r},{y!r},{z!r}+-{self.deviation!r}"


def distance_covariance(lengths: Sequence[Known[int]]) -> np.ndarray:
    """Return the covariance of the errors of K known distances, shape (K, K) [m^2].

    A base that was measured once with a wrong result is wrong by the same amount wherever it
    stands: placements whose stated distances are equal share that error.
    """
    covariance = common_covariance(lengths, lengths)
    for i, length in enumerate(lengths):
        covariance[i, i] = length.deviation**2 + length.seat_variance
    return covariance


def common_precision(lengths: Sequence[Known[int]]) -> np.ndarray:
    """Return by how much less K known distances tell for what they share, shape (K, bases).

    With s the deviations of one base's distances, and D the variances beside what they share, it is
    Q = D^-1 s / sqrt(1 + s^T D^-1 s), so that (D + s s^T)^-1 = D^-1 - Q Q^T (Sherman, Morrison).
    """
    deviations = np.array([length.deviation for length in lengths])
    D = np.array([length.seat_variance or np.inf for length in lengths])
    bases = np.array([length.distance for length in lengths])
    s = deviations[:, None] * (bases[:, None] == np.unique(bases))
    Q = s / D[:, None]
    return Q / np.sqrt(1 + np.sum(s * Q, axis=0))


def common_covariance(
    first: Sequence[Known[int]], second: Sequence[Known[int]]
) -> np.ndarray:
    """Return the covariance of the errors that known distances share by their bases [m^2].

    Its shape is (K, L) for K and L distances.
    """
    covariance = np.zeros((len(first), len(second)))
    for i, length in enumerate(first):
        for j, twin in enumerate(second):
            if length.on_base and twin.on_base and length.distance == twin.distance:
                covariance[i, j] = length.deviation * twin.deviation
    return covariance


def find_socket(
    labels: Sequence[Label],
    end: Label,
    error: type[MukcaError] = KnownError,
    where: str = "",
) -> int:
    """Return the index of the socket that a user names; the folder's own name is enough."""
    name, socket = end
    fits = [i for i, (n, s) in enumerate(labels) if s == socket and is_called(n, name)]
    if len(fits) != 1:
        listing = ", ".join(f"{n}:{s}" for n, s in labels)
        kind = "is ambiguous" if fits else "is not there"
        raise error(f"{where}socket {name}:{socket} {kind}; sockets: {listing}")
    return fits[0]


def is_called(placement: str, name: str) -> bool:
    """Tell whether a user names a placement so: in full, or by its folder's own name."""
    return name in (placement, placement.split("/")[-1])


def spaced(
    measured: Measurement, name: str, sockets_at: Sequence[SocketAt]
) -> Measurement:
    """Return a placement, called ``name``, whose sockets are as far apart as their coordinates say.

    Unless its distance was given otherwise, or the coordinates do not tell.
    """
    if not measured.has_distance or measured.distance_source != "default":
        return measured
    here = [socket for socket in sockets_at if is_called(name, socket.socket[0])]
    places = {(socket.frame, socket.socket[1]): socket for socket in here}
    first, second = measured.sockets[:2]
    for (frame, number), a in places.items():
        b = places.get((frame, second))
        if number == first and b is not None:
            return replace(
                measured,
                distance=math.dist(a.coordinates, b.coordinates),
                distance_source="located",
                distance_deviation=math.hypot(a.deviation, b.deviation),
            )
    return measured

"""Known distances between sockets, and known coordinates of sockets in a frame.

A user names sockets and frames; a fit has their indices, ``Known[int]`` and ``Located[int, int]``.
"""

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from ....errors import MukcaError
from ....recorder import number_of
from .frames import FrameError
from .length_table import read_lengths
from .lengths import metres
from .measurements import Measurement
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
COLUMNS = ("frame", "socket", "x", "y", "z", "deviation")
LARGEST_DEVIATION = 1.0
"""No coordinates are measured worse than this [m]."""
_SOCKET = re.compile(r".+:\d+")
_WORDS = re.compile(r"([^=/]+)/(.+:\d+)=([^,]+),([^,]+),([^,]+?)\+-(.+)")
_FRAME = re.compile(r"[\w.-]+(:base)?")


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
        seat = min(SEAT_DEVIATION, length.deviation) if length.on_base else 0.0
        covariance[i, i] = length.deviation**2 + seat**2
    return covariance


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


_KNOWN = re.compile(r"(.+:\d+)-(.+:\d+)=([^+]+?)(?:\+-(.+))?")


def parse_known(text: str) -> KnownDistance:
    """Return the distance in words like ``left:0-right:0=0.175+-0.0001`` (metres)."""
    match = _KNOWN.fullmatch(text.strip())
    try:
        if match is None:
            raise ValueError
        distance = metres(match[3])
        deviation = CALIPER_DEVIATION if match[4] is None else metres(match[4])
    except ValueError:
        raise KnownError(
            f"known distance {text!r}: expected A:0-B:0=0.175+-0.0001: placement, socket, "
            "distance and deviation in metres"
        ) from None
    if not (0 < distance < 20 and 0 < deviation < math.inf):
        raise KnownError(
            f"known distance {text!r}: distance and deviation are positive metres"
        )
    return KnownDistance(_label(match[1]), _label(match[2]), distance, deviation)


def _label(words: str) -> Label:
    """Return the socket in words like ``left:0``."""
    name, _, number = words.rpartition(":")
    return name, int(number)


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


def read_sockets_at(
    sources: str | Path | Iterable[str | Path | SocketAt],
) -> list[SocketAt]:
    """Return measured coordinates of sockets that files, words, or they themselves give.

    A CSV file; ``frame`` is a name of your own, ``base`` or ``NAME:base``; ``#`` begins a note::

        frame,socket,x [mm],y [mm],z [mm],deviation [mm]
        table,front:0,0,0,30,0.05
    """
    sockets: list[SocketAt] = []
    owners: dict[str, Path] = {}
    for source in [sources] if isinstance(sources, str | Path) else sources:
        if isinstance(source, SocketAt):
            sockets.append(source)
        elif "=" in str(source) and not Path(source).exists():
            sockets.append(parse_socket_at(str(source)))
        else:
            rows = _rows(file := Path(source))
            for frame in dict.fromkeys(row.frame for row in rows):
                if frame in owners:
                    raise FrameError(
                        f"{file}: frame {frame!r} is named twice, here and in {owners[frame]}; "
                        "give each frame a name of its own, or put its sockets into one file"
                    )
                owners[frame] = file
            sockets += rows
    return sockets


def parse_socket_at(words: str) -> SocketAt:
    """Return the coordinates in words like ``table/front:0=0.1,0.2,0.03+-0.00005`` (metres)."""
    match = _WORDS.fullmatch(words.strip())
    if match is None:
        raise FrameError(
            f"{words!r} is neither a file nor FRAME/PLACEMENT:0=X,Y,Z+-DEVIATION in metres"
        )
    frame, socket, *numbers = match.groups()
    values = [number_of(number) for number in numbers]
    return _socket_at(
        words, frame, socket, [math.nan if x is None else x for x in values]
    )


def _rows(file: Path) -> list[SocketAt]:
    """Return the coordinates in a file."""
    rows: list[SocketAt] = []
    line_of: dict[tuple[str, str], int] = {}
    for line, (frame, socket), values in read_lengths(
        file, COLUMNS[:2], COLUMNS[2:], FrameError
    ):
        first = line_of.setdefault((frame, socket), line)
        if first != line:
            raise FrameError(
                f"{file}:{line}: socket {socket} is twice in frame {frame!r}, as in line {first}"
            )
        rows.append(_socket_at(f"{file}:{line}", frame, socket, values))
    return rows


def _socket_at(
    where: str, frame: str, socket: str, values: Sequence[float]
) -> SocketAt:
    if not _SOCKET.fullmatch(socket):
        raise FrameError(f"{where}: socket {socket!r}: expected PLACEMENT:0")
    if not _FRAME.fullmatch(frame):
        raise FrameError(
            f"{where}: frame {frame!r} is no name: letters, digits, and . _ -"
        )
    x, y, z, deviation = values
    if not all(map(math.isfinite, values)) or deviation <= 0:
        raise FrameError(
            f"{where}: x, y, z are numbers, and the deviation a positive one"
        )
    if deviation > LARGEST_DEVIATION:
        raise FrameError(
            f"{where}: a deviation of {deviation:g} m tells nothing; check its unit"
        )
    return SocketAt(frame, _label(socket), (x, y, z), deviation, where)


def in_placements(
    sockets_at: Sequence[SocketAt], train: Sequence[str], test: Sequence[str]
) -> list[SocketAt]:
    """Return the coordinates of sockets in placements to train on; a fit is told of no others."""
    in_training: list[SocketAt] = []
    for socket in sockets_at:
        name = socket.socket[0]
        if any(is_called(placement, name) for placement in train):
            in_training.append(socket)
        elif not any(is_called(placement, name) for placement in test):
            raise FrameError(
                f"{socket.where}: no placement is called {name!r}; there are: "
                f"{', '.join((*train, *test))}"
            )
    return in_training


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

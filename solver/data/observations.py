"""All that a fit is told: the samples of all placements, and what is known of places.

Every sample says that the ball of a robot is at a place. Places are sockets, or points that an
instrument measured. What is known of them are distances, or coordinates in a frame whose own pose
is known or not, see :mod:`.frames`.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ... import MukcaError
from ..robot.kinematics import STANDARD_GRAVITY, gravity_moments
from ..robot.urdf import Robot
from .frames import FrameError
from .measurements import Measurement
from .metrics import CALIPER_DEVIATION

__all__ = [
    "SEAT_DEVIATION",
    "WORLD",
    "Instrument",
    "Known",
    "KnownDistance",
    "KnownError",
    "Load",
    "Located",
    "Observations",
    "Recorded",
    "Scene",
    "SocketAt",
    "distance_covariance",
    "find_socket",
    "observe",
    "observe_all",
    "parse_known",
]

SEAT_DEVIATION = 1e-5
"""Standard deviation of the distance between a base's sockets from one placement to the next [m]:
bolting it down bends it a little, and dust keeps the ball from its seat."""


class KnownError(MukcaError):
    """A known distance that cannot be understood, or whose sockets are not there."""


@dataclass(frozen=True)
class Load:
    """What pulls at the joints of an arm at rest."""

    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    """In the base frame [m/s^2]; another direction for an arm on a wall or ceiling."""
    payload: float = 0.0
    """Mass at the ball, beyond that of the model [kg]."""

    def torques(self, robot: Robot, measured: Measurement) -> np.ndarray:
        """Return what holds the joints of a placement's samples, see :meth:`moments`."""
        return self.moments(robot, measured.positions, measured.efforts)

    def moments(self, robot: Robot, q: np.ndarray, efforts: np.ndarray | None) -> np.ndarray:
        """Return the moments that hold the joints of an arm.

        Args:
            robot: The robot.
            q: Joint positions, shape (N, m) [rad].
            efforts: Torques as measured, shape (N, m) [N m]; None for those of the model's masses.

        Returns:
            Shape (N, 3 m) [N m]: torques about the joints' own axes, then the moments across them,
            which always follow from the masses.
        """
        moments = gravity_moments(robot, q, self.gravity, self.payload)
        if efforts is not None:
            moments[:, : q.shape[1]] = efforts
        return moments


@dataclass(frozen=True)
class KnownDistance:
    """A measured distance between two sockets, which are named as a user names them."""

    first: tuple[str, int]
    """Placement and socket."""
    second: tuple[str, int]
    distance: float
    """[m]."""
    deviation: float = CALIPER_DEVIATION
    """Its standard deviation [m]."""

    def __str__(self) -> str:
        """Return the words that :func:`parse_known` reads."""
        (a, i), (b, j) = self.first, self.second
        return f"{a}:{i}-{b}:{j}={self.distance!r}+-{self.deviation!r}"


@dataclass(frozen=True)
class Known:
    """A measured distance between two sockets, by their indices among all sockets of a fit."""

    first: int
    second: int
    distance: float
    """[m]."""
    deviation: float
    """Its standard deviation [m]."""
    on_base: bool = False
    """Whether the two sockets are on one base, which may have been recorded at several places."""


WORLD = -1
"""Stands for the world in place of a frame's index: the base of the first robot."""


@dataclass(frozen=True)
class SocketAt:
    """Measured coordinates of a socket in a frame, which are named as a user names them."""

    frame: str
    """``base`` is the robot's own base, of several robots ``NAME:base``."""
    socket: tuple[str, int]
    """Placement and socket."""
    coordinates: tuple[float, float, float]
    """In that frame [m]."""
    deviation: float
    """Standard deviation of each coordinate [m]."""
    where: str = ""
    """File and line, for messages."""

    def __str__(self) -> str:
        """Return the words that :func:`.sockets_at.parse_socket_at` reads."""
        (name, socket), (x, y, z) = self.socket, self.coordinates
        return f"{self.frame}/{name}:{socket}={x!r},{y!r},{z!r}+-{self.deviation!r}"


@dataclass(frozen=True)
class Located:
    """Measured coordinates of a socket, by indices among all sockets and frames of a fit."""

    socket: int
    frame: int
    """:data:`WORLD` for the base of the first robot."""
    coordinates: tuple[float, float, float]
    """In that frame [m]."""
    deviation: float
    """Standard deviation of each coordinate [m]."""
    where: str = ""


@dataclass(frozen=True)
class Observations:
    """What is known of one robot: N samples, m joints, S sockets, K distances, F frames."""

    positions: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    torques: np.ndarray
    """What the joints exert to hold the arm, about their own axes and those across, shape
    (N, 3 m) [N m]."""
    sockets: np.ndarray
    """Index of each sample's socket among all sockets, shape (N,); -1 for a ball that an instrument
    measured."""
    labels: tuple[tuple[str, int], ...]
    """For each socket, the name of its placement and its number there."""
    known: tuple[Known, ...]
    """The measured distances."""
    located: tuple[Located, ...] = ()
    """The measured coordinates of sockets."""
    frames: tuple[str, ...] = ()
    """The names of the frames whose pose is unknown."""
    instrument: "Instrument | None" = None
    """What an instrument measured; None where it measured nothing."""
    base: int = WORLD
    """Index of the frame that is the robot's base."""

    @property
    def anchored(self) -> bool:
        """Whether coordinates of sockets are known in the robot's own base."""
        return any(one.frame == self.base for one in self.located)

    @property
    def socket_count(self) -> int:
        """Number of sockets in all placements."""
        return len(self.labels)

    def distance_covariance(self) -> np.ndarray:
        """Return :func:`distance_covariance` of the known distances."""
        return distance_covariance(self.known)

    def without(self, placement: str) -> "Observations":
        """Return the observations without one placement and the distances to its sockets."""
        kept = [i for i, (name, _) in enumerate(self.labels) if name != placement]
        new = {old: i for i, old in enumerate(kept)}
        rows = np.isin(self.sockets, kept)
        instrument = self.instrument
        if instrument is not None:
            rows |= instrument.rows_besides(placement)
            instrument = instrument.of(rows)
        return replace(
            self,
            positions=self.positions[rows],
            torques=self.torques[rows],
            sockets=np.array([new.get(s, -1) for s in self.sockets[rows].tolist()], dtype=np.int64),
            labels=tuple(self.labels[i] for i in kept),
            known=tuple(
                replace(k, first=new[k.first], second=new[k.second])
                for k in self.known
                if k.first in new and k.second in new
            ),
            located=tuple(
                replace(one, socket=new[one.socket]) for one in self.located if one.socket in new
            ),
            instrument=instrument,
        )


@dataclass(frozen=True)
class Instrument:
    """The balls that an instrument measured, row by row as the samples they belong to."""

    frames: np.ndarray
    """Index of the frame of each, shape (N,); -1 for a sample in a socket."""
    points: np.ndarray
    """Coordinates in that frame, shape (N, 3) [m]; zero for a sample in a socket."""
    placements: tuple[str, ...]
    """For each sample, the name of its placement; empty for one in a socket."""
    wheres: tuple[str, ...]
    """File and line of each, for messages."""

    def rows_besides(self, placement: str) -> np.ndarray:
        """Return which samples were measured, but for those of one placement, shape (N,)."""
        return np.array([name not in ("", placement) for name in self.placements], dtype=bool)

    def of(self, rows: np.ndarray) -> "Instrument | None":
        """Return what was measured at some samples; None where nothing was."""
        if not (self.frames[rows] >= 0).any():
            return None
        picked = np.flatnonzero(rows).tolist()
        return Instrument(
            self.frames[rows],
            self.points[rows],
            tuple(self.placements[i] for i in picked),
            tuple(self.wheres[i] for i in picked),
        )


@dataclass(frozen=True)
class Scene:
    """All robots of a fit; their sockets, distances and frames are the same ones."""

    arms: tuple[Observations, ...]
    """What is known of each robot."""
    names: tuple[str, ...] = ("",)
    """Of the robots."""
    bases: tuple[int, ...] = (WORLD,)
    """For each robot, the index of the frame of its base; the first is the world."""

    @property
    def placements(self) -> tuple[str, ...]:
        """The names of all placements."""
        names = [name for name, _ in self.arms[0].labels]
        for arm in self.arms:
            names += arm.instrument.placements if arm.instrument is not None else ()
        return tuple(dict.fromkeys(name for name in names if name))

    def without(self, placement: str) -> "Scene":
        """Return the scene without one placement, and what is known of its sockets."""
        return replace(self, arms=tuple(arm.without(placement) for arm in self.arms))


@dataclass(frozen=True)
class Recorded:
    """A robot and its placements."""

    robot: Robot
    measurements: Sequence[Measurement]
    load: Load = field(default_factory=Load)
    name: str = ""
    """Where there are several robots."""


def distance_covariance(known: Sequence[Known]) -> np.ndarray:
    """Return the covariance of the errors of K known distances, shape (K, K) [m^2].

    A base that was measured once with a wrong result is wrong by the same amount wherever it
    stands. So placements whose stated distances are equal share that error, and recording more
    of them does not make it smaller. Who states a distance to better than its base repeats is
    believed.
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
    """Return the distance in words like ``left:0-right:0=0.175+-0.0001`` (metres).

    Raises:
        KnownError: The words are not of that form, or the numbers cannot be.
    """
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


def observe(
    measurements: Sequence[Measurement],
    robot: Robot,
    *,
    known: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    load: Load | None = None,
    tied: bool = True,
) -> Observations:
    """Put all placements of one robot and what is known of them together for a fit.

    Args:
        measurements: The placements.
        robot: The robot.
        known: Distances measured beside those between each placement's first two sockets.
        sockets_at: Measured coordinates of sockets.
        deviation: Standard deviation of the distance between a placement's first two sockets [m].
        load: What pulls at the joints; None for gravity alone, straight down.
        tied: Refuse a placement none of whose sockets has a known distance to another.

    Raises:
        KnownError: A known distance names a socket that is not there, or a socket of its own
            has no known distance to any other.
        FrameError: Coordinates of a socket that is not there.
    """
    recorded = Recorded(robot, measurements, load or Load())
    scene = observe_all(
        [recorded], known=known, sockets_at=sockets_at, deviation=deviation, tied=tied
    )
    return scene.arms[0]


def observe_all(
    arms: Sequence[Recorded],
    *,
    known: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    tied: bool = True,
) -> Scene:
    """Put the placements of all robots together; see :func:`observe`.

    A socket is known by its placement and number. Of several robots, placements of the same place
    (see :attr:`~mukca.recorder.dataset.Placement.place`) are the same base, not moved.
    """

    def of(m: Measurement) -> str:
        return m.name if len(arms) == 1 else m.placement.place

    every = [(of(m), m) for arm in arms for m in arm.measurements]
    seated = [(name, m) for name, m in every if m.kind == "sockets"]
    labels = list(dict.fromkeys((name, socket) for name, m in seated for socket in m.sockets))
    names = [m.frame for _, m in every if m.kind == "points"]
    own = {_base_of(arm): i for i, arm in enumerate(arms)}
    names += [one.frame for one in sockets_at if one.frame not in own]
    names += list(own)[1:]
    frames = list(dict.fromkeys(names))
    located = tuple(
        Located(
            find_socket(labels, one.socket, FrameError, f"{one.where}: "),
            WORLD if own.get(one.frame) == 0 else frames.index(one.frame),
            one.coordinates,
            one.deviation,
            one.where,
        )
        for one in sockets_at
    )
    pairs = _pairs(seated, labels, located, deviation)
    for k in known:
        a, b = (find_socket(labels, end) for end in (k.first, k.second))
        if a == b:
            raise KnownError(f"known distance from {k.first[0]}:{k.first[1]} to itself")
        pairs.append(Known(a, b, k.distance, k.deviation))
    ends = {end for pair in pairs for end in (pair.first, pair.second)}
    ends |= {one.socket for one in located}
    for name, m in seated:
        if tied and not any(labels.index((name, socket)) in ends for socket in m.sockets):
            raise KnownError(
                f"{m.placement.path or m.name}: only socket {m.sockets[0]} has samples, and no "
                "known distance ties it; record the other socket too, or give "
                f"--known {m.name}:{m.sockets[0]}-OTHER:0=DISTANCE"
            )
    shared = (tuple(labels), tuple(pairs), located, tuple(frames))
    bases = (WORLD, *(frames.index(base) for base in list(own)[1:]))
    samples = [_samples(arm, [(of(m), m) for m in arm.measurements], *shared) for arm in arms]
    return Scene(
        tuple(replace(one, base=base) for one, base in zip(samples, bases, strict=True)),
        tuple(arm.name for arm in arms),
        bases,
    )


def _base_of(arm: Recorded) -> str:
    return f"{arm.name}:base" if arm.name else "base"


def _pairs(
    seated: Sequence[tuple[str, Measurement]],
    labels: Sequence[tuple[str, int]],
    located: Sequence[Located],
    deviation: float,
) -> list[Known]:
    """Return the distances between the first two sockets of each base.

    A default distance is left out where both sockets have coordinates in one frame: those tell.
    """
    frames = {one.socket: one.frame for one in located}
    pairs: dict[tuple[int, int], Known] = {}
    for name, m in seated:
        if not m.has_distance:
            continue
        a, b = (labels.index((name, socket)) for socket in m.sockets[:2])
        told = a in frames and frames[a] == frames.get(b)
        if told and m.distance_source in ("default", "located"):
            continue
        pair = Known(a, b, m.distance, deviation, on_base=True)
        if pairs.setdefault((a, b), pair).distance != m.distance:
            raise KnownError(
                f"{name}: its sockets are {pairs[a, b].distance} m apart for one robot, and "
                f"{m.distance} m for another; one base has one distance"
            )
    return list(pairs.values())


def _samples(
    arm: Recorded,
    measurements: Sequence[tuple[str, Measurement]],
    labels: tuple[tuple[str, int], ...],
    known: tuple[Known, ...],
    located: tuple[Located, ...],
    frames: tuple[str, ...],
) -> Observations:
    """Return the samples of one robot, among the sockets and frames of all."""
    places = [
        np.repeat([labels.index((name, s)) for s in m.sockets], m.counts)
        if m.kind == "sockets"
        else np.full(sum(m.counts), -1)
        for name, m in measurements
    ]
    return Observations(
        np.concatenate([m.positions for _, m in measurements]),
        np.concatenate([arm.load.torques(arm.robot, m) for _, m in measurements]),
        np.concatenate(places),
        labels,
        known,
        located,
        frames,
        _instrument(measurements, frames),
    )


def _instrument(
    measurements: Sequence[tuple[str, Measurement]], frames: Sequence[str]
) -> Instrument | None:
    if all(m.kind == "sockets" for _, m in measurements):
        return None
    rows = [(name, m, m.kind == "points") for name, m in measurements]
    return Instrument(
        np.concatenate(
            [np.full(sum(m.counts), frames.index(m.frame) if on else -1) for _, m, on in rows]
        ),
        np.concatenate([m.points if on else np.zeros((sum(m.counts), 3)) for _, m, on in rows]),
        tuple(name if on else "" for name, m, on in rows for _ in range(sum(m.counts))),
        tuple(sample.where for _, m, _ in rows for sample in m.placement.samples),
    )


def find_socket(
    labels: Sequence[tuple[str, int]],
    end: tuple[str, int],
    error: type[MukcaError] = KnownError,
    where: str = "",
) -> int:
    """Return the index of the socket that a user names; the folder's own name is enough."""
    name, socket = end
    fits = [i for i, (n, s) in enumerate(labels) if s == socket and name in (n, n.split("/")[-1])]
    if len(fits) != 1:
        there = ", ".join(f"{n}:{s}" for n, s in labels)
        kind = "is ambiguous" if fits else "is not there"
        raise error(f"{where}socket {name}:{socket} {kind}; sockets: {there}")
    return fits[0]

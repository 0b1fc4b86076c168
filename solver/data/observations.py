"""All that a fit is told: the samples of all placements, and measured distances between sockets."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ... import MukcaError
from ..robot.kinematics import STANDARD_GRAVITY, gravity_moments
from ..robot.urdf import Robot
from .measurements import Measurement
from .metrics import CALIPER_DEVIATION

__all__ = [
    "SEAT_DEVIATION",
    "Known",
    "KnownError",
    "Load",
    "Observations",
    "observe",
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


@dataclass(frozen=True)
class Observations:
    """The samples and measured distances of a fit: N samples, m joints, S sockets, K distances."""

    positions: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    torques: np.ndarray
    """What the joints exert to hold the arm, about their own axes and those across, shape
    (N, 3 m) [N m]."""
    sockets: np.ndarray
    """Index of each sample's socket among all sockets, shape (N,)."""
    labels: tuple[tuple[str, int], ...]
    """For each socket, the name of its placement and its number there."""
    known: tuple[Known, ...]
    """The measured distances."""

    @property
    def socket_count(self) -> int:
        """Number of sockets in all placements."""
        return len(self.labels)

    def distance_covariance(self) -> np.ndarray:
        """Return the covariance of the known distances' errors, shape (K, K) [m^2].

        A base that was measured once with a wrong result is wrong by the same amount wherever it
        stands. So placements whose stated distances are equal share that error, and recording more
        of them does not make it smaller.
        """
        covariance = np.zeros((len(self.known), len(self.known)))
        for i, one in enumerate(self.known):
            for j, other in enumerate(self.known):
                if i == j or (one.on_base and other.on_base and one.distance == other.distance):
                    covariance[i, j] = one.deviation * other.deviation
            covariance[i, i] += SEAT_DEVIATION**2 * one.on_base
        return covariance

    def without(self, placement: str) -> "Observations":
        """Return the observations without one placement and the distances to its sockets."""
        kept = [i for i, (name, _) in enumerate(self.labels) if name != placement]
        new = {old: i for i, old in enumerate(kept)}
        rows = np.isin(self.sockets, kept)
        return Observations(
            self.positions[rows],
            self.torques[rows],
            np.array([new[s] for s in self.sockets[rows].tolist()], dtype=np.int64),
            tuple(self.labels[i] for i in kept),
            tuple(
                replace(k, first=new[k.first], second=new[k.second])
                for k in self.known
                if k.first in new and k.second in new
            ),
        )


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
    deviation: float = CALIPER_DEVIATION,
    load: Load | None = None,
    tied: bool = True,
) -> Observations:
    """Put all placements and measured distances together for a fit.

    Args:
        measurements: The placements.
        robot: The robot.
        known: Distances measured beside those between each placement's first two sockets.
        deviation: Standard deviation of the latter [m].
        load: What pulls at the joints; None for gravity alone, straight down.
        tied: Refuse a placement none of whose sockets has a known distance to another.

    Raises:
        KnownError: A known distance names a socket that is not there, or a socket of its own
            has no known distance to any other.
    """
    load = load or Load()
    labels = [(m.name, socket) for m in measurements for socket in m.sockets]
    pairs: list[Known] = []
    for m in measurements:
        if m.has_distance:
            a, b = (labels.index((m.name, socket)) for socket in m.sockets[:2])
            pairs.append(Known(a, b, m.distance, deviation, on_base=True))
    for k in known:
        a, b = (_find(labels, end) for end in (k.first, k.second))
        if a == b:
            raise KnownError(f"known distance from {k.first[0]}:{k.first[1]} to itself")
        pairs.append(Known(a, b, k.distance, k.deviation))
    ends = {end for pair in pairs for end in (pair.first, pair.second)}
    for m in measurements:
        if tied and not any(labels.index((m.name, socket)) in ends for socket in m.sockets):
            raise KnownError(
                f"{m.placement.path or m.name}: only socket {m.sockets[0]} has samples, and no "
                "known distance ties it; record the other socket too, or give "
                f"--known {m.name}:{m.sockets[0]}-OTHER:0=DISTANCE"
            )
    index = np.concatenate(
        [np.repeat([labels.index((m.name, s)) for s in m.sockets], m.counts) for m in measurements]
    )
    return Observations(
        np.concatenate([m.positions for m in measurements]),
        np.concatenate([load.torques(robot, m) for m in measurements]),
        index,
        tuple(labels),
        tuple(pairs),
    )


def _find(labels: Sequence[tuple[str, int]], end: tuple[str, int]) -> int:
    """Return the index of the socket that a user names; the folder's own name is enough."""
    name, socket = end
    fits = [i for i, (n, s) in enumerate(labels) if s == socket and name in (n, n.split("/")[-1])]
    if len(fits) != 1:
        there = ", ".join(f"{n}:{s}" for n, s in labels)
        kind = "is ambiguous" if fits else "is not there"
        raise KnownError(f"socket {name}:{socket} {kind}; sockets: {there}")
    return fits[0]

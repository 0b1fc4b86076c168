"""Placements with samples sorted by socket, the load meanwhile, and what an instrument measured.

A measured pose is two samples, place [m] and orientation [rad], which come last.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from ...recorder import Placement
from ..robot import STANDARD_GRAVITY, Robot, gravity_moments
from .measured_poses import rotation_matrices

INSTRUMENT = "instrument"
"""Name of an instrument's frame where its recording gives none."""
CLOCKS = ("time", "temperature")
"""Columns that may tell when a sample was recorded."""


@dataclass(frozen=True)
class Measurement:
    """A placement with its joints in chain order, and the distance between its sockets."""

    placement: Placement
    """The recording, its joints in the order of the robot's chain."""
    distance: float
    """Between the centres of its first two sockets [m]."""
    distance_source: str = "default"
    """Its source: ``given`` by the user, the ``recording``, nothing but the ``default``, or
    ``located`` by measured coordinates."""
    distance_deviation: float | None = None
    """Its standard deviation [m], where it is not a caliper's."""
    warnings: tuple[str, ...] = field(default=())
    moved: np.ndarray | None = None
    """Movement of the place of each row of :attr:`positions` until then, as a fit found it,
    shape (N, 3) [m]; None for a place that stood still."""

    def at_rest(self, balls: np.ndarray) -> np.ndarray:
        """Return predicted balls as if the place had stood still, shape (N, 3) [m]."""
        return balls if self.moved is None else balls - self.moved

    @property
    def name(self) -> str:
        """The placement's name."""
        return self.placement.name

    @property
    def kind(self) -> Literal["sockets", "points"]:
        """``points`` where an instrument measured each sample's ball, in no socket."""
        return "points" if self.placement.samples[0].point is not None else "sockets"

    @property
    def frame(self) -> str:
        """The name of the instrument's frame."""
        return self.placement.frame or INSTRUMENT

    @cached_property
    def points(self) -> np.ndarray:
        """The measured balls in the instrument's frame, shape (N, 3) [m]."""
        return np.array([sample.point for sample in self.placement.samples], dtype=float)

    @property
    def has_orientations(self) -> bool:
        """True where the instrument measured orientations, too."""
        return self.placement.samples[0].orientation is not None

    @cached_property
    def rotations(self) -> np.ndarray:
        """The measured orientations in the instrument's frame, shape (N, 3, 3)."""
        return rotation_matrices(self.quaternions)

    @cached_property
    def quaternions(self) -> np.ndarray:
        """The same as unit quaternions x, y, z, w, shape (N, 4)."""
        return np.array([sample.orientation for sample in self.placement.samples], dtype=float)

    @cached_property
    def sockets(self) -> tuple[int, ...]:
        """The numbers of the sockets that have samples."""
        return tuple(sorted({sample.socket for sample in self.placement.samples}))

    @cached_property
    def by_socket(self) -> tuple[np.ndarray, ...]:
        """For each socket, the joint positions of its samples, shape (N_k, m) [rad]."""
        placement = self.placement
        return tuple(placement.positions[placement.sockets == k] for k in self.sockets)

    @cached_property
    def positions(self) -> np.ndarray:
        """Joint positions of all samples, socket after socket, shape (N, m) [rad]."""
        return np.concatenate(self.by_socket)

    def as_recorded(self, rows: np.ndarray) -> np.ndarray:
        """Return what belongs to rows of :attr:`positions` in the order of recording."""
        return rows[np.argsort(np.argsort(self.placement.sockets, kind="stable"))]

    @cached_property
    def efforts(self) -> np.ndarray | None:
        """Measured joint efforts, row by row as :attr:`positions` [N m]; None without them."""
        efforts, sockets = self.placement.efforts, self.placement.sockets
        if efforts is None:
            return None
        return np.concatenate([efforts[sockets == k] for k in self.sockets])

    def clock(self, name: str) -> np.ndarray:
        """Return the time [s] or temperature of each row of :attr:`positions`, shape (N,).

        Numbered samples that have no time are told apart by their order; NaN where neither is
        known, as of sockets in files of their own.
        """
        samples = self.placement.samples
        told = [getattr(sample, name) for sample in samples]
        t = np.array([np.nan if value is None else value for value in told], dtype=float)
        if name == "time" and np.isnan(t).any() and all(sample.number for sample in samples):
            t = np.arange(len(samples), dtype=float)
        return np.concatenate([t[self.placement.sockets == k] for k in self.sockets])

    @property
    def has_distance(self) -> bool:
        """True where two sockets have samples, so that their distance can be compared."""
        return len(self.sockets) > 1

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Rows of :attr:`positions` of each socket's samples."""
        ends = np.cumsum([len(rows) for rows in self.by_socket]).tolist()
        return tuple(slice(a, b) for a, b in zip([0, *ends], ends, strict=False))

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of samples in each socket."""
        return tuple(len(rows) for rows in self.by_socket)


@dataclass(frozen=True)
class Load:
    """Gravity, and a payload at the ball."""

    gravity: tuple[float, float, float]
    """In the base frame [m/s^2]; another direction for an arm on a wall or ceiling."""
    payload: float
    """Mass at the ball, beyond that of the model [kg]."""

    def torques(self, robot: Robot, measured: Measurement) -> np.ndarray:
        """Return the moments that hold the joints in a placement's samples; see :meth:`moments`."""
        return self.moments(robot, measured.positions, measured.efforts)

    def by_socket(self, robot: Robot, measured: Measurement) -> list[tuple[np.ndarray, np.ndarray]]:
        """Return joint positions and :meth:`torques` of the samples in each socket."""
        moments = self.torques(robot, measured)
        return [(measured.positions[rows], moments[rows]) for rows in measured.slices]

    def moments(self, robot: Robot, q: np.ndarray, efforts: np.ndarray | None) -> np.ndarray:
        """Return the moments that hold an arm's joints at positions q, shape (N, 3 m) [N m].

        Torques about the joints' own axes, as measured unless ``efforts`` is None, then the moments
        across them, which always follow from the masses.
        """
        moments = gravity_moments(robot, q, self.gravity, self.payload)
        if efforts is not None:
            moments[:, : q.shape[1]] = efforts
        return moments


STANDARD_LOAD = Load(STANDARD_GRAVITY, 0.0)
"""An arm that stands upright and carries nothing beyond its ball."""

"""Placements with samples sorted by socket, the load meanwhile, and what an instrument measured.

A measured pose is two samples, place [m] and orientation [rad], which come last.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate
from typing import Literal

import numpy as np

from ....errors import MukcaError
from ....recorder import Placement
from ..robot import STANDARD_GRAVITY, Robot, gravity_moments, rotation_matrices
from .samples import Samples, joined

INSTRUMENT = "instrument"
"""Name of an instrument's frame where its recording gives none."""


class MeasurementError(MukcaError):
    """A placement does not hold what a calibration needs."""


class LimitsError(MeasurementError):
    """A joint reads what it cannot reach, in a unit that may be right."""


class TooFewError(MeasurementError):
    """A placement has too few samples to tell anything."""


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
    distance_readings: int = 1
    """Number of readings that agree on it."""
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

    @cached_property
    def kind(self) -> Literal["sockets", "points"]:
        """``points`` where an instrument measured each sample's ball."""
        return self.placement.kind

    @property
    def frame(self) -> str:
        """The name of the instrument's frame."""
        return self.placement.frame or INSTRUMENT

    @cached_property
    def points(self) -> np.ndarray:
        """The measured balls in the instrument's frame, shape (N, 3) [m]."""
        return np.array(
            [sample.point for sample in self.placement.samples], dtype=float
        )

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
        return np.array(
            [sample.orientation for sample in self.placement.samples], dtype=float
        )

    @cached_property
    def sockets(self) -> tuple[int, ...]:
        """The numbers of the sockets that have samples."""
        return tuple(np.unique(self.placement.sockets).tolist())

    @property
    def labels(self) -> tuple[tuple[str, int], ...]:
        """The placement's name and the number of each socket; none for points."""
        sockets = self.sockets if self.kind == "sockets" else ()
        return tuple((self.name, socket) for socket in sockets)

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """Number of samples in each socket."""
        return tuple(np.unique(self.placement.sockets, return_counts=True)[1].tolist())

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Rows of :attr:`positions` of each socket's samples."""
        ends = accumulate(self.counts)
        return tuple(
            slice(end - n, end) for n, end in zip(self.counts, ends, strict=True)
        )

    @cached_property
    def by_socket(self) -> tuple[np.ndarray, ...]:
        """For each socket, the joint positions of its samples, shape (N_k, m) [rad]."""
        return tuple(self.positions[rows] for rows in self.slices)

    @cached_property
    def order(self) -> np.ndarray:
        """Rank in the order of recording of each row of :attr:`positions`, shape (N,)."""
        return np.argsort(self.placement.sockets, kind="stable")

    @cached_property
    def positions(self) -> np.ndarray:
        """Joint positions of all samples, socket after socket, shape (N, m) [rad]."""
        return self.placement.positions[self.order]

    def as_recorded(self, rows: np.ndarray) -> np.ndarray:
        """Return what belongs to rows of :attr:`positions` in the order of recording."""
        return rows[np.argsort(self.order)]

    @cached_property
    def efforts(self) -> np.ndarray | None:
        """Measured joint efforts, row by row as :attr:`positions` [N m]; None without them."""
        efforts = self.placement.efforts
        return None if efforts is None else efforts[self.order]

    def clock(self, name: str) -> np.ndarray:
        """Return the time [s] or temperature of each row of :attr:`positions`, shape (N,).

        It is NaN where it was not recorded; a number alone may come from a conversion. Without
        the host's times those of the robot count.
        """
        t = self._column(name)
        if name == "time" and np.isnan(t).any():
            t = self._column("stamp")
        return t[self.order]

    def _column(self, name: str) -> np.ndarray:
        """Return numbers of the samples as recorded, NaN for what is not known, shape (N,)."""
        samples = self.placement.samples
        return np.array([getattr(sample, name) for sample in samples], dtype=float)

    @cached_property
    def clocks(self) -> np.ndarray:
        """Return :data:`.CLOCKS` of each row since the first sample, shape (N, 4).

        Time [s] and temperature [K] are NaN where they were not recorded.
        """
        order, before = self.order, np.cumsum(self.counts)
        reverse = order + np.repeat(len(order) - 2 * before + self.counts, self.counts)
        since = np.column_stack([self.clock("time"), self.clock("temperature")])
        since -= since[np.argmin(order)]
        return np.column_stack([order, since, reverse])

    @property
    def wheres(self) -> np.ndarray:
        """File and line of each row of :attr:`positions`, for messages, shape (N,)."""
        wheres = [sample.where for sample in self.placement.samples]
        return np.array(wheres)[self.order]

    def called(self, name: str) -> "Measurement":
        """Return the placement by another name."""
        return replace(self, placement=replace(self.placement, name=name))

    def only(self, rows: np.ndarray) -> "Measurement":
        """Return the placement with some of its samples, by their :attr:`order`."""
        ranks: list[int] = rows.tolist()
        samples = tuple(self.placement.samples[i] for i in ranks)
        return replace(self, placement=replace(self.placement, samples=samples))

    def shifted(self, offsets: np.ndarray) -> "Measurement":
        """Return the placement with offsets added to its joint positions, shape (m,) [rad].

        They may be those of each sample, in the order of recording, shape (N, m).
        """
        positions = self.placement.positions + offsets
        return replace(self, placement=self.placement.with_positions(positions))

    @property
    def has_distance(self) -> bool:
        """True where two sockets have samples, so that their distance can be compared."""
        return len(self.sockets) > 1


@dataclass(frozen=True)
class Load:
    """Gravity, and a payload at the ball."""

    gravity: tuple[float, float, float]
    """In the base frame [m/s^2]; another direction for an arm on a wall or ceiling."""
    payload: float
    """Mass at the ball, beyond that of the model [kg]."""

    def of(self, placement: Placement) -> "Load":
        """Return the load of a placement, which may state a payload of its own."""
        mass = placement.payload
        return self if mass is None else Load(self.gravity, mass)

    def samples(self, robot: Robot, *measurements: Measurement) -> Samples:
        """Return the samples of placements, row by row as :attr:`Measurement.positions`."""
        parts = [
            self.of(m.placement).at(robot, m.positions, m.efforts, m.clocks)
            for m in measurements
        ]
        return joined(parts)

    def by_socket(self, robot: Robot, *measurements: Measurement) -> list[Samples]:
        """Return the samples of placements in each of their sockets."""
        by_socket: list[Samples] = []
        for m in measurements:
            samples = self.samples(robot, m)
            by_socket += [samples.only(rows) for rows in m.slices]
        return by_socket

    def at(
        self,
        robot: Robot,
        q: np.ndarray,
        efforts: np.ndarray | None = None,
        clocks: np.ndarray | None = None,
    ) -> Samples:
        """Return an arm at joint positions q, shape (N, m) [rad], with the moments that hold it.

        Torques about the joints' own axes are as measured unless ``efforts`` is None, or the masses
        are assumed: no factor is known then. The moments across them always follow from the masses.
        """
        moments = gravity_moments(robot, q, self.gravity, self.payload)
        if efforts is not None and not robot.masses_assumed:
            moments[:, : q.shape[1]] = efforts
        return Samples(q, moments, clocks)


STANDARD_LOAD = Load(STANDARD_GRAVITY, 0.0)
"""An arm that stands upright and carries nothing beyond its ball."""

"""The arm that recorded samples, in rows: balls, linear about a fit, and effects under the load."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ...identification.data import STANDARD_LOAD, Known, Load, Measurement, Samples
from ...identification.effects import CURVE, EFFECTS, GAIN, Effect
from ...identification.model import ExtendedModel, Prediction, design_matrix, extend
from ...identification.robot import Parameter, Robot, crude_bodies
from ...results import rms
from .samples import Seat, SeatSamples, samples_of, seats_of

SMALLEST_TURN = 1e-6
"""Least turn of the joints that is reckoned with where an effect hardly shows [rad]."""


@dataclass(frozen=True, kw_only=True)
class LoadedArm:
    """Samples of an arm under a load, about a fit of its geometry.

    Rows are those of all samples, seat after seat, and then of the known distances.
    """

    robot: Robot
    parameters: tuple[Parameter, ...]
    x: np.ndarray
    """Change of the geometry, and joint offsets if any, at which all is linear, shape (n,)."""
    load: Load = STANDARD_LOAD
    """Gravity and payload, as given."""
    zeros: bool = False
    """True where joints have offsets of degrees, and gears have play."""
    wide: float = 1.0
    """Factor on the usual sizes of elasticity and transmission error."""
    measurements: tuple[Measurement, ...]
    known: tuple[Known[int], ...]
    """Known distances, by indices of sockets."""
    numbers: np.ndarray
    """Number of each sample in its socket, from 0; some may have been left out, shape (N,)."""
    readings: np.ndarray | None = None
    """Corrected joint positions, shape (N, m); None for those recorded."""

    @cached_property
    def samples(self) -> SeatSamples:
        """Joint positions, the seats of the balls, and what instruments measured."""
        recorded = samples_of(self.measurements)
        if self.readings is None:
            return recorded
        return replace(recorded, q=self.readings)

    @property
    def q(self) -> np.ndarray:
        """Joint positions, shape (N, m)."""
        return self.samples.q

    @property
    def sockets(self) -> np.ndarray:
        """Index of each sample's seat, shape (N,)."""
        return self.samples.sockets

    @property
    def frames(self) -> list[int]:
        """Indices of the seats that are frames of instruments."""
        return self.samples.frames

    @cached_property
    def labels(self) -> tuple[Seat, ...]:
        """Placement and number of each socket; then the frames of instruments."""
        labels, _ = seats_of(self.measurements)
        return labels

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Samples of each placement."""
        counts = [len(m.positions) for m in self.measurements]
        ends = np.cumsum([0, *counts]).tolist()
        return tuple(slice(*bounds) for bounds in pairwise(ends))

    @property
    def ranks(self) -> tuple[np.ndarray, ...]:
        """Rank of each sample of each placement in the order of recording."""
        return tuple(m.order for m in self.measurements)

    @property
    def every(self) -> slice:
        """All samples."""
        return slice(0, len(self.q))

    @property
    def all_samples(self) -> slice:
        """The rows of all samples' residuals."""
        return self.rows(self.every)

    @property
    def all_lengths(self) -> slice:
        """The rows of the residuals of known distances."""
        first = self.all_samples.stop
        return slice(first, first + len(self.known))

    def rows(self, samples: slice) -> slice:
        """Return the rows of some samples' residuals."""
        return slice(3 * samples.start, 3 * samples.stop)

    def in_rows(
        self,
        rows: slice,
        columns: np.ndarray,
    ) -> np.ndarray:
        """Return columns, or a shift, of some rows as those of all residuals, (3 N + K, ...)."""
        full = np.zeros((self.all_lengths.stop, *columns.shape[1:]))
        full[rows] = columns
        return full

    def measured(self, placement: str) -> Measurement:
        """Return a placement by its name."""
        return next(m for m in self.measurements if m.name == placement)

    def named(self, place: int) -> dict[str, str]:
        """Return the name of a placement, as a parameter of explanations."""
        return {"placement": self.measurements[place].name}

    def sample(
        self,
        place: int,
        rank: int,
    ) -> dict[str, Any]:
        """Return placement, socket, index in it, and the numbers as recorded, of a sample.

        It has a rank in its placement. A point that an instrument measured has its number in the
        recording, too, from 1.
        """
        row = self.places[place].start + np.argmax(self.ranks[place] == rank)
        recorded = self.measurements[place].placement.samples[rank]
        names = {
            **self.named(place),
            "socket": recorded.socket,
            "sample": int(self.numbers[row]),
            "number": recorded.number,
            "place": recorded.place,
        }
        if recorded.point is not None:
            names["point"] = rank + 1
        return names

    # Balls, by the model about which all is linear

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Effects beyond the geometry that a sound arm may have; curves need more samples."""
        return tuple(
            effect
            for effect in EFFECTS.values()
            if effect not in (CURVE, GAIN) and (self.zeros or effect.learned)
        )

    @cached_property
    def model(self) -> ExtendedModel:
        """Geometry and effects as one model."""
        return extend(
            self.robot, self.parameters, [effect.name for effect in self.effects]
        )

    @cached_property
    def start(self) -> np.ndarray:
        """Unknowns of the model at which all is linear."""
        of_effects = np.zeros(self.model.size - len(self.x))
        return np.append(self.x, of_effects)

    @cached_property
    def linear(self) -> Prediction:
        """Balls, and their derivatives by geometry and effects, and by joints."""
        return self.model.linearise(self.start, self.loaded_samples)

    @cached_property
    def by_geometry(self) -> np.ndarray:
        """Derivatives of the residuals of samples by the geometry, shape (3 N, n)."""
        n = len(self.parameters)
        slopes = -self.linear.by_unknowns[:, :, :n]
        return slopes.reshape(-1, n)

    @cached_property
    def by_joints(self) -> np.ndarray:
        """Derivatives of the balls by the joints' readings, shape (N, 3, m)."""
        if not self.zeros:
            return self.linear.by_joints
        # with play, those are as noisy as each joint is
        n, m = len(self.parameters), self.q.shape[1]
        return self.linear.by_unknowns[:, :, n : n + m]

    # Effects beyond the geometry

    @cached_property
    def heavy(self) -> Robot:
        """The robot; without masses with crude ones, since it bends as well."""
        bodies = self.robot.bodies or crude_bodies(self.robot.joints)
        return replace(self.robot, bodies=bodies)

    @cached_property
    def loaded_samples(self) -> Samples:
        """All samples as effects see them; moments are those that hold the joints as fitted."""
        return self.samples_under(self.load)

    def samples_under(self, load: Load) -> Samples:
        """Return all samples as effects would see them under a load."""
        measurements = self.measurements
        if self.zeros:  # they decide on which side of its play a joint rests
            zeros = self.x[len(self.parameters) :]
            measurements = [m.shifted(zeros) for m in measurements]
        return replace(load.samples(self.heavy, *measurements), q=self.q)

    @cached_property
    def by_readings(self) -> np.ndarray:
        """Derivatives of the balls by true positions and tilts, whatever the load, (N, 3, 3 m)."""
        coefficients = self.start[len(self.parameters) :]
        true = design_matrix(self.effects, self.loaded_samples).true_positions(
            self.q, coefficients
        )
        return self.model.ball.linearise(self.model.values(self.start), true).by_joints

    def of_effects(self, samples: Samples) -> np.ndarray:
        """Return derivatives of samples' residuals by effects, in their widths, (3 N, p)."""
        axes, turns = design_matrix(self.effects, samples)
        slopes = -self.by_readings[:, :, axes] * turns[:, None]
        return slopes.reshape(3 * len(self.q), -1) * self.widths_of_effects(samples)

    def widths_of_effects(self, samples: Samples) -> np.ndarray:
        """Return the widths of effects' coefficients by how much they turn the joints, (p,)."""
        widths = [np.zeros(0)]
        for effect in self.effects:
            turns = effect.turns(samples)
            shift = effect.typical_shift * (self.wide if effect.learned else 1.0)
            width = shift / max(rms(turns), SMALLEST_TURN)
            widths.append(np.full(turns.shape[1], width))
        return np.concatenate(widths)

    @property
    def is_elastic(self) -> np.ndarray:
        """True for coefficients of elasticity among those of effects, shape (p,)."""
        counts = [rows.stop - rows.start for rows in self.model.slices]
        return np.repeat([effect.elastic for effect in self.effects], counts)

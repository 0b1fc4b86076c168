"""A state of the search: unknowns, priors and noise, and what follows of the samples there."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...data import WORLD, Pose
from ..model import (
    Noise,
    PriorGroup,
    block_matrix,
    sample_degrees,
    sample_scales,
    student_weights,
)
from .objective import Linearization, Objective

FRAME_PRIOR_PRECISION = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
"""A weak prior, in 1/rad and 1/m, for frames that the data do not hold: one step then turns a frame
by 1 rad at most, and shifts it by 10 m."""


@dataclass(frozen=True)
class State:
    """State of the estimation between two iterations."""

    objective: Objective
    x: np.ndarray
    """Unknowns of the model, shape (size,)."""
    centres: np.ndarray
    """Centres of the sockets in the world, shape (S, 3) [m]."""
    frames: tuple[Pose, ...]
    """Poses of the frames in the world."""
    groups: tuple[PriorGroup, ...]
    """The priors, at their present widths."""
    noises: tuple[Noise, ...]
    """The noise of each of :attr:`.Observations.sources`, at its present size."""
    at_zero: np.ndarray
    """True where x is held at zero, shape (size,)."""
    linear: Linearization
    """The samples at x."""

    def changed(self, change: np.ndarray) -> "State":
        """Return the state after a change of all unknowns, but for its samples.

        A joint never gives way against its load: what would be below zero is held there.
        """
        size, dense = self.objective.x_size, self.objective.dense
        x, at_zero = self.x + change[:size], self.at_zero.copy()
        for group in self.groups:
            if group.non_negative:
                at_zero[group.members] = x[group.members] <= 0
        x[at_zero] = 0.0
        frames = tuple(map(Pose.moved, self.frames, change[size:dense].reshape(-1, 6)))
        centres = self.centres + change[dense:].reshape(-1, 3)
        return replace(self, x=x, at_zero=at_zero, frames=frames, centres=centres)

    @cached_property
    def errors(self) -> np.ndarray:
        """e_i, shape (N, 3) [m]."""
        errors, data = self.linear.places.copy(), self.objective.data
        errors[data.seated] -= self.centres[data.seated_sockets]
        return errors

    def predicted_errors(self, change: np.ndarray) -> np.ndarray:
        """Return the errors after a change of all unknowns, to first order, shape (N, 3) [m]."""
        return self.errors + self.linear.by_unknowns @ change

    @cached_property
    def degrees(self) -> np.ndarray:
        """Degrees of freedom nu of each sample, shape (N,)."""
        return sample_degrees(self.noises, self.objective.data.source_of)

    @cached_property
    def inverse_scales(self) -> np.ndarray:
        """C_i^-1, shape (N, 3, 3) [1/m^2]."""
        sources = self.objective.data.source_of
        return np.linalg.inv(sample_scales(self.noises, sources, self.linear.by_joints))

    @cached_property
    def squares(self) -> np.ndarray:
        """e_i^T C_i^-1 e_i, shape (N,)."""
        return np.einsum("ni,nij,nj->n", self.errors, self.inverse_scales, self.errors)

    @cached_property
    def weights(self) -> np.ndarray:
        """w_i, robust weight of each sample (A2), shape (N,)."""
        return student_weights(self.squares, self.degrees)

    @property
    def information(self) -> np.ndarray:
        """Information of each sample relative to Gaussian noise of scale C_i, k w_i, shape (N,)."""
        return self.weights * (self.degrees + 3) / (self.degrees + 5)

    @cached_property
    def constraints(self) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives B, shape (K, n), and residuals b, (K,), of known places and distances."""
        objective, data = self.objective, self.objective.data
        rows = np.zeros((len(data.known), objective.size))
        values = np.zeros(len(data.known))
        for i, known in enumerate(data.known):
            offset = self.centres[known.second] - self.centres[known.first]
            length = float(np.linalg.norm(offset))
            rows[i, objective.of_socket(known.second)] = offset / length
            rows[i, objective.of_socket(known.first)] = -offset / length
            values[i] = length - known.distance
        slopes = [objective.whiten @ rows]
        residuals = [objective.whiten @ values]
        for located in data.located:
            row = np.zeros((3, objective.size))
            row[:, objective.of_socket(located.socket)] = np.eye(3)
            place = np.array([located.coordinates])
            if located.frame != WORLD:
                frame = self.frames[located.frame]
                row[:, objective.of_frame(located.frame)] = -frame.slopes(place)[0]
                place = frame.apply(place)
            slopes.append(row / located.deviation)
            residuals.append(
                (self.centres[located.socket] - place[0]) / located.deviation
            )
        return np.concatenate(slopes), np.concatenate(residuals)

    @cached_property
    def priors(self) -> list[tuple[PriorGroup, np.ndarray]]:
        """The groups that have a width, and which members of each are not held."""
        pairs = [(g, ~self.at_zero[g.members]) for g in self.groups if g.width]
        return [(group, mask) for group, mask in pairs if mask.any()]

    @cached_property
    def free(self) -> np.ndarray:
        """True for all unknowns that are not held at zero, shape (n,)."""
        mask = np.arange(self.objective.size) >= self.objective.x_size
        for group, members in self.priors:
            mask[group.members[members]] = True
        return mask

    @property
    def bounded(self) -> np.ndarray:
        """True for all unknowns that cannot be below zero, shape (n,)."""
        bounded = np.zeros(self.objective.size, dtype=bool)
        for group in self.groups:
            bounded[group.members] = group.non_negative and group.width > 0
        return bounded

    def prior_precision(self, *, widened: bool = False) -> np.ndarray:
        """Return P of all unknowns, shape (n, n)."""
        blocks = list[tuple[np.ndarray, np.ndarray]]()
        for group, mask in self.priors:
            width = group.deviation if widened else group.width
            blocks.append((group.members[mask], group.precision(width, mask)))
        P = block_matrix(self.objective.size, blocks)
        frames = np.arange(self.objective.x_size, self.objective.dense)
        P[frames, frames] = np.tile(FRAME_PRIOR_PRECISION**2, len(self.frames))
        return P

    @property
    def padded(self) -> np.ndarray:
        """The unknowns x, followed by a zero for each of frames and sockets, shape (n,)."""
        return np.pad(self.x, (0, self.objective.size - len(self.x)))

    @cached_property
    def offset(self) -> np.ndarray:
        """Distance x - mu from the means of the priors, zero without one, shape (n,)."""
        offset = self.padded
        for group in self.groups:
            if group.width:
                offset[group.members] -= group.mean
        return offset

    def value(self, volume: float = 1.0) -> float:
        """Return L of (A1), but for a constant; ``volume`` is a factor of its last term."""
        sizes, nu = -np.linalg.slogdet(self.inverse_scales)[1], self.degrees
        cost = 0.5 * float(np.sum(sizes + (nu + 3) * np.log1p(self.squares / nu)))
        cost += 0.5 * float(np.sum(self.constraints[1] ** 2))
        for group in self.groups:
            if group.width:
                offset = self.offset[group.members]
                cost += 0.5 * float(offset @ group.precision(group.width) @ offset)
        return cost + volume * (self.linear.volume - self.objective.nominal_volume)

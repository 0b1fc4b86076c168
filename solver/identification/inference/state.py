"""A state of the search: unknowns, priors and noise, and what follows of the samples there."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..data import WORLD, Located, Pose, common_precision
from ..model import (
    Noise,
    PriorGroup,
    block_matrix,
    information_of,
    sample_degrees,
    sample_scales,
    student_weights,
)
from .arrow import Form
from .objective import Linearization, Objective, linearise

FRAME_PRIOR_PRECISION = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
"""A weak prior, in 1/rad and 1/m, for frames that the data do not hold: one step then turns a frame
by 1 rad at most, and shifts it by 10 m."""


class Constraints(NamedTuple):
    """K residuals of measured places and distances, each with a standard deviation of 1."""

    jacobian: np.ndarray
    """B, derivatives by all unknowns, shape (K, n)."""
    residuals: np.ndarray
    """b, shape (K,)."""


class FreePrior(NamedTuple):
    """A prior with a width, and those of its members that are not held at zero."""

    group: PriorGroup
    mask: np.ndarray
    """True for these members."""

    @property
    def members(self) -> np.ndarray:
        """Their indices among the unknowns."""
        return self.group.members[self.mask]

    def precision(self, width: float) -> np.ndarray:
        """Return their prior precision P_g at a width s_g."""
        return self.group.precision(width, self.mask)


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
        x_size, dense = self.objective.x_size, self.objective.dense
        x = self.x + change[:x_size]
        at_zero = self.at_zero.copy()
        for group in self.groups:
            if group.non_negative:
                at_zero[group.members] = x[group.members] <= 0
        x[at_zero] = 0.0
        of_frames = change[x_size:dense].reshape(-1, 6)
        frames = tuple(map(Pose.moved, self.frames, of_frames))
        of_centres = change[dense:].reshape(-1, 3)
        return replace(
            self,
            x=x,
            at_zero=at_zero,
            frames=frames,
            centres=self.centres + of_centres,
        )

    def linearised(self) -> "State":
        """Return the state with its samples at x."""
        linear = linearise(self.objective, self.x, self.frames)
        return replace(self, linear=linear)

    @property
    def without_slopes(self) -> "State":
        """The state without the samples' derivatives, which are large."""
        linear = replace(self.linear, by_unknowns=np.zeros((0, 3, 0)))
        return replace(self, linear=linear)

    @cached_property
    def errors(self) -> np.ndarray:
        """e_i, shape (N, 3) [m]."""
        data = self.objective.data
        errors = self.linear.places.copy()
        errors[data.seated] -= self.centres[data.seated_sockets]
        return errors

    def predicted_errors(self, change: np.ndarray) -> np.ndarray:
        """Return the errors after a change of all unknowns, to first order, shape (N, 3) [m]."""
        dense = self.objective.dense
        errors = self.errors + self.linear.by_unknowns @ change[:dense]
        data = self.objective.data
        errors[data.seated] -= change[dense:].reshape(-1, 3)[data.seated_sockets]
        return errors

    @cached_property
    def degrees(self) -> np.ndarray:
        """Degrees of freedom nu of each sample, shape (N,)."""
        return sample_degrees(self.noises, self.objective.data.source_of)

    @cached_property
    def inverse_scales(self) -> np.ndarray:
        """C_i^-1, shape (N, 3, 3) [1/m^2]."""
        sources = self.objective.data.source_of
        C = sample_scales(self.noises, sources, self.linear.by_joints)
        return np.linalg.inv(C)

    @cached_property
    def squares(self) -> np.ndarray:
        """e_i^T C_i^-1 e_i, shape (N,)."""
        e = self.errors
        return np.einsum("ni,nij,nj->n", e, self.inverse_scales, e)

    @cached_property
    def weights(self) -> np.ndarray:
        """w_i, robust weight of each sample (A2), shape (N,)."""
        return student_weights(self.squares, self.degrees)

    @property
    def information(self) -> np.ndarray:
        """Information of each sample relative to Gaussian noise of scale C_i, k w_i, shape (N,)."""
        return information_of(self.weights, self.degrees)

    @cached_property
    def constraints(self) -> Constraints:
        """Measured distances W (l - d), then measured places (m_k - F y_k) / s_k."""
        lengths = self._lengths
        W = self.objective.whiten
        slopes = [W @ lengths.jacobian]
        residuals = [W @ lengths.residuals]
        for place in self.objective.data.located:
            error = self._place_error(place)
            slopes.append(error.jacobian / place.deviation)
            residuals.append(error.residuals / place.deviation)
        return Constraints(np.concatenate(slopes), np.concatenate(residuals))

    @property
    def form(self) -> Form:
        """Which unknowns the samples and the measured distances couple."""
        F = self._lengths.jacobian.T @ common_precision(self.objective.data.known)
        return Form(self.objective.cells, F)

    @cached_property
    def _lengths(self) -> Constraints:
        """Errors l_k - d_k of distances between sockets [m], and their derivatives."""
        objective, distances = self.objective, self.objective.data.known
        jacobian = np.zeros((len(distances), objective.size))
        errors = np.zeros(len(distances))
        for k, measured in enumerate(distances):
            a, b = measured.first, measured.second
            offset = self.centres[b] - self.centres[a]
            length = float(np.linalg.norm(offset))
            direction = offset / length
            jacobian[k, objective.of_socket(b)] = direction
            jacobian[k, objective.of_socket(a)] = -direction
            errors[k] = length - measured.distance
        return Constraints(jacobian, errors)

    def _place_error(self, place: Located[int, int]) -> Constraints:
        """Return the error m_k - F y_k of a socket's place [m], and its derivatives."""
        objective = self.objective
        of_socket = objective.of_socket(place.socket)
        jacobian = np.zeros((3, objective.size))
        jacobian[:, of_socket] = np.eye(3)
        y = np.array([place.coordinates])
        if place.frame != WORLD:
            of_frame = objective.of_frame(place.frame)
            F = self.frames[place.frame]
            jacobian[:, of_frame] = -F.slopes(y)[0]
            y = F.apply(y)
        error = self.centres[place.socket] - y[0]
        return Constraints(jacobian, error)

    @cached_property
    def priors(self) -> list[FreePrior]:
        """The priors of all unknowns that are not held at zero."""
        priors: list[FreePrior] = []
        for group in self.groups:
            mask = ~self.at_zero[group.members]
            if group.width and mask.any():
                priors.append(FreePrior(group, mask))
        return priors

    @cached_property
    def free(self) -> np.ndarray:
        """True for all unknowns that are not held at zero, shape (n,)."""
        mask = np.arange(self.objective.size) >= self.objective.x_size
        for prior in self.priors:
            mask[prior.members] = True
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
        blocks: list[tuple[np.ndarray, np.ndarray]] = []
        for prior in self.priors:
            group = prior.group
            width = group.deviation if widened else group.width
            blocks.append((prior.members, prior.precision(width)))
        objective = self.objective
        P = block_matrix(objective.size, blocks)
        of_frames = np.arange(objective.x_size, objective.dense)
        of_frame = FRAME_PRIOR_PRECISION**2
        P[of_frames, of_frames] = np.tile(of_frame, len(self.frames))
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
        """Return L of (A1), but for a constant; ``volume`` is a factor of its last term.

        A sample's t(e; C) is (ln |C| + (nu + 3) ln(1 + e^T C^-1 e / nu)) / 2.
        """
        nu = self.degrees
        log_determinants = -np.linalg.slogdet(self.inverse_scales)[1]
        log_kernels = (nu + 3) * np.log1p(self.squares / nu)
        value = 0.5 * float(np.sum(log_determinants + log_kernels))
        b = self.constraints.residuals
        value += 0.5 * float(b @ b)
        for group in self.groups:
            if group.width:
                offset = self.offset[group.members]
                P = group.precision(group.width)
                value += 0.5 * float(offset @ P @ offset)
        shrinkage = self.linear.volume.value - self.objective.nominal_volume
        return value + volume * shrinkage

"""Errors of the readings of bases' lengths, which placements of a base share; and such lengths."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..identification.data import (
    CALIPER_DEVIATION,
    SEAT_DEVIATION,
    Measurement,
    Samples,
    distance_covariance,
)
from ..identification.inference import Posterior
from .projections import unit, variances_of
from .uncertainty import covariance_of

CORRELATED = 3
"""Variance of the mean of samples in a socket, relative to that of independent ones: the errors of
a sample and the next are correlated by about a half."""


class SocketMean(NamedTuple):
    """Mean of the balls in one socket."""

    centre: np.ndarray
    """Shape (3,) [m]."""
    slopes: np.ndarray
    """Its derivatives by the model's unknowns, shape (3, size)."""
    noise: np.ndarray
    """Its covariance by the samples' noise, shape (3, 3) [m^2]."""

    @classmethod
    def of(
        cls,
        posterior: Posterior,
        samples: Samples,
    ) -> "SocketMean":
        """Return that of samples, whose noise counts as correlated."""
        points, J, by_joints = posterior.linearise(samples)
        noise = posterior.noise.as_gaussian(by_joints)
        return cls(
            centre=points.mean(axis=0),
            slopes=J.mean(axis=0),
            noise=CORRELATED * noise.mean(axis=0) / len(points),
        )


class BaseLength(NamedTuple):
    """Distance between the mean balls of two sockets."""

    value: float
    """[m]."""
    slope: np.ndarray
    """Its derivatives by the model's unknowns, shape (size,)."""
    noise: float
    """Its variance by the samples' noise [m^2]."""

    @classmethod
    def of(
        cls,
        first: SocketMean,
        second: SocketMean,
    ) -> "BaseLength":
        """Return that between two sockets."""
        offset = second.centre - first.centre
        value = float(np.linalg.norm(offset))
        u = unit(offset)
        slope = u @ (second.slopes - first.slopes)
        noise = u @ (first.noise + second.noise) @ u
        return cls(value, slope, float(noise))

    @classmethod
    def at(
        cls,
        posterior: Posterior,
        by_socket: Sequence[Samples],
    ) -> "BaseLength":
        """Return that between the first two sockets of some samples."""
        means = [SocketMean.of(posterior, samples) for samples in by_socket[:2]]
        return cls.of(*means)


ROUNDING = 1e-12
"""Share of the largest eigenvalue of a correlation matrix below which one is rounding."""


class KnownLengths(NamedTuple):
    """K known distances by a fit with S sockets."""

    lengths: np.ndarray
    """Shape (K,) [m]."""
    slopes: np.ndarray
    """U, their derivatives by the sockets' centres, shape (K, 3 S)."""

    @classmethod
    def of(cls, posterior: Posterior) -> "KnownLengths":
        """Return those of a fit."""
        known, centres = posterior.data.known, posterior.centres
        sockets = np.eye(len(centres))
        first = [length.first for length in known]
        second = [length.second for length in known]
        ends = sockets[second] - sockets[first]
        offsets = ends @ centres
        slopes = ends[:, :, None] * unit(offsets)[:, None]
        lengths = np.linalg.norm(offsets, axis=1)
        return cls(lengths, slopes.reshape(len(known), centres.size))


@dataclass(frozen=True)
class BaseErrors:
    """Knowledge by a fit of the errors z of h bases' readings, in their standard deviations.

    Where the model's unknowns change by d, z is m + B d + v^1/2 n with n standard normal.
    Placements whose stated distances are equal stand on one base. With l - d = F z + .. the errors
    of the fit's K distances and C their covariance, W = F^T C^-1 is what they tell of z.
    """

    posterior: Posterior
    distances: tuple[float, ...]
    """Stated distance of each base [m]."""

    @staticmethod
    def of(
        posterior: Posterior,
        placements: Sequence[Measurement],
    ) -> "BaseErrors":
        """Return those of the bases of some placements."""
        distances = {m.distance for m in placements if m.has_distance}
        return BaseErrors(posterior, tuple(sorted(distances)))

    @cached_property
    def mean(self) -> np.ndarray:
        """M = W (l - d), shape (h,)."""
        distances = [length.distance for length in self.posterior.data.known]
        return self._W @ (self._known.lengths - distances)

    @cached_property
    def slopes(self) -> np.ndarray:
        """B = W S_lx S_xx^-1, shape (h, size), of the distances l and the unknowns x."""
        S = self.posterior.of_unknowns
        size = len(S)
        deviations = np.sqrt(np.diag(S))
        scale = np.divide(1, deviations, out=np.zeros(size), where=deviations > 0)
        correlations = scale[:, None] * S * scale
        inverse = np.linalg.pinv(correlations, rcond=ROUNDING, hermitian=True)
        across = self._by_centres @ self.posterior.covariance[size:, :size]
        return ((across * scale) @ inverse) * scale

    @cached_property
    def variances(self) -> np.ndarray:
        """V = diag(1 - W F + W S_ll W^T - B S_xx B^T), shape (h,)."""
        size = self.posterior.model.size
        of_centres = self.posterior.covariance[size:, size:]
        by_lengths = variances_of(self._by_centres, of_centres)
        before = 1 - np.sum(self._W * self._F.T, axis=1)
        by_unknowns = variances_of(self.slopes, self.posterior.of_unknowns)
        return before + (by_lengths - by_unknowns).clip(min=0)

    def error_of(self, measured: Measurement) -> np.ndarray:
        """Return by how much each z makes the stated distance of a placement too small, (h,) [m].

        That is its caliper's deviation for its own base, and zero for the others.
        """
        is_same = np.equal(self.distances, measured.distance)
        return is_same * (measured.distance_deviation or CALIPER_DEVIATION)

    @cached_property
    def _F(self) -> np.ndarray:
        """F, shape (K, h) [m]."""
        known = self.posterior.data.known
        F = np.zeros((len(known), len(self.distances)))
        for row, length in zip(F, known, strict=True):
            if length.on_base:
                is_same = np.equal(self.distances, length.distance)
                row[is_same] = length.deviation
        return F

    @cached_property
    def _W(self) -> np.ndarray:
        """W, shape (h, K) [1/m]."""
        C = distance_covariance(self.posterior.data.known)
        return np.linalg.solve(C, self._F).T

    @cached_property
    def _known(self) -> KnownLengths:
        """The fit's distances."""
        return KnownLengths.of(self.posterior)

    @property
    def _by_centres(self) -> np.ndarray:
        """W U, shape (h, 3 S) [1/m]."""
        return self._W @ self._known.slopes


def length_deviation(
    bases: BaseErrors,
    length: BaseLength,
    measured: Measurement,
) -> float:
    """Return the standard deviation of a placement's distance error by the full model [m].

    The error, length less stated distance, is - s d + f z, with s the length's slope and f of
    :meth:`BaseErrors.error_of`, beside the noise of both. Before any data z has a variance of 1.
    """
    S = covariance_of(bases.posterior)
    f, B = bases.error_of(measured), bases.slopes
    s = length.slope - f @ B
    by_unknowns = variances_of(B, S).clip(max=1.0)
    seat = min(SEAT_DEVIATION, float(f.max()))
    variance = s @ S @ s + f**2 @ (1 - by_unknowns) + length.noise + seat**2
    return float(variance) ** 0.5

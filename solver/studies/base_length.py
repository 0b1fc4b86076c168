"""The distance between two sockets by the model, and how sure it is."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..identification.data import Samples
from ..identification.inference import Posterior

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
    def of(cls, posterior: Posterior, samples: Samples) -> "SocketMean":
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
    def of(cls, first: SocketMean, second: SocketMean) -> "BaseLength":
        """Return that between two sockets."""
        offset = second.centre - first.centre
        value = float(np.linalg.norm(offset))
        u = offset / max(value, 1e-12)
        slope = u @ (second.slopes - first.slopes)
        noise = u @ (first.noise + second.noise) @ u
        return cls(value, slope, float(noise))

    @classmethod
    def at(cls, posterior: Posterior, by_socket: Sequence[Samples]) -> "BaseLength":
        """Return that between the first two sockets of some samples."""
        means = [SocketMean.of(posterior, samples) for samples in by_socket[:2]]
        return cls.of(*means)

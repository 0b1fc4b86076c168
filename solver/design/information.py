"""Covariance of an arm's unknowns after samples, before they are taken.

What a sample teaches depends on where the arm stands, not on how large its error comes out. With
Sigma the covariance of all unknowns (the geometry x, and the centre of each socket), a sample in
socket s whose ball moves by J with x adds to the information

    Sigma'^-1 = Sigma^-1 + A^T C^-1 A            A = [J, 0, -I at socket s, 0]            (D1)

with C the noise of a sample. A calibration is for distances in the workspace: with g_k the
derivative of the distance between the k-th of K random pairs of poses by x, their mean variance is
tr(Sigma G) with G = sum_k g_k g_k^T / K, and one more sample lowers it by

    tr(S^-1 (A Sigma) G (A Sigma)^T)             S = A Sigma A^T + C                      (D2)

The sample that lowers it most is the best next one (I-optimal design, chosen greedily; Fedorov
1972; for robots Sun and Hollerbach 2008).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..identification.data import Observations, Samples
from ..identification.inference import Posterior
from ..identification.model import (
    ExtendedModel,
    Noise,
    PriorGroup,
    prior_covariance,
    prior_groups,
)
from ..identification.robot import workspace
from ..studies import distance_slopes, variances_of

CENTRE = 1.0
"""Standard deviation of where a socket is before the first sample in it [m]."""


@dataclass(frozen=True)
class Workspace:
    """Distances between random pairs of poses, or other numbers, by which samples are judged."""

    slopes: np.ndarray
    """g_k, derivatives of the distances by the model's unknowns, shape (K, size)."""
    lengths: np.ndarray
    """The distances, shape (K,) [m]; 0 for other numbers."""

    @cached_property
    def judged(self) -> np.ndarray:
        """F with F F^T = G of (D2), shape (size, 1 + min(K, size)).

        Its first column is the arm's scale, and the others are what the distances are relative to
        each other. All samples tell the scale alike, by the base's length. Poses differ in what
        they tell of all else, so they are chosen by the others.
        """
        length = np.linalg.norm(self.lengths) or 1.0
        along = self.lengths / length
        scale = along @ self.slopes
        relative = self.slopes - np.outer(along, scale)
        rows = np.vstack([scale, np.linalg.qr(relative, mode="r")])
        return rows.T / len(self.slopes) ** 0.5


def workspace_of(
    model: ExtendedModel,
    x: np.ndarray,
    pairs: int = 200,
) -> Workspace:
    """Return random pairs of poses within the joints' limits."""
    q = workspace(model.robot, 2 * pairs)
    lengths, slopes = distance_slopes(model, x, Samples.unloaded(q))
    return Workspace(slopes, lengths)


@dataclass(frozen=True)
class ParameterCovariance:
    """Covariance of the unknowns of an arm and of the sockets' centres."""

    model: ExtendedModel
    x: np.ndarray
    """Point at which the model is linearised, shape (size,)."""
    noise: Noise
    covariance: np.ndarray
    """Sigma of x and the centres of S sockets, shape (size + 3 S, size + 3 S)."""

    @property
    def sockets(self) -> int:
        """Number of sockets."""
        return (len(self.covariance) - self.model.size) // 3

    def error(self, where: Workspace) -> float:
        """Return the predicted error of distances: the median of one standard deviation [m]."""
        return float(np.median(self.deviations(where)))

    def deviations(self, where: Workspace) -> np.ndarray:
        """Return the predicted standard deviation of each distance, shape (K,) [m]."""
        size = self.model.size
        return np.sqrt(variances_of(where.slopes, self.covariance[:size, :size]))

    def with_sockets(self, count: int) -> "ParameterCovariance":
        """Return the same with so many more sockets, whose centres are unknown."""
        n = len(self.covariance)
        numbers = 3 * count
        covariance = np.pad(self.covariance, (0, numbers))
        covariance[n:, n:] = CENTRE**2 * np.eye(numbers)
        return replace(self, covariance=covariance)

    def with_lengths(
        self,
        ends: Mapping[int, np.ndarray],
        deviation: float,
    ) -> "ParameterCovariance":
        """Return the same with a measured sum of lengths between sockets.

        Args:
            ends: For each socket, the sum's derivative by its centre, shape (3,): for a distance
                from socket 0 to 1 along a unit vector u, ``{0: -u, 1: u}``.
            deviation: Standard deviation of the measurement [m].
        """
        row = np.zeros((1, len(self.covariance)))
        for socket, slope in ends.items():
            row[0, self._centre(socket)] = slope / deviation
        return replace(self, covariance=updated(self.covariance, row))

    def with_samples(
        self,
        samples: Samples | np.ndarray,
        socket: int,
    ) -> "ParameterCovariance":
        """Return the same with more samples in a socket (D1).

        Of a rigid arm their joint positions are enough, shape (N, m) [rad].
        """
        rows = np.concatenate(self.whitened(samples, socket))
        return replace(self, covariance=updated(self.covariance, rows))

    def linearise(
        self,
        samples: Samples | np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return balls and derivatives, see :meth:`.ExtendedModel.linearise`."""
        if not isinstance(samples, Samples):
            samples = Samples.unloaded(samples)
        return self.model.linearise(self.x, samples)

    def whitened(
        self,
        samples: Samples | np.ndarray,
        socket: int,
    ) -> np.ndarray:
        """Return L^-1 A of (D1) for each of some samples, shape (N, 3, n), with C = L L^T."""
        _, J, by_joints = self.linearise(samples)
        A = np.zeros((len(J), 3, len(self.covariance)))
        A[:, :, : self.model.size] = J
        A[:, :, self._centre(socket)] = -np.eye(3)
        L = np.linalg.cholesky(self.noise.as_gaussian(by_joints))
        return np.linalg.inv(L) @ A

    def variance_reduction(
        self,
        q: np.ndarray,
        socket: int,
        where: Workspace,
    ) -> np.ndarray:
        """Return the shares by which each of some samples would lower the mean variance (D2).

        Args:
            q: Their configurations, shape (N, m).
            socket: The socket that the ball would be in.
            where: Distances by which they are judged.

        Returns:
            With the arm's scale and without it, shape (2, N).
        """
        samples = Prospect.of(self.covariance, self.whitened(q, socket), where.judged)
        return (
            1
            - samples.mean_variances
            / with_and_without_scale(samples.variances)[:, None]
        )

    def _centre(self, socket: int) -> slice:
        """Return where a socket's centre stands among the unknowns."""
        begin = self.model.size + 3 * socket
        return slice(begin, begin + 3)


def updated(
    covariance: np.ndarray,
    A: np.ndarray,
    sign: int = 1,
) -> np.ndarray:
    """Return a covariance after measurements with derivatives A and noise 1 (Kalman's update).

        S = A Sigma A^T + 1    K = Sigma A^T S^-1    Sigma' = (1 - K A) Sigma (1 - K A)^T + K K^T

    (Joseph's form), in which an error of K counts to second order only, so that it stays a
    covariance. With sign -1 in the place of both +, without measurements that are in it.
    """
    cross = A @ covariance
    noise = sign * np.eye(len(A))
    K = np.linalg.solve(cross @ A.T + noise, cross).T
    reduced = covariance - K @ cross
    by_noise = sign * K @ K.T
    by_gain = (reduced @ A.T) @ K.T
    result = reduced - by_gain + by_noise
    return 0.5 * (result + result.T)


class Prospect(NamedTuple):
    """N samples before they are taken, and J numbers by which they are judged."""

    cross: np.ndarray
    """A Sigma F of (D2), shape (N, 3, J)."""
    S: np.ndarray
    """S of (D2), shape (N, 3, 3)."""
    variances: np.ndarray
    """Of the numbers so far, the diagonal of F^T Sigma F, shape (J,)."""

    @classmethod
    def of(
        cls,
        covariance: np.ndarray,
        A: np.ndarray,
        F: np.ndarray,
    ) -> "Prospect":
        """Return that of samples with whitened rows A, shape (N, 3, n), for F, (size, J)."""
        size = len(F)
        across = A @ covariance
        of_samples = across @ A.swapaxes(1, 2)
        by_numbers = covariance[:size, :size] @ F
        return cls(
            cross=across[:, :, :size] @ F,
            S=of_samples + np.eye(3),
            variances=np.sum(F * by_numbers, axis=0),
        )

    @property
    def mean_variances(self) -> np.ndarray:
        """Both mean variances after each sample, shape (2, N)."""
        weighted = np.linalg.inv(self.S) @ self.cross
        return with_and_without_scale(
            self.variances - np.sum(self.cross * weighted, axis=1)
        )


def with_and_without_scale(variances: np.ndarray) -> np.ndarray:
    """Return both sums of variances of :attr:`.Workspace.judged`, (..., J), shape (2, ...)."""
    relative = variances[..., 1:].sum(axis=-1)
    return np.stack([relative + variances[..., 0], relative])


def from_prior(
    model: ExtendedModel,
    noise: Noise,
    sockets: int,
) -> ParameterCovariance:
    """Return the covariance of a rigid arm before the first sample in so many sockets."""
    nominal = np.zeros(model.size)
    state = ParameterCovariance(
        model, nominal, noise, prior_covariance(expected_groups(model), model.size)
    )
    return state.with_sockets(sockets)


def from_fit(posterior: Posterior) -> ParameterCovariance:
    """Return the covariance after a fit."""
    return ParameterCovariance(
        posterior.model, posterior.x, posterior.noise, posterior.covariance
    )


def expected_groups(model: ExtendedModel) -> tuple[PriorGroup, ...]:
    """Return the priors of a rigid arm's geometry before anything is measured."""
    return prior_groups(model, Observations.none(len(model.robot.actuated)))

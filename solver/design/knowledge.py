"""What is known of an arm after some samples, and what further samples would add.

What a sample teaches does not depend on how large its error comes out, only on where the arm
stands, so it can be told beforehand. With Sigma the covariance of all unknowns (the geometry x, and
the centre of each socket), a sample in socket s whose ball moves by J with x adds to the
information

    Sigma'^-1 = Sigma^-1 + A^T C^-1 A            A = [J, 0, -I at socket s, 0]            (D1)

with C the noise of a sample. What a calibration is for are distances in the workspace: with g_k the
derivative of the distance between the k-th of K random pairs of poses by x, their mean variance is
tr(Sigma G) with G = sum_k g_k g_k^T / K, and one more sample lowers it by

    tr(S^-1 (A Sigma) G (A Sigma)^T)             S = A Sigma A^T + C                      (D2)

The sample that lowers it most is the best next one (I-optimal design, chosen greedily; Fedorov
1972; for robots Sun and Hollerbach 2008).
"""

from dataclasses import dataclass, replace

import numpy as np

from ..bayes.inference import Posterior
from ..bayes.model import ExtendedModel, Noise, PriorGroup
from ..robot import workspace

CENTRE = 1.0
"""Standard deviation of where a socket is before the first sample in it [m]."""


@dataclass(frozen=True)
class Rows:
    """Some configurations: how the ball moves there."""

    by_unknowns: np.ndarray
    """J, shape (N, 3, size)."""
    by_joints: np.ndarray
    """Derivatives by the joint positions, shape (N, 3, m)."""


@dataclass(frozen=True)
class Workspace:
    """Distances between random pairs of poses, by which a calibration is judged."""

    slopes: np.ndarray
    """g_k, derivatives of the distances by the model's unknowns, shape (K, size)."""
    lengths: np.ndarray
    """The distances, shape (K,) [m]."""

    @property
    def mean(self) -> np.ndarray:
        """G, shape (size, size)."""
        return self.slopes.T @ self.slopes / len(self.slopes)

    @property
    def shape(self) -> np.ndarray:
        """G of the distances relative to each other, the arm's scale left out, shape (size, size).

        The scale is known by the base's length, and by how many samples there are. Poses differ in
        what they tell of all else, so they are chosen by this.
        """
        scale = self.lengths @ self.slopes / (self.lengths @ self.lengths)
        slopes = self.slopes - np.outer(self.lengths, scale)
        return slopes.T @ slopes / len(slopes)


def rows_at(model: ExtendedModel, x: np.ndarray, q: np.ndarray) -> Rows:
    """Return how the ball moves at some configurations of a rigid arm, shape (N, m)."""
    _, by_unknowns, by_joints = model.linearise(x, q, np.zeros((len(q), 2 * q.shape[1])))
    return Rows(by_unknowns, by_joints)


def workspace_of(model: ExtendedModel, x: np.ndarray, pairs: int = 200) -> Workspace:
    """Return random pairs of poses within the joints' limits."""
    q = workspace(model.robot, 2 * pairs)
    points, by_unknowns, _ = model.linearise(x, q, np.zeros((len(q), 2 * q.shape[1])))
    offset = points[1::2] - points[::2]
    lengths: np.ndarray = np.linalg.norm(offset, axis=1).clip(1e-12)
    direction = offset / lengths[:, None]
    slopes = np.einsum("ni,nij->nj", direction, by_unknowns[1::2] - by_unknowns[::2])
    return Workspace(slopes, lengths)


@dataclass(frozen=True)
class ParameterCovariance:
    """How well the unknowns of a rigid arm and the sockets' centres are known."""

    model: ExtendedModel
    x: np.ndarray
    """Where the model is linearised, shape (size,)."""
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
        own = self.covariance[:size, :size]
        return np.sqrt(np.einsum("ni,ij,nj->n", where.slopes, own, where.slopes))

    def with_socket(self) -> "ParameterCovariance":
        """Return the same with one more socket, of which nothing is known yet."""
        n = len(self.covariance)
        covariance = np.zeros((n + 3, n + 3))
        covariance[:n, :n] = self.covariance
        covariance[n:, n:] = CENTRE**2 * np.eye(3)
        return replace(self, covariance=covariance)

    def with_lengths(self, ends: dict[int, np.ndarray], deviation: float) -> "ParameterCovariance":
        """Return the same with a measured sum of lengths between sockets.

        Args:
            ends: For each socket, by how much the sum changes with its centre, shape (3,): for a
                distance from socket 0 to 1 along a unit vector u, ``{0: -u, 1: u}``.
            deviation: Standard deviation of the measurement [m].
        """
        row = np.zeros((1, len(self.covariance)))
        for socket, slope in ends.items():
            begin = self.model.size + 3 * socket
            row[0, begin : begin + 3] = slope
        return self._updated(row, np.array([[deviation**2]]))

    def with_samples(self, q: np.ndarray, socket: int) -> "ParameterCovariance":
        """Return the same with more samples in a socket.

        Args:
            q: Their configurations, shape (N, m).
            socket: Where the ball is in them.
        """
        known = self
        rows = rows_at(self.model, self.x, q)
        scales = self.noise.as_gaussian(rows.by_joints)
        for J, C in zip(rows.by_unknowns, scales, strict=True):
            known = known._updated(known._with_centre(J, socket), C)
        return known

    def gains(self, q: np.ndarray, socket: int, G: np.ndarray) -> np.ndarray:
        """Return by how much each of some samples would lower the mean variance (D2).

        Args:
            q: Their configurations, shape (N, m).
            socket: Where the ball would be.
            G: What is to be known, see :class:`Workspace`.

        Returns:
            As a share of that variance, shape (N,).
        """
        size = self.model.size
        begin = size + 3 * socket
        rows = rows_at(self.model, self.x, q)
        J, sigma = rows.by_unknowns, self.covariance
        across = J @ sigma[:size] - sigma[begin : begin + 3]  # A Sigma, shape (N, 3, n)
        S = (
            across[:, :, :size] @ J.transpose(0, 2, 1)
            - across[:, :, begin : begin + 3]
            + self.noise.as_gaussian(rows.by_joints)
        )
        own = across[:, :, :size]
        lowered = np.einsum("nij,nji->n", np.linalg.inv(S), own @ G @ own.transpose(0, 2, 1))
        return lowered / float(np.trace(sigma[:size, :size] @ G))

    def _with_centre(self, J: np.ndarray, socket: int) -> np.ndarray:
        """Return A of (D1) for one sample, shape (3, n)."""
        row = np.zeros((3, len(self.covariance)))
        row[:, : self.model.size] = J
        begin = self.model.size + 3 * socket
        row[:, begin : begin + 3] = -np.eye(3)
        return row

    def _updated(self, A: np.ndarray, C: np.ndarray) -> "ParameterCovariance":
        """Return the same after one measurement with derivatives A and noise C."""
        across = A @ self.covariance
        kept = self.covariance - across.T @ np.linalg.solve(across @ A.T + C, across)
        return replace(self, covariance=0.5 * (kept + kept.T))


def from_prior(
    model: ExtendedModel, groups: tuple[PriorGroup, ...], noise: Noise, sockets: int
) -> ParameterCovariance:
    """Return what is known before the first sample.

    Args:
        model: A rigid arm.
        groups: What is believed of its unknowns.
        noise: Of a sample.
        sockets: How many there are.
    """
    n = model.size
    covariance = CENTRE**2 * np.eye(n + 3 * sockets)
    covariance[:n] = 0.0
    for group in groups:
        covariance[np.ix_(group.members, group.members)] = group.covariance(group.width)
    return ParameterCovariance(model, np.zeros(n), noise, covariance)


def from_fit(posterior: Posterior) -> ParameterCovariance:
    """Return what is known after a fit."""
    return ParameterCovariance(posterior.model, posterior.x, posterior.noise, posterior.covariance)

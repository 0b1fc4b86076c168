"""Curvature and slope of the data's part of the objective, by blocks, and a Gauss-Newton step."""

from dataclasses import dataclass, replace

import numpy as np

from ..model import Gaussian, block_matrix, submatrix
from .state import State

REFINEMENTS = 3
"""Corrections of the step for rounding errors of the inverse. They are large where the
data show nearly nothing of one unknown, and the others very well."""


@dataclass(frozen=True)
class ArrowheadMatrix:
    """H, of d unknowns x and frames, then of S socket centres: n in all."""

    dense: np.ndarray
    """Z, shape (d, d)."""
    centres: np.ndarray
    """X_0, shape (3 S, d)."""
    own: np.ndarray
    """The blocks of D, shape (S, 3, 3)."""
    constraints: np.ndarray
    """B, shape (K, n)."""

    def plus(self, dense: np.ndarray) -> "ArrowheadMatrix":
        """Return the sum with a matrix of x and the frames alone, shape (d, d)."""
        return replace(self, dense=self.dense + dense)

    def times(self, vector: np.ndarray) -> np.ndarray:
        """Return H v, shape (n,)."""
        d = len(self.dense)
        x, m = vector[:d], vector[d:]
        of_m = _times(self.own, (m + self.centres @ x)[:, None])[:, 0]
        of_x = self.dense @ x + self.centres.T @ of_m
        return np.concatenate([of_x, of_m]) + self.constraints.T @ (self.constraints @ vector)

    def inverse(self, mask: np.ndarray) -> "Inverse":
        """Return the inverse of a positive definite H whose rows have different units."""
        d = len(mask)
        B_x, B_m = self.constraints[:, :d], self.constraints[:, d:]
        blocks = np.linalg.inv(self.own)
        G = _times(blocks, B_m.T)
        L = np.linalg.cholesky(np.eye(len(B_m)) + B_m @ G)
        V, R = np.linalg.solve(L, G.T).T, np.linalg.solve(L, B_x - B_m @ self.centres)
        block = self.dense + R.T @ R
        S = submatrix(block, mask)
        scale = 1 / np.sqrt(np.diag(S))
        units = scale[:, None] * scale
        dense = block_matrix(d, [(mask, np.linalg.inv(S * units) * units)])
        logs = [
            np.linalg.slogdet(S * units)[1],
            2 * np.log(np.diag(L)).sum(),
            -2 * np.log(scale).sum(),
        ]
        log_determinant = float(sum(logs) + np.linalg.slogdet(self.own)[1].sum())
        X = (self.centres + V @ R) * mask
        return Inverse(dense, X, blocks, V, log_determinant, block)


@dataclass(frozen=True)
class Inverse:
    """H^-1, as the parts that it is made of."""

    dense: np.ndarray
    """S^-1, the covariance of x and the frames, shape (d, d)."""
    centres: np.ndarray
    """X, shape (3 S, d)."""
    blocks: np.ndarray
    """The blocks of D^-1, shape (S, 3, 3)."""
    V: np.ndarray
    """Shape (3 S, K)."""
    log_determinant: float
    """log |H| of what is free."""
    S: np.ndarray
    """Curvature of x and the frames while the centres follow, shape (d, d)."""

    @property
    def own(self) -> np.ndarray:
        """The blocks of D^-1 - V V^T, shape (S, 3, 3)."""
        V = self.V.reshape(len(self.blocks), 3, self.V.shape[1])
        return self.blocks - V @ V.swapaxes(1, 2)

    def times(self, vector: np.ndarray) -> np.ndarray:
        """Return H^-1 v, shape (n,)."""
        d = len(self.dense)
        x, m = vector[:d], vector[d:]
        x = self.dense @ (x - self.centres.T @ m)
        m = _times(self.blocks, m[:, None])[:, 0] - self.V @ (self.V.T @ m)
        return np.concatenate([x, m - self.centres @ x])

    def gaussian(self, mean: np.ndarray, mask: np.ndarray) -> Gaussian:
        """Return the Gaussian of x and the frames, the others being zero, around a mean."""
        some = np.flatnonzero(mask)
        part = Gaussian.of_precision(mean[some], submatrix(self.S, some))
        return part.embedded(some, len(mask))

    def with_centres(self, part: Gaussian) -> Gaussian:
        """Return x, the frames and the centres by a Gaussian of x and the frames.

        Beside -X x the centres have the covariance D^-1 - V V^T. With D^-1 = E E^T and U = E^-1 V
        its root is E - V (1 + (1 - U^T U)^(1/2))^-1 U^T.
        """
        count = len(self.blocks)
        E, root = np.linalg.cholesky(self.blocks), np.zeros((3 * count, 3 * count))
        U = np.linalg.solve(E, self.V.reshape(count, 3, self.V.shape[1])).reshape(self.V.shape)
        shares, axes = np.linalg.eigh(U.T @ U)
        for k, block in enumerate(E):
            root[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = block
        root -= (self.V @ axes / (1 + np.sqrt((1 - shares).clip(min=0)))) @ (U @ axes).T
        mean = np.concatenate([part.mean, -self.centres @ part.mean])
        across = np.concatenate([part.root, -self.centres @ part.root])
        return Gaussian(
            mean, np.column_stack([across, np.eye(len(mean))[:, len(part.mean) :] @ root])
        )


def _times(blocks: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the product of a block diagonal matrix with columns, shape (3 S, columns)."""
    return (blocks @ columns.reshape(len(blocks), 3, columns.shape[1])).reshape(columns.shape)


def active_set_step(
    H: ArrowheadMatrix,
    gradient: np.ndarray,
    x: np.ndarray,
    mask: np.ndarray,
    bounded: np.ndarray,
) -> tuple[np.ndarray, Inverse]:
    """Return the step to the minimum of a quadratic function within the bounds."""
    at_bound = bounded & (x == 0) & (gradient > 0)
    change, covariance = np.zeros(len(x)), H.inverse((mask & ~at_bound)[: len(H.dense)])
    for _ in range(3 * int(bounded.sum()) + 1):
        change = np.where(at_bound, -x, 0.0)
        for _ in range(REFINEMENTS):
            change -= covariance.times(gradient + H.times(change))
        below = bounded & ~at_bound & (x + change < 0)
        slope = np.where(at_bound, gradient + H.times(change), 0.0)
        if not below.any() and not (slope < 0).any():
            break
        if below.any():
            at_bound |= below
        else:
            at_bound[np.argmin(slope)] = False
        covariance = H.inverse((mask & ~at_bound)[: len(H.dense)])
    return change, covariance


def normal_equations(state: State) -> tuple[ArrowheadMatrix, np.ndarray]:
    """Return curvature and slope of the samples' and the measured distances' part of L (A3)."""
    objective, inverse = state.objective, state.inverse_scales
    J, size = state.linear.by_unknowns, objective.dense
    weighted = inverse * state.weights[:, None, None]
    We = np.einsum("nij,nj->ni", weighted, state.errors)
    gradient = np.zeros(objective.size)
    gradient[:size] = J.reshape(-1, size).T @ We.ravel()
    gradient[size:] = -objective.data.by_socket(We).ravel()
    gradient -= _by_turning(state, We)
    B, b = state.constraints
    return curvature(state, state.information[:, None, None] * inverse), gradient + B.T @ b


def _by_turning(state: State, weighed: np.ndarray) -> np.ndarray:
    """Return the slope that errors would have if the noise did not turn along with the robot."""
    objective = state.objective
    torques, slope = np.cross(state.errors, weighed), np.zeros(objective.size)
    model = objective.model
    turning = model.ball.turns(model.values(state.x[: model.size]))
    slope[: model.geometry] = torques.sum(axis=0) @ turning
    return slope


def curvature(state: State, weighted: np.ndarray) -> ArrowheadMatrix:
    """Return sum_i [J_i, -I]^T V_i [J_i, -I] + B^T B."""
    size, data = state.objective.dense, state.objective.data
    by_centre = data.by_socket(weighted)
    centres = -np.linalg.inv(by_centre) @ data.by_socket(weighted @ state.linear.by_unknowns)
    J = _along_centres(state, centres)
    information = J.reshape(-1, size).T @ (weighted @ J).reshape(-1, size)
    return ArrowheadMatrix(information, centres.reshape(-1, size), by_centre, state.constraints[0])


def _along_centres(state: State, centres: np.ndarray) -> np.ndarray:
    """Return the errors' derivatives while the centres go along, shape (N, 3, dense)."""
    J, data = state.linear.by_unknowns.copy(), state.objective.data
    J[data.seated] += centres[data.seated_sockets]
    return J


def leverage(state: State, covariance: Inverse) -> np.ndarray:
    """Return how uncertain each error is because the unknowns are: [J_i, -I] Sigma [J_i, -I]^T."""
    dense, data = covariance.own, state.objective.data
    J = _along_centres(state, covariance.centres.reshape(len(dense), 3, state.objective.dense))
    spread = (J @ covariance.dense) @ J.transpose(0, 2, 1)
    spread[data.seated] += dense[data.seated_sockets]
    return spread


def predicted_errors(state: State, change: np.ndarray) -> np.ndarray:
    """Return the errors after a change of all unknowns, to first order, shape (N, 3) [m]."""
    size, data = state.objective.dense, state.objective.data
    errors = state.errors + state.linear.by_unknowns @ change[:size]
    errors[data.seated] -= change[size:].reshape(-1, 3)[data.seated_sockets]
    return errors

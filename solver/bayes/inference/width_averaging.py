"""The posterior averaged over the widths of the geometry's priors, as a mixture (A10)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..model import GEOMETRY_WIDTHS, TYPICAL_SPREAD, Gaussian, PriorGroup, probabilities
from .state import State

FACTORS = np.exp(TYPICAL_SPREAD * np.linspace(-3, 3, 13))
"""Widths of the mixture, as factors of the usual one: all that the prior of a width allows."""
NEGLIGIBLE = 1e-12
"""Probability of a node whose own spread is left out."""
LEAST = 1e-12
"""Deviation after the samples, in units of the usual prior, that is but rounding."""


def has_uncertain_width(group: PriorGroup) -> bool:
    """Return True for the geometry: its widths are known in a fit, and averaged over afterwards."""
    return group.learned and group.width > 0 and group.name in GEOMETRY_WIDTHS


def usual_width(group: PriorGroup) -> float:
    """Return the median of what the prior of a width allows."""
    return group.typical or GEOMETRY_WIDTHS[group.name]


def at_usual_widths(state: State) -> State:
    """Return the state with usual widths in the place of those that are uncertain."""
    groups = tuple(
        replace(group, width=usual_width(group), learned=False, average_width=0.0)
        if has_uncertain_width(group)
        else group
        for group in state.groups
    )
    return replace(state, groups=groups)


def over_widths(
    state: State, x: np.ndarray, change: Gaussian
) -> tuple[Gaussian, tuple[PriorGroup, ...]]:
    """Return a posterior averaged over uncertain widths, and the priors with their average widths.

    Args:
        state: The priors, at the widths of the estimate.
        x: The estimate, around which the result is spread.
        change: The posterior at the usual widths, as changes from the estimate.
    """
    groups = list(state.groups)
    uncertain = [k for k, group in enumerate(groups) if has_uncertain_width(group)]
    if uncertain:
        mixture = WidthMixture([groups[k] for k in uncertain])
        change, widths = mixture.posterior(x, change)
        for k, width in zip(uncertain, widths.tolist(), strict=True):
            groups[k] = replace(groups[k], average_width=width)
    spread = np.column_stack([change.root, change.mean])
    return Gaussian(np.zeros(len(spread)), spread), tuple(groups)


@dataclass(frozen=True)
class WidthMixture:
    """Priors of the geometry at K nodes: C_k = B d_k^2 B^T, with d_k diagonal."""

    groups: Sequence[PriorGroup]

    @cached_property
    def members(self) -> np.ndarray:
        """Indices of the geometry's n members among the unknowns."""
        return np.concatenate([group.members for group in self.groups])

    @cached_property
    def factors(self) -> np.ndarray:
        """Factors of each group's usual width, shape (K, groups)."""
        return np.array(list(product(FACTORS, repeat=len(self.groups))))

    @cached_property
    def widths(self) -> np.ndarray:
        """Widths of each group, shape (K, groups)."""
        return self.factors * [usual_width(group) for group in self.groups]

    @cached_property
    def directions(self) -> np.ndarray:
        """B, shape (n, r): each member by itself, then the changes that members share."""
        shared = np.zeros((len(self.members), len(self.groups)))
        for k, group in enumerate(self.groups):
            if group.common is not None:
                shared[np.isin(self.members, group.members), k] = group.common
        return np.column_stack([np.eye(len(shared)), shared[:, shared.any(axis=0)]])

    @cached_property
    def deviations(self) -> np.ndarray:
        """The diagonals of all d_k, shape (K, r)."""
        sizes = [len(group.members) for group in self.groups]
        widths, (n, r) = np.repeat(self.widths, sizes, axis=1), self.directions.shape
        return np.pad(widths, ((0, 0), (0, r - n)), constant_values=1.0)

    @property
    def usual_root(self) -> np.ndarray:
        """L_0, so that L_0 L_0^T is the prior covariance at the usual widths, shape (n, n)."""
        blocks = [group.covariance(usual_width(group)) for group in self.groups]
        C, begin = np.zeros((len(self.members),) * 2), 0
        for block in blocks:
            block_of = slice(begin, begin + len(block))
            C[block_of, block_of], begin = block, block_of.stop
        return np.linalg.cholesky(C)

    def posterior(self, x: np.ndarray, gaussian: Gaussian) -> tuple[Gaussian, np.ndarray]:
        """Return the posterior of all unknowns, and the root mean square of each group's widths.

        With the root of the members' posterior at the usual widths L_0 Q s V^T, their information
        by the data is L_0^-T Q (1 / s^2 - 1) Q^T L_0^-1. All else follows the members.

        Args:
            x: The estimate.
            gaussian: Posterior of all unknowns at the usual widths, as changes from it.
        """
        L, marginal = self.usual_root, gaussian.marginal(self.members)
        offset = x[self.members] - np.concatenate([group.mean for group in self.groups])
        Q, s, V = np.linalg.svd(np.linalg.solve(L, marginal.root))
        s = s.clip(LEAST, 1.0)
        axes = np.linalg.solve(L.T, Q)
        H = (axes * (1 / s**2 - 1)) @ axes.T
        h = (axes / s**2) @ (axes.T @ (offset + marginal.mean))
        off_mean, odds = self.moments(H, h)
        k = len(s)
        gain = (gaussian.root @ V[:k].T / s) @ axes.T
        members = gain @ off_mean.root
        mean = gain @ (off_mean.mean - offset - marginal.mean)
        root = np.column_stack([members, gaussian.root @ V[k:].T])
        return Gaussian(gaussian.mean + mean, root), np.sqrt(odds @ self.widths**2)

    def moments(self, H: np.ndarray, h: np.ndarray) -> tuple[Gaussian, np.ndarray]:
        """Return mean and spread of the members' distance from mu, and each node's probability.

            S_k = B d_k (1 + d_k B^T H B d_k)^-1 d_k B^T      m_k = mu + S_k h
            2 log Z_k = h^T S_k h - log |1 + d_k B^T H B d_k|

        Args:
            H: Information of the data, shape (n, n).
            h: H times the distance from mu that the data alone prefer, shape (n,).
        """
        B, d = self.directions, self.deviations
        N = d[:, :, None] * (B.T @ H @ B) * d[:, None] + np.eye(B.shape[1])
        L, pulls = np.linalg.cholesky(N), d * (B.T @ h)
        whitened = np.linalg.solve(L, pulls[:, :, None])[:, :, 0]
        sizes = np.log(np.diagonal(L, axis1=1, axis2=2)).sum(axis=1)
        penalty = np.sum((np.log(self.factors) / TYPICAL_SPREAD) ** 2, axis=1)
        logs = 0.5 * (np.sum(whitened**2, axis=1) - penalty) - sizes
        odds = probabilities(logs)
        likely = np.flatnonzero(odds > NEGLIGIBLE)
        shares = odds[likely]
        roots = np.linalg.inv(L[likely]) * d[likely, None] @ B.T  # R_k^T R_k = S_k
        means = (whitened[likely, None] @ roots)[:, 0]
        mean = shares @ means
        columns = np.concatenate([roots, (means - mean)[:, None]], axis=1)
        columns = (np.sqrt(shares)[:, None, None] * columns).reshape(-1, len(B))
        return Gaussian.of(mean, columns.T @ columns), odds

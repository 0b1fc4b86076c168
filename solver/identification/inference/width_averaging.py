"""The posterior averaged over the widths of the geometry's priors, as a mixture (A10)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..model import (
    GEOMETRY_WIDTHS,
    TYPICAL_SPREAD,
    Gaussian,
    PriorGroup,
    log_bayes_factor,
    prior_covariance,
    probabilities,
    submatrix,
)
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


def with_average_width(group: PriorGroup) -> PriorGroup:
    """Return a group of a stored posterior, with a width over which it may have been averaged.

    A file has the found width alone, which may have fallen to nothing while the average did not.
    The usual one, where that is larger, leaves the prior no narrower than the posterior.
    """
    if not has_uncertain_width(group):
        return group
    return replace(group, average_width=max(group.width, usual_width(group)))


def at_usual_widths(state: State) -> State:
    """Return the state with usual widths in the place of those that are uncertain."""
    groups = list(state.groups)
    for k, group in enumerate(groups):
        if has_uncertain_width(group):
            groups[k] = replace(
                group,
                width=usual_width(group),
                learned=False,
                average_width=0.0,
            )
    return replace(state, groups=tuple(groups))


def over_widths(
    state: State,
    x: np.ndarray,
    change: Gaussian,
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
    return around_estimate(change), tuple(groups)


def around_estimate(change: Gaussian) -> Gaussian:
    """Return a posterior, as changes from the estimate, whose mean is a part of its spread."""
    spread = np.column_stack([change.root, change.mean])
    return Gaussian(np.zeros(len(spread)), spread)


@dataclass(frozen=True)
class WidthMixture:
    """Priors of the geometry at K nodes, each with other widths."""

    groups: Sequence[PriorGroup]

    @cached_property
    def members(self) -> np.ndarray:
        """Indices of the geometry's n members among the unknowns."""
        return np.concatenate([group.members for group in self.groups])

    @cached_property
    def factors(self) -> np.ndarray:
        """Factors of each group's usual width, shape (K, groups)."""
        nodes = product(FACTORS, repeat=len(self.groups))
        return np.array([*nodes])

    @cached_property
    def usual_widths(self) -> np.ndarray:
        """Width of each group that is usual, shape (groups,)."""
        return np.array([usual_width(group) for group in self.groups])

    @cached_property
    def widths(self) -> np.ndarray:
        """Widths of each group, shape (K, groups)."""
        return self.factors * self.usual_widths

    def roots(self, widths: np.ndarray) -> np.ndarray:
        """Return L with L L^T the prior covariance at widths, (..., groups), as (..., n, n)."""
        size = self.members.max() + 1
        shared = [replace(group, width=0.0) for group in self.groups]
        of_all = prior_covariance(shared, size)
        C = submatrix(of_all, self.members)
        sizes = [len(group.members) for group in self.groups]
        variances = np.repeat(widths**2, sizes, axis=-1)
        diagonal = variances[..., None] * np.eye(len(C))
        return np.linalg.cholesky(C + diagonal)

    def posterior(
        self,
        x: np.ndarray,
        gaussian: Gaussian,
    ) -> tuple[Gaussian, np.ndarray]:
        """Return the posterior of all unknowns, and the root mean square of each group's widths.

        With the root of the members' posterior at the usual widths L_0 Q s V^T, their information
        by the data is L_0^-T Q (1 / s^2 - 1) Q^T L_0^-1. All else follows the members.

        Args:
            x: The estimate.
            gaussian: Posterior of all unknowns at the usual widths, as changes from it.
        """
        L = self.roots(self.usual_widths)
        marginal = gaussian.marginal(self.members)
        mu = np.concatenate([group.mean for group in self.groups])
        estimate = x[self.members]
        offset = estimate - mu + marginal.mean
        scaled = np.linalg.solve(L, marginal.root)
        Q, s, V = np.linalg.svd(scaled)
        s = s.clip(LEAST, 1.0)
        k = len(s)
        axes = np.linalg.solve(L.T, Q)
        by_data = 1 / s**2 - 1
        H = (axes * by_data) @ axes.T
        h = (axes / s**2) @ (axes.T @ offset)
        members, odds = self.moments(H, h)
        across = gaussian.root @ V.T
        decided = across[:, :k]
        undecided = across[:, k:]
        gain = (decided / s) @ axes.T
        mean = gaussian.mean + gain @ (members.mean - offset)
        root = np.column_stack([gain @ members.root, undecided])
        squares = odds @ self.widths**2
        return Gaussian(mean, root), np.sqrt(squares)

    def moments(self, H: np.ndarray, h: np.ndarray) -> tuple[Gaussian, np.ndarray]:
        """Return mean and spread of the members' distance from mu, and each node's probability.

            S_k = L_k (1 + L_k^T H L_k)^-1 L_k^T      m_k = mu + S_k h
            2 log Z_k = h^T S_k h - log |1 + L_k^T H L_k|

        Args:
            H: Information of the data, shape (n, n).
            h: H times the distance from mu that the data alone prefer, shape (n,).
        """
        L = self.roots(self.widths)
        L_T = L.swapaxes(1, 2)
        M = L_T @ H @ L
        spreads = np.log(self.factors) / TYPICAL_SPREAD
        log_prior = -0.5 * np.sum(spreads**2, axis=1)
        log_Z = log_bayes_factor(M, h @ L)
        odds = probabilities(log_Z + log_prior)
        likely = np.flatnonzero(odds > NEGLIGIBLE)
        shares = odds[likely]
        identity = np.eye(len(h))
        factors = np.linalg.cholesky(identity + M[likely])
        R = np.linalg.solve(factors, L_T[likely])  # R_k^T R_k = S_k
        pulls = (R @ h)[:, :, None]
        means = R.swapaxes(1, 2) @ pulls
        mean = np.tensordot(shares, means, 1)
        spread = (means - mean).swapaxes(1, 2)
        rows = np.concatenate([R, spread], axis=1)
        rows *= np.sqrt(shares)[:, None, None]
        root = rows.reshape(-1, len(h))
        covariance = root.T @ root
        return Gaussian.of(mean[:, 0], covariance), odds

"""The covariance of all unknowns where the widths of the geometry's priors are uncertain.

A few dozen samples do not tell whether an arm's lengths or its angles are wrong, and so leave both
widths open, and with them all that the samples do not decide. Of a Gaussian posterior with mean m
and covariance S, other widths w make, without another fit,

    S' = S - S K S      m' = m - S K (m - mu)      K = (I + D S)^-1 D      D = P(w) - P
    2 log Z'/Z = log |P(w)| / |P| - log |I + D S| - (m - mu)^T K (m - mu)

with P the prior precision at the widths of m. Averaged over the widths is the spread about m, which
stays the estimate.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..model import GEOMETRY_WIDTHS, TYPICAL_SPREAD, PriorGroup
from .state import State

FACTORS = np.exp(np.arange(-3, 7) * 0.3)
"""Widths that are tried, as factors of the estimate: smaller ones soon contradict the samples."""


def widths_held(state: State) -> State:
    """Return a state whose geometry's widths count as known, to be averaged over afterwards."""
    known = tuple(replace(g, learned=g.learned and not _averaged(g)) for g in state.groups)
    return replace(state, groups=known)


def over_widths(state: State, covariance: np.ndarray) -> np.ndarray:
    """Return a covariance of all unknowns, made at known widths, averaged over these."""
    for own in state.objective.own:
        mine = [g for g in state.groups if _averaged(g) and own.start <= g.members[0] < own.stop]
        if mine:
            covariance = _averaged_covariance(mine, state.x, covariance)
    return covariance


def _averaged(group: PriorGroup) -> bool:
    return group.learned and group.width > 0 and group.name in GEOMETRY_WIDTHS


def _averaged_covariance(
    groups: Sequence[PriorGroup], x: np.ndarray, covariance: np.ndarray
) -> np.ndarray:
    own = np.concatenate([group.members for group in groups])
    off = x[own] - np.concatenate([group.mean for group in groups])
    apart, logs, begin = np.zeros((1, len(own), len(own))), np.zeros(1), 0
    for group in groups:
        tried = np.array([group.precision(group.width * factor) for factor in FACTORS])
        typical = group.typical or GEOMETRY_WIDTHS[group.name]
        usual = (np.log(group.width * FACTORS / typical) / TYPICAL_SPREAD) ** 2
        own_logs = 0.5 * (np.linalg.slogdet(tried)[1] - usual)
        logs = (logs[:, None] + own_logs).ravel()
        apart = np.repeat(apart, len(FACTORS), axis=0)
        block = slice(begin, begin + len(group.members))
        times = len(apart) // len(FACTORS)
        apart[:, block, block] = np.tile(tried - group.precision(group.width), (times, 1, 1))
        begin = block.stop
    A = np.eye(len(own)) + apart @ covariance[np.ix_(own, own)]
    K = np.linalg.solve(A, apart)
    steps = K @ off
    logs -= 0.5 * (np.linalg.slogdet(A)[1] + steps @ off)
    odds = np.exp(logs - logs.max())
    odds /= odds.sum()
    across = covariance[:, own]
    inner = (steps.T * odds) @ steps - np.tensordot(odds, K, 1)
    result = covariance + across @ inner @ across.T
    return (result + result.T) / 2

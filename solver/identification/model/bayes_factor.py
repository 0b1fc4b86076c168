"""The evidence of further unknowns of linear residuals, in closed form, and Bayes' rule."""

from collections.abc import Sequence

import numpy as np


def log_bayes_factor(
    information: np.ndarray,
    pull: np.ndarray,
    widths: np.ndarray | None = None,
) -> np.ndarray:
    """Return ln N(r; 0, C + A S^2 A^T) - ln N(r; 0, C) = (g^T (1 + M)^-1 g - ln|1 + M|) / 2.

    With M = S A^T C^-1 A S and g = S A^T C^-1 r, for unknowns by which residuals r change by A and
    whose priors have the standard deviations S = diag(widths).

    Args:
        information: A^T C^-1 A, shape (..., k, k).
        pull: A^T C^-1 r, shape (..., k).
        widths: Standard deviations, shape (..., k) or (..., 1); an unknown is left out by zero.
            Without widths all are one.

    Returns:
        Shape (...).
    """
    S = np.ones(1) if widths is None else widths
    g = S * pull
    rows = S[..., :, None]
    columns = S[..., None, :]
    M = rows * information * columns
    N = np.eye(g.shape[-1]) + M
    column = np.linalg.solve(N, g[..., None])
    mean = column[..., 0]
    squares = (g * mean).sum(axis=-1)
    log_determinants = np.linalg.slogdet(N)[1]
    return 0.5 * (squares - log_determinants)


def probabilities(logs: np.ndarray) -> np.ndarray:
    """Return the probabilities of explanations, each by ln(prior times evidence); of any shape."""
    relative = logs - logs.max()
    odds: np.ndarray = np.exp(relative)
    return odds / odds.sum()


def probabilities_by_name(names: Sequence[str], logs: np.ndarray) -> dict[str, float]:
    """Return the probability of each name, the sum of those of its explanations, shape (E,)."""
    by_name = dict.fromkeys(names, 0.0)
    shares = probabilities(logs).tolist()
    for name, share in zip(names, shares, strict=True):
        by_name[name] += share
    return by_name

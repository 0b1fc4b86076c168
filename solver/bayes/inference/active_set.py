"""A Newton step for unknowns some of which are never negative."""

import numpy as np

from .arrowhead import ArrowheadMatrix, Inverse

REFINEMENTS = 3
"""Corrections of the step for rounding errors of the inverse. They are large where the
data show nearly nothing of one unknown, and the others very well."""


def active_set_step(
    H: ArrowheadMatrix,
    gradient: np.ndarray,
    x: np.ndarray,
    free: np.ndarray,
    bounded: np.ndarray,
    unheld: Inverse | None = None,
) -> tuple[np.ndarray, Inverse]:
    """Return the step to the minimum of a quadratic function within the bounds."""
    held = bounded & (x == 0) & (gradient > 0)
    unheld = unheld or H.inverse(free[: len(H.beside)])
    change, covariance = np.zeros(len(x)), unheld
    for _ in range(3 * int(bounded.sum()) + 1):
        covariance = H.inverse((free & ~held)[: len(H.beside)]) if held.any() else unheld
        change = np.where(held, -x, 0.0)
        for _ in range(REFINEMENTS):
            change -= covariance.times(gradient + H.times(change))
        below = bounded & ~held & (x + change < 0)
        if below.any():
            held |= below
            continue
        slope = np.where(held, gradient + H.times(change), 0.0)
        if not (slope < 0).any():
            break
        held[np.argmin(slope)] = False
    return change, covariance

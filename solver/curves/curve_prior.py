"""The prior of all joints' error curves: a Gaussian process, or an earlier calibration's posterior.

Coefficients of curves are in the order of the effect: knot after knot.
In (A9) they are c = mu_c + R (x - mu_x) + e; of a process, e is all there is.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..identification.effects import CURVE, circulant, spectrum
from ..identification.model import ExtendedModel, block_matrix, scaled_inverse

JITTER, LEAST = 1e-6, 1e-20
"""Added to a prior's correlations, and the least of its variances, so that it has an inverse."""


@dataclass(frozen=True)
class GivenCurves:
    """Prior of curves by an earlier calibration."""

    at_zero: np.ndarray
    """c without e where x is zero, mu_c - R mu_x, shape (KNOTS m,) [rad]."""
    by_unknowns: np.ndarray
    """R, shape (KNOTS m, size); zero for unknowns of which the calibration has none."""
    covariance: np.ndarray
    """Of e, shape (KNOTS m, KNOTS m)."""

    def shift(self, x: np.ndarray, d: int) -> np.ndarray:
        """Return R, padded to d unknowns, and c without e at x, shape (KNOTS m, d + 1)."""
        R = self.by_unknowns
        rows, size = R.shape
        padding = np.zeros((rows, d - size))
        at_x = self.at_zero + R @ x[:size]
        return np.column_stack([R, padding, at_x])


@dataclass(frozen=True)
class CurvePrior:
    """The prior of e."""

    amplitude: float
    """s of the process of all curves [rad]; 0 for no curves."""
    length: float
    """l [rad]."""
    given: GivenCurves | None = None
    """Prior by an earlier calibration; None for the process alone."""

    @cached_property
    def block(self) -> np.ndarray:
        """Covariance of one joint's coefficients, or of all that are given."""
        if self.given is not None:
            return self.given.covariance
        correlations = circulant(spectrum(self.length))
        return self.amplitude**2 * correlations

    @cached_property
    def inverse(self) -> np.ndarray:
        """Inverse of the block."""
        if self.given is None:
            inverse = circulant(1 / spectrum(self.length))
            return inverse / self.amplitude**2
        variances = np.diag(self.block).clip(min=LEAST)
        jitter = JITTER * np.diag(variances)
        return scaled_inverse(self.block + jitter)

    def times(self, columns: np.ndarray) -> np.ndarray:
        """Return the product of the covariance of all coefficients with columns."""
        by_block = columns.reshape(len(self.block), -1)
        products = self.block @ by_block
        return products.reshape(columns.shape)


def add_blocks(matrix: np.ndarray, block: np.ndarray) -> None:
    """Add to a matrix of all curves' coefficients, in place, a block for each joint."""
    joints = len(matrix) // len(block)
    for k in range(joints):
        matrix[k::joints, k::joints] += block


def given_curves(model: ExtendedModel) -> CurvePrior | None:
    """Return the prior of a robot's curves by an earlier calibration; None without one."""
    given = model.given
    if given is None:
        return None
    names = CURVE.coefficient_names(model.robot.joint_names)
    c = given.of(names)
    x = given.of(model.names)
    if not c.names:
        return None
    n = len(c.names)
    S = given.of([*c.names, *x.names]).covariance
    S_cx = S[:n, n:]
    S_xx = S[n:, n:]
    R = S_cx @ scaled_inverse(S_xx)
    rows = [names.index(name) for name in c.names]
    columns = [model.names.index(name) for name in x.names]
    at_zero = np.zeros(len(names))
    at_zero[rows] = c.mean - R @ x.mean
    by_unknowns = np.zeros((len(names), model.size))
    by_unknowns[np.ix_(rows, columns)] = R
    remainder = S[:n, :n] - R @ S_cx.T
    covariance = block_matrix(len(names), [(rows, remainder)])
    curves = GivenCurves(at_zero, by_unknowns, covariance)
    return CurvePrior(*given.curve_scales, curves)

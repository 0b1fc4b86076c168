"""Score test for joint error curves: what they promise, by the fit without them alone."""

from dataclasses import replace

import numpy as np

from .curve_fit import CurveFit
from .curve_prior import CurvePrior
from .curve_scales import LONGEST, SHORTEST

LENGTHS = np.geomspace(SHORTEST, LONGEST, 3)
"""Lengths that are tried [rad]; curves of those between are much like both neighbours."""


def promised_gain(flat: CurveFit) -> float:
    """Return how far curves would raise the logarithm of the evidence, about; below 0 for none.

    A fit with curves takes an inverse of M a step, and this a product a length. At no curves, and
    at the noise of highest evidence, the evidence has the slope T by the square of the amplitude,

        T = (p^T K p - tr(V K)) / 2        I_ab = tr(V K_a V K_b) / 2

    with p and V of the fit, K the curves' part of M at amplitude 1, and I the information of K and
    of each part of the noise. Beside the noise, K keeps 1 / (I^-1)_00 of it (Rao's test of scores).
    """
    V, p = flat.projection, flat.pulls
    parts = [part for part in flat.parts_of_noise if part.any()]
    by_noise = [_times_blocks(V, part) for part in parts]
    gains: list[float] = []
    for length in LENGTHS.tolist():
        curved = replace(flat, prior=CurvePrior(1.0, length))
        K = curved.curves[0]
        VK = V @ K
        square = p @ K @ p
        T = 0.5 * float(square - np.trace(VK))
        products = [VK, *by_noise]
        traces: np.ndarray = np.einsum("aij,bji->ab", products, products)
        inverse = np.linalg.inv(0.5 * traces)
        variance = float(inverse[0, 0])
        gains.append(0.5 * T * abs(T) * variance)
    return max(gains)


def _times_blocks(V: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """Return the product of V, shape (3 N, 3 N), with a matrix of diagonal blocks, (N, 3, 3)."""
    columns = V.reshape(len(V), -1, 3)
    products = columns.swapaxes(0, 1) @ blocks
    return products.swapaxes(0, 1).reshape(V.shape)

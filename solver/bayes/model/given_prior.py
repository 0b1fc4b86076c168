"""A prior over named unknowns by mean and covariance, as an earlier calibration leaves it."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

LEAST_VARIANCE = 1e-24
"""An unknown of less variance was held, and tells nothing."""


@dataclass(frozen=True)
class GivenPrior:
    """Mean and covariance of some unknowns, by their names."""

    names: tuple[str, ...]
    mean: np.ndarray
    """Shape (n,); of the geometry, changes from nominal."""
    covariance: np.ndarray
    """Shape (n, n)."""
    curve_scales: tuple[float, float] = (0.0, 0.0)
    """Amplitude and length of the process of the joints' error curves, where it tells of any
    [rad]."""

    def of(self, names: Sequence[str]) -> "GivenPrior":
        """Return what it says of those that are among some names, in their order (marginal)."""
        place = {name: i for i, name in enumerate(self.names)}
        rows = [place[name] for name in names if name in place]
        kept, sigma = tuple(self.names[i] for i in rows), self.covariance[np.ix_(rows, rows)]
        return GivenPrior(kept, self.mean[rows], sigma, self.curve_scales)

    def without(self, names: Collection[str]) -> "GivenPrior":
        """Return what it says of all but some names, and but what it holds."""
        variances = np.diag(self.covariance)
        told = (n for n, v in zip(self.names, variances, strict=True) if v > LEAST_VARIANCE)
        return self.of([name for name in told if name not in names])

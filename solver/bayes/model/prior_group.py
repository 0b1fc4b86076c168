"""A group of unknowns with one Gaussian prior, and the step of its width by the evidence."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from math import log

import numpy as np

from .blocks import block_matrix, scaled_inverse, submatrix

Expected = tuple[np.ndarray, np.ndarray]
"""Prior means of coefficients, and the standard deviations of these."""
TYPICAL_SPREAD = 1.0
"""Standard deviation of the logarithm of a width whose typical value is known: a factor e."""
MIN_WIDTH, MAX_WIDTH = 0.3, 10.0
"""A width's step is the one of (A4) times a factor between these two, by how well earlier steps
went."""
NOISE_DEVIATION = 0.3
"""Typical difference of a joint's backlash from that of the others, and of all from what their
noise shows, as a share of it."""
FALLING = 0.05
"""Relative change in a step from which on a width falls, and not just settles."""
SMALLEST_WIDTH = 1e-8
"""A width is never less: rounding would leave nothing of the scale that lengths share."""
LEAST_VARIANCE = 1e-24
"""An unknown of less variance was held, and tells nothing."""
EVERY = slice(None)


@dataclass(frozen=True)
class PriorGroup:
    """Unknowns that share one prior, of mean 0 and width (standard deviation) s_g."""

    name: str
    unit: str
    """Of its unknowns, and so of the width."""
    members: np.ndarray
    """Their indices among the unknowns."""
    width: float
    """s_g; 0 holds the members at zero."""
    typical: float = 0.0
    """Prior of the width itself: this, within a factor e; 0 for none."""
    learned: bool = True
    """True if the evidence sets the width."""
    effective: float = 0.0
    """gamma_g: number of its unknowns that the data decide."""
    trail: tuple[float, float] | None = None
    """Logarithm of the width before the last step, and by how much (A4) wanted it changed."""
    average_width: float = 0.0
    """Root mean square of the widths over which a posterior is averaged (A10); 0 for none."""
    common: np.ndarray | None = None
    """t: a change of all members together that the prior allows in addition, shape (members,).
    For lengths it is how they change when the whole robot grows by 0.2 %. None: no such change."""
    expected: Expected | None = None
    """Means other than zero, as other arms of the type or the noise show them."""
    shape: np.ndarray | None = None
    """Prior covariance of the members for a width of 1, shape (members, members); None for a prior
    in which they are independent."""
    length: float | None = None
    """Length of the Gaussian process that the members are of [rad]; None for no process."""
    optional: bool = False
    """True if the members are held at zero for good once their effect is negligible."""
    non_negative: bool = False
    """True if no member can be below zero."""
    follows_noise: bool = False
    """True if the mean is what the noise of the joints shows."""

    def covariance(self, width: float) -> np.ndarray:
        """Return the members' prior covariance D + t t^T, for s_g a given width.

        D is s_g^2 I, and with what other arms tell, the squares of its deviations added.
        """
        if self.shape is not None:
            return width**2 * self.shape
        D = np.diag(self._variances(width))
        return D if self.common is None else D + np.outer(self.common, self.common)

    def precision(self, width: float, mask: np.ndarray | slice = EVERY) -> np.ndarray:
        """Return the prior precision of some members (Sherman and Morrison), the others held."""
        if self.shape is not None:
            return scaled_inverse(self.shape[mask][:, mask]) / width**2
        inverse = 1 / self._variances(width)[mask]
        if self.common is None:
            return np.diag(inverse)
        t = self.common[mask]
        scaled = inverse * t
        return np.diag(inverse) - np.outer(scaled, scaled) / (1 + t @ scaled)

    @property
    def mean(self) -> np.ndarray:
        """Prior mean of the members, shape (members,)."""
        return (
            np.zeros(len(self.members)) if self.expected is None else self.expected[0]
        )

    def _variances(self, width: float) -> np.ndarray:
        variance = 0.0 if self.expected is None else self.expected[1] ** 2
        return np.full(len(self.members), width**2) + variance

    @property
    def deviation(self) -> float:
        """Standard deviation of the prior, larger where the width is uncertain itself.

        One estimated from gamma unknowns makes it Student's, whose variance is larger by
        gamma / (gamma - 2), here by 2 at most, unless its widths were averaged over.
        """
        if self.average_width:
            return self.average_width
        gamma = max(self.effective, 4.0)
        return self.width * (gamma / (gamma - 2)) ** 0.5 if self.learned else self.width

    def following(self, noise: float) -> "PriorGroup":
        """Return the group with the mean that the noise of joints without load shows [rad].

        All members may differ from it together, and each by itself.
        """
        ones = np.ones(len(self.members))
        width = max(NOISE_DEVIATION * noise, SMALLEST_WIDTH)
        return replace(
            self, width=width, common=width * ones, expected=(noise * ones, 0 * ones)
        )

    def updated(
        self,
        x: np.ndarray,
        covariance: np.ndarray,
        mask: np.ndarray,
        largest: float = np.inf,
    ) -> "PriorGroup":
        """Return the group with a width closer to what the evidence prefers (A4; MacKay 1992).

        That is the root mean square of the free members' distances x from their mean, over those
        that the data decide. Its logarithm changes by ``largest`` at most.
        """
        P = self.width**2 * self.precision(self.width, mask)
        effective = float(np.trace(P) - np.trace(P @ covariance @ P) / self.width**2)
        squares = float(np.sum((P @ x) ** 2))
        gamma = max(effective, 1e-9)
        square = squares / gamma
        if self.typical:
            slope = np.log(self.width / self.typical) / TYPICAL_SPREAD**2
            ratio = squares / self.width**2
            step = (ratio - gamma - slope) / (2 * ratio + 1 / TYPICAL_SPREAD**2)
            square = self.width**2 * np.exp(2 * np.clip(step, -1, 1))
        target = 0.5 * np.log(max(square, SMALLEST_WIDTH**2))
        now = float(np.log(self.width))
        step = float(np.clip(self._step(now, target - now), -largest, largest))
        width = max(float(np.exp(now + step)), SMALLEST_WIDTH)
        return replace(
            self, width=width, effective=effective, trail=(now, target - now)
        )

    def _step(self, now: float, change: float) -> float:
        """Return by how much to change the logarithm of the width."""
        if self.trail is None or now == self.trail[0] or not change:
            return change
        slope = (change - self.trail[1]) / (now - self.trail[0])
        if slope < 0:
            return float(np.clip(-1 / slope, MIN_WIDTH, MAX_WIDTH)) * change
        return min(change, -log(2)) if max(change, self.trail[1]) < -FALLING else change


def prior_covariance(
    groups: Iterable[PriorGroup], size: int, *, widened: bool = False
) -> np.ndarray:
    """Return the prior covariance of all unknowns, zero for those of no group, shape (size, size).

    It is made at the groups' widths, or ``widened`` by what these are uncertain by.
    """
    blocks = [
        (g.members, g.covariance(g.deviation if widened else g.width)) for g in groups
    ]
    return block_matrix(size, blocks)


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
        subset = tuple(self.names[i] for i in rows)
        covariance = submatrix(self.covariance, rows)
        return GivenPrior(subset, self.mean[rows], covariance, self.curve_scales)

    def without(self, names: Collection[str]) -> "GivenPrior":
        """Return what it says of all but some names, and but what it holds."""
        uncertain = compress(self.names, np.diag(self.covariance) > LEAST_VARIANCE)
        return self.of([name for name in uncertain if name not in names])


Prior = Mapping[str, Expected] | GivenPrior | None
"""The elasticity of other arms of a robot's type, or what an earlier calibration left known."""

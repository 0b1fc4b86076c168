"""A group of unknowns with one Gaussian prior, and the step of its width by the evidence."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from math import exp, inf, log

import numpy as np

from .blocks import block_matrix, scaled_inverse, submatrix

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
LARGEST_LOGARITHM = 700.0
"""Logarithm of the largest finite width; that of a fit that diverges is infinite."""
SMALLEST_WIDTH = 1e-7
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
    expected: np.ndarray | None = None
    """Means other than zero, as the noise or measured poses show them."""
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
        D = width**2 * np.eye(len(self.members))
        if self.common is None:
            return D
        return D + np.outer(self.common, self.common)

    def precision(self, width: float, mask: np.ndarray | slice = EVERY) -> np.ndarray:
        """Return the prior precision of some members (Sherman and Morrison), the others held."""
        if self.shape is not None:
            shape = self.shape[mask][:, mask]
            return scaled_inverse(shape) / width**2
        inverse = 1 / np.full(len(self.members), width**2)[mask]
        if self.common is None:
            return np.diag(inverse)
        t = self.common[mask]
        scaled = inverse * t
        outer = np.outer(scaled, scaled)
        return np.diag(inverse) - outer / (1 + t @ scaled)

    @property
    def mean(self) -> np.ndarray:
        """Prior mean of the members, shape (members,)."""
        if self.expected is None:
            return np.zeros(len(self.members))
        return self.expected

    @property
    def deviation(self) -> float:
        """Standard deviation of the prior, larger where the width is uncertain itself.

        One estimated from gamma unknowns makes it Student's, whose variance is larger by
        gamma / (gamma - 2), here by 2 at most, unless its widths were averaged over.
        """
        if self.average_width:
            return self.average_width
        if not self.learned:
            return self.width
        gamma = max(self.effective, 4.0)
        return self.width * (gamma / (gamma - 2)) ** 0.5

    def following(self, noise: float) -> "PriorGroup":
        """Return the group with the mean that the noise of joints without load shows [rad].

        All members may differ from it together, and each by itself.
        """
        ones = np.ones(len(self.members))
        width = max(NOISE_DEVIATION * noise, SMALLEST_WIDTH)
        return replace(
            self,
            width=width,
            common=width * ones,
            expected=noise * ones,
        )

    def updated(
        self,
        x: np.ndarray,
        covariance: np.ndarray,
        mask: np.ndarray,
        largest: float = np.inf,
    ) -> "PriorGroup":
        """Return the group with a width closer to what the evidence prefers (A4; MacKay 1992).

            s_g^2 = |P x|^2 / gamma        P = s_g^2 P_g
            gamma = tr P - tr(P Sigma P) / s_g^2

        It is the mean square of the free members' distances x from their mean, over those that the
        data decide.

        Args:
            x: Distances of the free members from their mean, shape (k,).
            covariance: Sigma of these members, shape (k, k).
            mask: True for the members that are free.
            largest: Largest change of the logarithm of the width.
        """
        square = self.width**2
        P = square * self.precision(self.width, mask)
        undecided = np.trace(P @ covariance @ P) / square
        effective = float(np.trace(P) - undecided)
        distances = P @ x
        squares = float(distances @ distances)
        now = log(self.width)
        change = self._target(squares, max(effective, 1e-9)) - now
        step = self._step(now, change)
        step = min(max(step, -largest), largest)
        logarithm = now + step
        scale = inf if logarithm > LARGEST_LOGARITHM else exp(logarithm)  # or NaN
        width = max(scale, SMALLEST_WIDTH)
        trail = now, change
        return replace(self, width=width, effective=effective, trail=trail)

    def _target(self, squares: float, gamma: float) -> float:
        """Return the logarithm of the width that (A4) wants; beside its own prior, by Newton."""
        square = squares / gamma
        if self.typical:
            precision = 1 / TYPICAL_SPREAD**2
            offset = log(self.width / self.typical)
            ratio = squares / self.width**2
            slope = ratio - gamma - precision * offset
            step = slope / (2 * ratio + precision)
            step = min(max(step, -1), 1)
            square = self.width**2 * exp(2 * step)
        return 0.5 * log(max(square, SMALLEST_WIDTH**2))

    def _step(self, now: float, change: float) -> float:
        """Return by how much to change the logarithm of the width."""
        if self.trail is None:
            return change
        before, change_before = self.trail
        if now == before or not change:
            return change
        slope = (change - change_before) / (now - before)
        if slope < 0:
            factor = min(max(-1 / slope, MIN_WIDTH), MAX_WIDTH)
            return factor * change
        falls = max(change, change_before) < -FALLING
        return min(change, -log(2)) if falls else change


def prior_covariance(
    groups: Iterable[PriorGroup],
    size: int,
    *,
    widened: bool = False,
) -> np.ndarray:
    """Return the prior covariance of all unknowns, zero for those of no group, shape (size, size).

    It is made at the groups' widths, or ``widened`` by what these are uncertain by.
    """
    blocks: list[tuple[np.ndarray, np.ndarray]] = []
    for group in groups:
        width = group.deviation if widened else group.width
        blocks.append((group.members, group.covariance(width)))
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
        places = {name: i for i, name in enumerate(self.names)}
        subset = [name for name in names if name in places]
        rows = [places[name] for name in subset]
        covariance = submatrix(self.covariance, rows)
        return replace(
            self,
            names=tuple(subset),
            mean=self.mean[rows],
            covariance=covariance,
        )

    def without(self, names: Collection[str]) -> "GivenPrior":
        """Return what it says of all but some names, and but what it holds."""
        mask = np.diag(self.covariance) > LEAST_VARIANCE
        uncertain = compress(self.names, mask)
        others = [name for name in uncertain if name not in names]
        return self.of(others)

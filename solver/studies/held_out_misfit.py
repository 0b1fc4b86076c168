"""What held-out samples miss beyond the posterior: the errors that no model of the arm has.

The posterior says what the samples leave uncertain of a model that is right. Held-out residuals e_i
show how far it is from right. With A_i their derivatives by the unknowns, Sigma the posterior
covariance of these, and N_i the noise of the fit, the misfit f is the least number for which

    e_i^T (A_i Sigma A_i^T + f^2 N_i)^-1 e_i < 7.815

in 95 of 100 samples: that is what 95 % of the squares of three numbers stay below. The level is met
by counting samples, so errors of any distribution keep it (Vovk, Gammerman and Shafer 2005).
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from ..identification.data import IDENTITY, Load, Measurement, Samples, fit_pose
from ..identification.inference import Posterior
from ..identification.robot import Robot
from .projections import basis_of, bisected, outside, rows_of, shifts_of
from .uncertainty import covariance_of
from .whitening import whitened

LEVEL, SQUARE = 0.95, 7.815
FEWEST = 10
"""Held-out samples below which they say nothing."""
HALVINGS = 60
LARGEST = 1e6
"""Largest f^2."""


class HeldOut(NamedTuple):
    """Samples that share a place which nobody knows: a socket, or the frame of an instrument."""

    samples: Samples
    points: np.ndarray | None = None
    """Balls in the instrument's frame, shape (N, 3) [m]; None for those of one socket."""

    @classmethod
    def of(cls, robot: Robot, load: Load, measured: Measurement) -> "list[HeldOut]":
        """Return the samples of a placement by their places."""
        if measured.kind == "points":
            return [cls(load.samples(robot, measured), measured.points)]
        return [*map(cls, load.by_socket(robot, measured))]


def misfit(places: Iterable[tuple[Posterior, HeldOut]]) -> float:
    """Return f by samples and posteriors that do not hold them; 0 where they are too few."""
    squares: list[float] = []
    for posterior, place in places:
        if len(place.samples.q) > 2:
            squares += _squares_of_misfit(posterior, place).tolist()
    count = len(squares)
    if count < FEWEST:
        return 0.0
    rank = int(np.ceil(LEVEL * (count + 1)))
    by_size = sorted(squares)
    return by_size[min(rank, count) - 1] ** 0.5


def within(
    posterior: Posterior,
    place: HeldOut,
    factor: float,
    levels: Sequence[float],
) -> list[float]:
    """Return the shares of samples whose e^T S^-1 e, S with this misfit, is below some levels."""
    shares, errors = _by_axes(posterior, place)
    variances = shares + factor**2
    ratios = errors**2 / variances
    squares: np.ndarray = ratios.sum(axis=1)
    return [float(np.mean(squares < level)) for level in levels]


def _squares_of_misfit(
    posterior: Posterior,
    place: HeldOut,
) -> np.ndarray:
    """Return the least f^2 for which each sample is within its 95 %, shape (N,)."""
    shares, errors = _by_axes(posterior, place)

    def is_beyond(squares: np.ndarray) -> np.ndarray:
        variances = shares + squares[:, None]
        ratios = errors**2 / variances
        return ratios.sum(axis=1) > SQUARE

    low = np.zeros(len(shares))
    high = low + LARGEST
    return bisected(is_beyond, low, high, HALVINGS)


class ByAxes(NamedTuple):
    """N samples where their noise is one, along the axes of what the unknowns change of each."""

    shares: np.ndarray
    """s: variances by the unknowns, shape (N, 3)."""
    errors: np.ndarray
    """V^T L^-1 e_i, shape (N, 3)."""


def _by_axes(posterior: Posterior, place: HeldOut) -> ByAxes:
    """Return A_i Sigma A_i^T and e_i where N_i is one, along the axes of the first.

    With N_i = L L^T and L^-1 A_i Sigma A_i^T L^-T = V diag(s) V^T, these are s and V^T L^-1 e_i.
    A_i and e_i are without what another place of all samples would do to them.
    """
    points, J, by_joints = posterior.linearise(place.samples)
    if place.points is None:
        unknown_place = shifts_of(points)
        errors = points - points.mean(axis=0)
    else:
        unknown_place = IDENTITY.slopes(points)
        frame = fit_pose(place.points, points)
        errors = points - frame.apply(place.points)
    Q = basis_of(unknown_place)
    A = outside(rows_of(J), Q).reshape(J.shape)
    # The place was fitted to these samples, so their errors came out smaller.
    numbers, fitted_numbers = Q.shape
    errors *= (numbers / (numbers - fitted_numbers)) ** 0.5
    columns = np.dstack([errors, A])
    white = whitened(posterior, by_joints, columns)
    slopes = white[:, :, 1:]
    across = slopes.swapaxes(1, 2)
    spread = slopes @ covariance_of(posterior) @ across
    shares, axes = np.linalg.eigh(spread)
    along_axes = np.einsum("nji,nj->ni", axes, white[:, :, 0])
    return ByAxes(shares.clip(min=0.0), along_axes)

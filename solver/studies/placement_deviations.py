"""Studies: how large errors should be by the posterior, and what held-out samples miss beyond it.

The posterior says what the samples leave uncertain of a model that is right. Held-out residuals e_i
show how far it is from right. With A_i their derivatives by the unknowns, Sigma the posterior
covariance of these, and N_i the noise of the fit, the misfit f is the least number for which the
mean of the samples'

    s_i = e_i^T S_i^-1 e_i        S_i = A_i Sigma A_i^T + f^2 N_i

is 3 or less: one deviation is then the root mean square of an error. Errors of real arms have more
large ones than a normal distribution. So their tail t is stated apart: 95 of 100 samples have

    s_i < 7.815 t^2

where 7.815 is what 95 % of the squares of three normal numbers stay below. The level is met by
counting samples, so errors of any distribution keep it (Vovk, Gammerman and Shafer 2005).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from msgspec import structs

from ..identification.data import (
    IDENTITY,
    Load,
    Measurement,
    Samples,
    fit_pose,
    found_deviation,
)
from ..identification.inference import Posterior
from ..identification.robot import Robot
from ..results import Fit, Measurements, PlacementErrors, Study
from .base_errors import BaseErrors, BaseLength, length_deviation
from .projections import basis_of, bisected, outside, rows_of, shifts_of
from .uncertainty import covariance_of, predicted_deviation
from .whitening import whitened

LEVEL, SQUARE = 0.95, 7.815
AXES = 3
FEWEST = 10
"""Held-out samples below which they say nothing."""
HALVINGS = 60
LARGEST = 1e6
"""Largest f^2."""
SMALLEST = 1e-12
"""Least f^2, which a direction that no unknown moves is divided by."""


class HeldOut(NamedTuple):
    """Samples that share a place which nobody knows: a socket, or the frame of an instrument."""

    samples: Samples
    points: np.ndarray | None = None
    """Balls in the instrument's frame, shape (N, 3) [m]; None for those of one socket."""

    @classmethod
    def of(
        cls,
        robot: Robot,
        load: Load,
        measured: Measurement,
    ) -> "list[HeldOut]":
        """Return the samples of a placement by their places."""
        if measured.kind == "points":
            return [cls(load.samples(robot, measured), measured.points)]
        return [*map(cls, load.by_socket(robot, measured))]


def misfit(places: Iterable[tuple[Posterior, HeldOut]]) -> float:
    """Return f by samples and posteriors that do not hold them; 0 where they are too few."""
    samples = _all_by_axes(places)
    return 0.0 if samples is None else _misfit(samples)


def tail(places: Iterable[tuple[Posterior, HeldOut]]) -> float:
    """Return t by the same samples, 1 or more; 1 where they are too few."""
    samples = _all_by_axes(places)
    if samples is None:
        return 1.0
    by_size = np.sort(_squares(samples, _misfit(samples) ** 2))
    rank = int(np.ceil(LEVEL * (len(by_size) + 1)))
    largest = by_size[min(rank, len(by_size)) - 1]
    return max(float(largest / SQUARE) ** 0.5, 1.0)


def _misfit(samples: "ByAxes") -> float:
    """Return f, by which the mean of the squares is that of three normal numbers."""
    low = np.zeros(1)
    (square,) = bisected(
        lambda squares: _squares(samples, squares[0]).mean(keepdims=True) > AXES,
        low,
        low + LARGEST,
        HALVINGS,
    )
    return float(square) ** 0.5


def within(
    posterior: Posterior,
    place: HeldOut,
    factor: float,
    levels: Sequence[float],
) -> list[float]:
    """Return the shares of samples whose e^T S^-1 e, S with this misfit, is below some levels."""
    squares = _squares(_by_axes(posterior, place), factor**2)
    return [float(np.mean(squares < level)) for level in levels]


class ByAxes(NamedTuple):
    """N samples where their noise is one, along the axes of what the unknowns change of each."""

    shares: np.ndarray
    """s: variances by the unknowns, shape (N, 3)."""
    errors: np.ndarray
    """V^T L^-1 e_i, shape (N, 3)."""


def _squares(
    samples: ByAxes,
    square: float,
) -> np.ndarray:
    """Return e^T S^-1 e of samples, S with a squared misfit, shape (N,)."""
    ratios = samples.errors**2 / (samples.shares + max(square, SMALLEST))
    return ratios.sum(axis=1)


def _all_by_axes(places: Iterable[tuple[Posterior, HeldOut]]) -> ByAxes | None:
    """Return the samples of places with more than two; None where they are too few."""
    parts = [
        _by_axes(posterior, place)
        for posterior, place in places
        if len(place.samples.q) >= AXES
    ]
    if sum(len(part.errors) for part in parts) < FEWEST:
        return None
    return ByAxes(*map(np.concatenate, zip(*parts, strict=True)))


def _by_axes(
    posterior: Posterior,
    place: HeldOut,
) -> ByAxes:
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
    white = whitened(posterior, by_joints, np.dstack([errors, A]))
    slopes = white[:, :, 1:]
    spread = slopes @ covariance_of(posterior) @ slopes.swapaxes(1, 2)
    shares, axes = np.linalg.eigh(spread)
    along_axes = np.einsum("nji,nj->ni", axes, white[:, :, 0])
    return ByAxes(shares.clip(min=0.0), along_axes)


def placements(
    fit: Fit,
    measurements: Measurements,
    rows: Sequence[PlacementErrors],
) -> tuple[PlacementErrors, ...]:
    """Return the errors of all placements, and how large they should be."""
    return tuple(_expected([(fit, m) for _, m in measurements.placements], rows))


def left_out(
    _: Fit,
    measurements: Measurements,
    rows: Sequence[PlacementErrors],
) -> tuple[PlacementErrors, ...]:
    """Return the errors of what folds leave out, and how large they should be by the fold."""
    parts = [(fold.fit, m) for fold in measurements.folds for m in fold.left_out]
    return tuple(_expected(parts, rows))


def _of_folds(
    figure: Callable[[Iterable[tuple[Posterior, HeldOut]]], float],
    fit: Fit,
    measurements: Measurements,
) -> float | None:
    """Return a figure of what folds leave out; None without folds."""
    return figure(_unseen(fit, measurements)) if measurements.folds else None


def _unseen(
    fit: Fit,
    measurements: Measurements,
) -> list[tuple[Posterior, HeldOut]]:
    """Return what folds leave out, each place with the posterior of its fold."""
    robot, load = measurements.robot, fit.calibrated.load
    return [
        (posterior, place)
        for posterior, unseen in measurements.unseen(fit)
        for measured in unseen
        for place in HeldOut.of(robot, load, measured)
    ]


def _expected(
    parts: Sequence[tuple[Fit, Measurement]],
    rows: Sequence[PlacementErrors],
) -> Iterator[PlacementErrors]:
    """Yield errors with rms distances of samples from their socket's mean, as they should be.

    And with the deviation of a distance that was not trained on.
    """
    for (fit, measured), row in zip(parts, rows, strict=True):
        posterior, calibrated = fit.posterior, fit.calibrated
        if posterior is None:
            yield row
            continue
        if measured.kind == "points":
            noises = {"sockets": posterior.noises.get("points", posterior.noise)}
            posterior = replace(posterior, noises=noises)
        by_socket = calibrated.load.by_socket(calibrated.robot, measured)
        deviation = None
        if row.role != "train" and measured.has_distance:
            bases = BaseErrors.of(posterior, [measured])
            length = BaseLength.at(posterior, by_socket)
            deviation = length_deviation(bases, length, measured)
        yield structs.replace(
            row,
            predicted_deviation=predicted_deviation(posterior, by_socket),
            found_deviation=found_deviation(calibrated.predict(measured), measured),
            distance_deviation=deviation,
        )


PLACEMENTS = Study("placements", placements, ("placements",))
LEFT_OUT = Study("left_out", left_out, ("left_out",))
MISFIT = Study("misfit", partial(_of_folds, misfit))
TAIL = Study("tail", partial(_of_folds, tail))

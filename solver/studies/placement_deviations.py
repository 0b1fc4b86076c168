"""Study: how large the errors at each placement should be by the posterior."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
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
from ..results import CalibratedRobot, Fit, Measurements, PlacementErrors, Study
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
    def of(cls, robot: Robot, load: Load, measured: Measurement) -> "list[HeldOut]":
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

    def is_beyond(squares: np.ndarray) -> np.ndarray:
        return np.array([_squares(samples, square).mean() > AXES for square in squares])

    low = np.zeros(1)
    squares = bisected(is_beyond, low, low + LARGEST, HALVINGS)
    return float(squares[0]) ** 0.5


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


def _squares(samples: ByAxes, square: float) -> np.ndarray:
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
    shares, errors = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    return ByAxes(shares, errors)


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


def placements(
    fit: Fit, measurements: Measurements, rows: Sequence[PlacementErrors]
) -> tuple[PlacementErrors, ...]:
    """Return the errors of all placements, and how large they should be."""
    assert fit.posterior is not None
    expected: list[PlacementErrors] = []
    for (role, m), row in zip(measurements.placements, rows, strict=True):
        deviations = _deviations(
            fit.calibrated, fit.posterior, m, held_out=role == "test"
        )
        expected.append(structs.replace(row, **deviations))
    return tuple(expected)


def left_out(
    _: Fit, measurements: Measurements, rows: Sequence[PlacementErrors]
) -> tuple[PlacementErrors, ...]:
    """Return the errors of what folds leave out, and how large they should be by the fold."""
    parts = [(fold.fit, m) for fold in measurements.folds for m in fold.left_out]
    expected: list[PlacementErrors] = []
    for (fit, m), row in zip(parts, rows, strict=True):
        if fit.posterior is not None:
            deviations = _deviations(fit.calibrated, fit.posterior, m, held_out=True)
            row = structs.replace(row, **deviations)
        expected.append(row)
    return tuple(expected)


def misfit_of_folds(fit: Fit, measurements: Measurements) -> float | None:
    """Return f by what folds leave out; None without folds."""
    return misfit(_unseen(fit, measurements)) if measurements.folds else None


def tail_of_folds(fit: Fit, measurements: Measurements) -> float | None:
    """Return t by what folds leave out; None without folds."""
    return tail(_unseen(fit, measurements)) if measurements.folds else None


def _unseen(fit: Fit, measurements: Measurements) -> list[tuple[Posterior, HeldOut]]:
    """Return what folds leave out, each place with the posterior of its fold."""
    robot, load = measurements.robot, fit.calibrated.load
    return [
        (posterior, place)
        for posterior, placements in measurements.unseen(fit)
        for measured in placements
        for place in HeldOut.of(robot, load, measured)
    ]


def _deviations(
    calibrated: CalibratedRobot,
    posterior: Posterior,
    measured: Measurement,
    *,
    held_out: bool,
) -> dict[str, float]:
    """Return rms distances of samples from their socket's mean, and that of a distance held out."""
    points = calibrated.predict(measured)
    if measured.kind == "points":
        noises = {"sockets": posterior.noises.get("points", posterior.noise)}
        posterior = replace(posterior, noises=noises)
    by_socket = calibrated.load.by_socket(calibrated.robot, measured)
    deviations = {
        "predicted_deviation": predicted_deviation(posterior, by_socket),
        "found_deviation": found_deviation(points, measured),
    }
    if held_out and measured.has_distance:
        bases = BaseErrors.of(posterior, [measured])
        length = BaseLength.at(posterior, by_socket)
        deviations["distance_deviation"] = length_deviation(bases, length, measured)
    return deviations


PLACEMENTS = Study("placements", placements, ("placements",))
LEFT_OUT = Study("left_out", left_out, ("left_out",))
MISFIT = Study("misfit", misfit_of_folds)
TAIL = Study("tail", tail_of_folds)

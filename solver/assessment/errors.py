"""Errors of each sample, of each placement, and of each role as a whole."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from ..data import as_point
from ..results import Document, PlacementErrors, Role, Summary, fields_of
from .formatting import short_where
from .predictions import ByModel, ModelName, PlacementPrediction, Point, Predictions

Figure = TypeVar("Figure")


class Quantiles(Document, kw_only=True, frozen=True):
    """Distribution of the errors of single samples [m]."""

    median: float
    p95: float
    """19 of 20 samples have no larger error."""
    max: float


class RoleSummary(Summary, kw_only=True, frozen=True):
    """All placements of one role (trained on, or held out) taken together."""

    placements: int
    samples: int
    quantiles: ByModel[Quantiles]
    within_tolerance: ByModel[float]
    """Share of the samples whose error is within the task's tolerance, 0 to 1."""


class RoleSummaries(Document, kw_only=True, frozen=True):
    """A summary for each role; None where no placement has it."""

    train: RoleSummary | None
    test: RoleSummary | None

    @property
    def judged(self) -> tuple[Role, RoleSummary]:
        """The role that verdicts rest on: held out; without any such placement, trained on."""
        if self.test is not None:
            return "test", self.test
        assert self.train is not None  # a report has at least one placement
        return "train", self.train


class Socket(Document, kw_only=True, frozen=True):
    """Position of a socket by the calibrated model."""

    socket: int
    centre: Point
    """Mean of the predicted ball centres [m]."""


class PlacementReport(PlacementErrors, kw_only=True, frozen=True):
    """One placement: its errors, and where it stands."""

    position: Point
    """The middle of its sockets [m]."""
    sockets: tuple[Socket, ...]
    quantiles: ByModel[Quantiles]
    within_tolerance: float
    """Share of the samples within the task's tolerance, by the calibrated URDF."""


class SampleErrors(Document, kw_only=True, frozen=True):
    """One sample: the predicted ball centre less the mean of its socket, by both models [m]."""

    placement: int
    """Index of its placement."""
    socket: int
    number: int
    """Its place among the samples of its socket, from 1."""
    where: str
    """File and line."""
    nominal: Point
    calibrated: Point
    geometric: Point | None = None
    weight: float | None = None
    """Robust weight in the fit, where there was one."""

    def of(self, model: ModelName) -> Point:
        """Return the deviation by one model [m]."""
        if model == "geometric" and self.geometric is not None:
            return self.geometric
        return self.nominal if model == "nominal" else self.calibrated

    def error(self, model: ModelName = "calibrated") -> float:
        """Return the length of the deviation by one model [m]."""
        return math.hypot(*self.of(model))


def quantiles(errors: np.ndarray) -> Quantiles:
    """Return the median, the 95th percentile and the maximum of some errors."""
    median, high = np.quantile(errors, (0.5, 0.95)).tolist()
    return Quantiles(median=median, p95=high, max=float(np.max(errors)))


def _share_within(errors: np.ndarray, tolerance: float) -> float:
    return float(np.mean(errors <= tolerance))


def role_summaries(predictions: Predictions, tolerance: float) -> RoleSummaries:
    """Return the file's summaries, and the quantiles over all samples of each role.

    Args:
        predictions: The calibration.
        tolerance: The error that the task allows [m].
    """
    given = predictions.document.summary
    return RoleSummaries(
        train=_role_summary(predictions, "train", given.train, tolerance),
        test=_role_summary(predictions, "test", given.test, tolerance),
    )


def _role_summary(
    predictions: Predictions, role: Role, given: Summary | None, tolerance: float
) -> RoleSummary | None:
    placements = predictions.of_role(role)
    if given is None or not placements:
        return None
    errors = _by_model(placements)
    return RoleSummary(
        **fields_of(given),
        placements=len(placements),
        samples=len(errors.nominal),
        quantiles=_each(errors, quantiles),
        within_tolerance=_each(errors, lambda those: _share_within(those, tolerance)),
    )


def _by_model(placements: Sequence[PlacementPrediction]) -> ByModel[np.ndarray]:
    """Return the errors of all samples of some placements, by each model [m]."""

    def of(model: ModelName) -> np.ndarray:
        return np.concatenate([placement.errors(model) for placement in placements])

    exported = placements[0].points.geometric is not None
    return ByModel(
        nominal=of("nominal"),
        calibrated=of("calibrated"),
        geometric=of("geometric") if exported else None,
    )


def _each(errors: ByModel[np.ndarray], figure: Callable[[np.ndarray], Figure]) -> ByModel[Figure]:
    """Return a figure of each model's errors."""
    return ByModel(
        nominal=figure(errors.nominal),
        calibrated=figure(errors.calibrated),
        geometric=None if errors.geometric is None else figure(errors.geometric),
    )


def placement_reports(predictions: Predictions, tolerance: float) -> tuple[PlacementReport, ...]:
    """Return each placement's errors, and where it stands."""
    rows = zip(predictions.document.placements, predictions.placements, strict=True)
    return tuple(_placement_report(given, placement, tolerance) for given, placement in rows)


def _placement_report(
    given: PlacementErrors, placement: PlacementPrediction, tolerance: float
) -> PlacementReport:
    errors = _by_model([placement])
    return PlacementReport(
        **fields_of(given),
        position=as_point(placement.position),
        sockets=tuple(
            Socket(socket=k, centre=as_point(centre))
            for k, centre in zip(placement.measured.sockets, placement.centres(), strict=True)
        ),
        quantiles=_each(errors, quantiles),
        within_tolerance=_share_within(errors.loaded, tolerance),
    )


def sample_errors(predictions: Predictions, most: int) -> tuple[SampleErrors, ...]:
    """Return the deviation of every sample from its socket's mean, thinned out to ``most``."""
    rows = [
        row
        for i, placement in enumerate(predictions.placements)
        for row in _deviations(i, placement)
    ]
    return tuple(rows[:: -(-len(rows) // most)])


def _deviations(index: int, placement: PlacementPrediction) -> Iterator[SampleErrors]:
    numbers: dict[int, int] = {}
    for i, sample in enumerate(placement.samples):
        numbers[sample.socket] = numbers.get(sample.socket, 0) + 1
        yield SampleErrors(
            placement=index,
            socket=sample.socket,
            number=numbers[sample.socket],
            where=short_where(sample.where),
            nominal=_rounded(placement.deviations.nominal[i]),
            calibrated=_rounded(placement.deviations.calibrated[i]),
            geometric=None
            if placement.deviations.geometric is None
            else _rounded(placement.deviations.geometric[i]),
            weight=sample.weight,
        )


def _rounded(vector: np.ndarray) -> Point:
    """Return a vector to hundredths of a micrometre."""
    x, y, z = (round(value, 8) for value in vector.tolist())
    return x, y, z

"""Errors of samples, placements and roles, and of distances that were measured from outside."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from msgspec import structs

from ..identification.data import KnownDistance, as_point, find_socket
from ..results import (
    ByModel,
    Document,
    ModelName,
    PlacementErrors,
    Role,
    Summary,
    mean_by_model,
    names_of,
)
from .formatting import short_where
from .predictions import DRAWN, PlacementPrediction, Point, Predictions


class Quantiles(Document):
    """Distribution of the errors of single samples [m]."""

    median: float
    p95: float
    """19 of 20 samples have no larger error."""
    max: float
    rms: float | None = None
    """Root of the mean square."""
    std: float | None = None
    """Standard deviation about the mean."""


class RoleSummary(Summary):
    """All placements of one role (trained on, or held out) taken together."""

    placements: int
    samples: int
    quantiles: ByModel[Quantiles]
    within_tolerance: ByModel[float]
    """Share of the samples whose error is within the task's tolerance, 0 to 1."""


class RoleSummaries(Document):
    """A summary for each role; None where no placement has it."""

    train: RoleSummary | None
    test: RoleSummary | None
    left_out: RoleSummary | None = None

    @property
    def judged(self) -> tuple[Role, RoleSummary]:
        """The role that verdicts rest on: held out, else left out, else trained on."""
        if self.test is not None:
            return "test", self.test
        if self.left_out is not None:
            return "left_out", self.left_out
        assert self.train is not None  # a report has at least one placement
        return "train", self.train


class Socket(Document):
    """Position of a socket by the calibrated model."""

    socket: int
    centre: Point
    """Mean of the predicted ball centres [m]."""


class PlacementReport(PlacementErrors):
    """One placement: its errors, and where it stands."""

    position: Point
    """The middle of its sockets [m]."""
    sockets: tuple[Socket, ...]
    quantiles: ByModel[Quantiles]
    within_tolerance: float
    """Share of the samples within the task's tolerance, by the calibrated URDF."""


class SampleErrors(ByModel[Point]):
    """One sample: the predicted ball centre less the mean of its socket, by each model [m]."""

    placement: int
    socket: int
    number: int
    """As recorded; its place among the samples of its socket where the file numbers none."""
    where: str
    """It by its number, where it has one, then file and line."""
    weight: float | None = None
    """Robust weight in the fit, where there was one."""

    def error(self, model: ModelName = "calibrated") -> float:
        """Return the length of the deviation by one model [m]."""
        return math.hypot(*self.of(model))


def quantiles(errors: np.ndarray) -> Quantiles:
    """Return the median, the 95th percentile, the maximum, rms and spread of some errors."""
    median, high = np.quantile(errors, (0.5, 0.95)).tolist()
    rms = float(np.sqrt(np.mean(errors**2)))
    largest, spread = float(np.max(errors)), float(np.std(errors))
    return Quantiles(median=median, p95=high, max=largest, rms=rms, std=spread)


def role_summaries(predictions: Predictions, tolerance: float) -> RoleSummaries:
    """Return the file's summaries, and quantiles over all samples of each role."""

    def of(role: Role, summary: Summary | None) -> RoleSummary | None:
        placements = [p for p in predictions.all if p.role == role]
        if summary is None or not placements:
            return None
        errors = _joined(placements, PlacementPrediction.errors)
        return RoleSummary.filled(
            summary,
            placements=len(placements),
            samples=len(errors.nominal),
            quantiles=errors.each(quantiles),
            within_tolerance=errors.each(
                lambda those: float(np.mean(those <= tolerance))
            ),
        )

    summary = predictions.document.summary
    return RoleSummaries(
        train=of("train", summary.train),
        test=of("test", summary.test),
        left_out=of("left_out", summary.left_out),
    )


def _joined(
    placements: Sequence[PlacementPrediction],
    figures: Callable[[PlacementPrediction, ModelName], np.ndarray],
) -> ByModel[np.ndarray]:
    """Return figures of placements by each model, those of one after those of the other."""
    figures_by_name = {
        model: np.concatenate([figures(p, model) for p in placements])
        for model in names_of(p.points for p in placements)
    }
    return ByModel(**figures_by_name)


def placement_reports(
    predictions: Predictions, tolerance: float
) -> tuple[PlacementReport, ...]:
    """Return each placement's errors, those of the folds where it was left out, and its place."""
    document = predictions.document
    reports: list[PlacementReport] = []
    for row, placement in zip(document.placements, predictions.judged, strict=True):
        if placement.role == "left_out":
            parts = [part for part in document.left_out if part.name == row.name]
            row = row if len(parts) > 1 else parts[0]
            row = structs.replace(row, role="left_out", **mean_by_model(parts))
        errors = _joined([placement], PlacementPrediction.errors)
        centres = zip(placement.measured.sockets, placement.centres(), strict=True)
        report = PlacementReport.filled(
            row,
            position=as_point(placement.position),
            sockets=tuple(
                Socket(socket=k, centre=as_point(centre)) for k, centre in centres
            ),
            quantiles=errors.each(quantiles),
            within_tolerance=float(np.mean(errors.loaded <= tolerance)),
        )
        reports.append(report)
    return tuple(reports)


def sample_errors(
    predictions: Predictions, most: int | None = DRAWN
) -> tuple[SampleErrors, ...]:
    """Return the deviation of every sample from its socket's mean, thinned out to ``most``."""
    rows: list[SampleErrors] = []
    for index, placement in enumerate(predictions.judged):
        recorded = placement.measured.placement.samples
        ranks: list[int] = placement.measured.order.tolist()
        for i, (sample, rank) in enumerate(zip(placement.samples, ranks, strict=True)):
            place = recorded[rank].place
            number = f"sample {sample.number}, " * bool(sample.number)
            row = SampleErrors.filled(
                placement.deviations.each(lambda rows, i=i: as_point(rows[i].round(8))),
                placement=index,
                socket=sample.socket,
                number=sample.number or place,
                where=number + short_where(sample.where),
                weight=sample.weight,
            )
            rows.append(row)
    return tuple(rows if most is None else rows[:: -(-len(rows) // most)])


class KnownDistanceErrors(Document):
    """A distance between two sockets that was measured from outside, and the errors of models."""

    a: str
    """``PLACEMENT:SOCKET``."""
    b: str
    distance: float
    """As measured [m]."""
    standard_deviation: float
    """Of the measurement [m]."""
    in_fit: bool
    """True if the calibration was fitted to it: then it proves nothing."""
    nominal_error: float
    """Predicted less measured [m]."""
    calibrated_error: float
    geometric_error: float | None = None

    @property
    def errors(self) -> ByModel[float]:
        """The errors by model [m]."""
        nominal, calibrated = self.nominal_error, self.calibrated_error
        return ByModel(
            nominal=nominal, calibrated=calibrated, geometric=self.geometric_error
        )


def known_distance_errors(
    predictions: Predictions, lengths: Sequence[KnownDistance]
) -> tuple[KnownDistanceErrors, ...]:
    """Return the errors of all models at each known distance; raises KnownError."""
    placements = predictions.placements
    sockets = [
        (placement, k) for placement in placements for k in placement.measured.sockets
    ]
    labels = [(placement.name, k) for placement, k in sockets]
    centres = _joined(placements, PlacementPrediction.centres)
    # A distance that was fitted proves nothing; only sockets trained on can be fitted to.
    in_fit = bool(predictions.document.settings.get("known"))

    def errors(length: KnownDistance) -> KnownDistanceErrors:
        ends = length.first, length.second
        a, b = [find_socket(labels, end, where="known distance: ") for end in ends]
        errors = centres.each(
            lambda centre: (
                float(np.linalg.norm(centre[b] - centre[a])) - length.distance
            )
        )
        return KnownDistanceErrors(
            a="{}:{}".format(*labels[a]),
            b="{}:{}".format(*labels[b]),
            distance=length.distance,
            standard_deviation=length.deviation,
            in_fit=in_fit and sockets[a][0].role == sockets[b][0].role == "train",
            nominal_error=errors.nominal,
            calibrated_error=errors.calibrated,
            geometric_error=errors.geometric,
        )

    return tuple(map(errors, lengths))

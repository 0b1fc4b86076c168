"""The errors in ``report.json``: of samples, placements, roles, and known distances; in metres."""

import math
from typing import Generic, Literal, TypeVar

from ..results import Document, PlacementErrors, Role, Summary

ModelName = Literal["nominal", "calibrated", "geometric"]
"""``geometric``: ``calibrated.urdf`` as the user loads it."""
Value = TypeVar("Value")
Point = tuple[float, float, float]


class ByModel(Document, Generic[Value], kw_only=True, frozen=True):
    """The same figure by each model."""

    nominal: Value
    calibrated: Value
    """By the full model."""
    geometric: Value | None = None
    """By ``calibrated.urdf`` alone, where it is not the full model."""

    def of(self, model: ModelName) -> Value:
        """Return the figure of one model."""
        if model == "geometric" and self.geometric is not None:
            return self.geometric
        return self.nominal if model == "nominal" else self.calibrated

    @property
    def loaded(self) -> Value:
        """The figure by ``calibrated.urdf``, which is what a user loads."""
        return self.of("geometric")


class Quantiles(Document, kw_only=True, frozen=True):
    """How errors of single samples are distributed [m]."""

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
    """Where the calibrated model puts a socket."""

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


class KnownDistanceErrors(Document, kw_only=True, frozen=True):
    """A distance between two sockets that was measured from outside, and how far models are off."""

    a: str
    """``PLACEMENT:SOCKET``."""
    b: str
    distance: float
    """As measured [m]."""
    standard_deviation: float
    """Of the measurement [m]."""
    in_fit: bool
    """Whether the calibration was fitted to it: then it proves nothing."""
    nominal_error: float
    """Predicted less measured [m]."""
    calibrated_error: float
    geometric_error: float | None = None

    def error(self, model: ModelName) -> float:
        """Return the error of one model [m]."""
        if model == "geometric" and self.geometric_error is not None:
            return self.geometric_error
        return self.nominal_error if model == "nominal" else self.calibrated_error


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

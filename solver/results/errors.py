"""The errors of a calibration in ``calibration.json``: by placement, by role, by iteration."""

from typing import Literal

from ..data import Metrics
from .files import Document

Role = Literal["train", "test"]
"""Whether a placement was fitted, or held out to test the fit."""


class PlacementErrors(Document, kw_only=True, frozen=True):
    """How far off a placement is, by each model."""

    name: str
    role: Role
    samples: tuple[int, ...]
    """Number of samples in each socket."""
    kind: Literal["sockets", "points"] = "sockets"
    """``points`` where an instrument measured each ball: the errors are true ones, in space."""
    distance: float | None
    """Between the first two sockets, as measured [m]; None for points."""
    nominal: Metrics
    calibrated: Metrics
    """By the full model."""
    geometric: Metrics | None = None
    """By the exported URDF alone, where it is not the full model."""
    ball_refitted: Metrics | None = None
    """By the nominal model with only the ball's place on the flange fitted."""
    distance_source: str | None = None
    """Where the distance is from: ``given``, the ``recording``, or the ``default``."""
    predicted_deviation: float | None = None
    """Root mean square distance of samples from their socket's mean, as predicted [m]."""
    found_deviation: float | None = None
    """The same, as computed from the samples [m]."""

    @property
    def loaded(self) -> Metrics:
        """By ``calibrated.urdf``, which is what a user loads."""
        return self.geometric or self.calibrated


class Summary(Document, kw_only=True, frozen=True):
    """The means over the placements of one role."""

    nominal: Metrics
    calibrated: Metrics
    geometric: Metrics | None = None
    ball_refitted: Metrics | None = None
    removed_error: float
    """1 - calibrated / nominal, of the mean absolute error."""

    @property
    def loaded(self) -> Metrics:
        """By ``calibrated.urdf``, which is what a user loads."""
        return self.geometric or self.calibrated


class Summaries(Document, kw_only=True, frozen=True):
    """A summary for each role; None where no placement has it."""

    train: Summary | None
    test: Summary | None


class CostTerms(Document, kw_only=True, frozen=True):
    """The first two terms of Eq. (5), mean over the placements of a role [m^2]."""

    inconsistency: float
    distortion: float


class Iteration(Document, kw_only=True, frozen=True):
    """Where the fit stood after one step."""

    iteration: int
    train: CostTerms | None
    test: CostTerms | None

"""Estimates of a fit, their uncertainty and their use, in ``calibration.json``.

Lengths are metres, angles radians.
"""

from ..bayes.results import Direction
from ..design import ErrorMap, JointEffect
from .files import Document


class ParameterValue(Document, kw_only=True, frozen=True):
    """One number of a joint's origin, in metres or radians."""

    name: str
    joint: str
    component: str
    unit: str
    nominal: float
    calibrated: float
    change: float
    exported: float
    """As the exported URDF has it."""
    standard_deviation: float | None = None


class Coefficient(Document, kw_only=True, frozen=True):
    """One coefficient beyond the geometry: a joint's elasticity or transmission error."""

    name: str
    unit: str
    value: float
    standard_deviation: float


class PriorWidth(Document, kw_only=True, frozen=True):
    """A group of parameters that share a prior, and how wide the data made that prior."""

    name: str
    unit: str
    count: int
    width: float
    """Standard deviation of the prior."""
    effective: float
    """Number of its parameters that the data decide; the others stay where the prior has them."""
    active: bool


class NoiseScale(Document, kw_only=True, frozen=True):
    """Noise of the recordings, as the fit estimates it."""

    space: float
    """Of the ball's place in a socket [m]."""
    joint: float
    """Of the joint angles [rad]."""
    nu: float
    """Degrees of freedom of Student's distribution."""
    measured_space: float | None = None
    """Of balls that an instrument measured [m]; None, here and below, where none was."""
    measured_joint: float | None = None
    """Of the joint angles there [rad]."""


class Scale(Document, kw_only=True, frozen=True):
    """By how much the arm's lengths came out larger than nominal."""

    value: float
    """0.01 stands for an arm 1 % longer than its model."""
    deviation: float | None = None
    """Its standard deviation; None where it could not be computed, and in older files."""


class Correlation(Document, kw_only=True, frozen=True):
    """Two parameters that the data decide only together."""

    a: str
    b: str
    value: float


class DistanceDeviation(Document, kw_only=True, frozen=True):
    """Predicted error, one standard deviation, of distances between random poses [m]."""

    median: float
    worst: float
    length: float | None = None
    """The median of those distances; None in older files."""


class Uncertainty(Document, kw_only=True, frozen=True):
    """Uncertainty of the calibration."""

    weak_directions: tuple[Direction, ...]
    correlations: tuple[Correlation, ...]
    observability_index: float
    distance_deviation: DistanceDeviation
    cannot_see: tuple[str, ...]


class Forecast(Document, kw_only=True, frozen=True):
    """Gain of another placement, if it were trained on too."""

    placement: str | None
    """Its name; None for one that is not recorded yet, with 2 x 30 varied samples far from all."""
    distance_deviation: float
    """The predicted error of distances in the workspace would then be this [m]."""


class Outlook(Document, kw_only=True, frozen=True):
    """Predicted worth of a calibration."""

    joints: tuple[JointEffect, ...]
    """Effect of each joint."""
    map: ErrorMap | None = None
    """None by the paper's method, which does not say."""
    forecasts: tuple[Forecast, ...] = ()

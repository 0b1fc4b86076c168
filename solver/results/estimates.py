"""Estimates of a fit in ``calibration.json``, their uncertainty and their use: metres, radians."""

from dataclasses import dataclass

from ..robot import Origin
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


class LaterZero(Document, kw_only=True, frozen=True):
    """Zero of a joint that was found since the calibration was made (``mukca rezero``)."""

    joint: str
    offset: float
    """To be added to what the joint reads [rad], [m]."""
    standard_deviation: float


class ToolFrame(Document, kw_only=True, frozen=True):
    """A tool or camera found since the calibration was made (``mukca tool``, ``handeye``)."""

    name: str
    """Of its link."""
    parent: str
    """Link that carries it: the flange, or the base for a camera beside the arm."""
    xyz: tuple[float, float, float]
    """Its place there [m]."""
    rpy: tuple[float, float, float]
    """Its turn [rad]."""
    covariance: list[list[float]]
    """Of xyz, shape (3, 3) [m^2]."""

    @property
    def origin(self) -> Origin:
        """Place and turn, as a joint's origin."""
        return Origin(self.xyz, self.rpy)


class JointCurve(Document, kw_only=True, frozen=True):
    """Error curve of one joint: true position less what its encoder reads."""

    joint: str
    values: tuple[float, ...]
    """At 0, 1, .. 359 degrees [rad]; ``deflection.curve`` has its splines."""
    deviations: tuple[float, ...]
    """Standard deviation of each [rad]; where no angle was sampled, that of the process."""
    sampled: tuple[tuple[float, float], ...]
    """Ranges of angles within a length of a sample, from 0 to a turn [rad]."""


class ErrorCurves(Document, kw_only=True, frozen=True):
    """Error curves of all joints that turn: a Gaussian process (Matern 5/2, periodic in a turn)."""

    amplitude: float
    """Standard deviation of a curve before the data [rad]."""
    length: float
    """Angle over which it changes [rad]: its bumps are some four times as wide."""
    joints: tuple[JointCurve, ...]


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
    measured_turn: float | None = None
    """Of orientations that an instrument measured, about each axis [rad]."""


class StoredPosterior(Document, kw_only=True, frozen=True):
    """Beginning of a later calibration: with values and samples, it gives all covariances."""

    version: int = 1
    covariance: str
    """Lower triangle of the covariance of parameters, coefficients but for curves, frames (a turn
    about the world's axes, then a shift) and sockets: float64, deflate, base64."""
    noises: dict[str, tuple[float, float, float]]
    """By kind of samples, noise in space [m] or turn [rad] and of the joints [rad], and nu."""
    centres: tuple[tuple[float, float, float], ...] = ()
    """Of the sockets in the base [m]."""


class Scale(Document, kw_only=True, frozen=True):
    """By how much the arm's lengths came out larger than nominal."""

    value: float
    """0.01 stands for an arm 1 % longer than its model."""
    deviation: float | None = None
    """Its standard deviation; None where it could not be computed, and in older files."""


class DistanceDeviation(Document, kw_only=True, frozen=True):
    """Predicted error, one standard deviation, of distances between random poses [m]."""

    median: float
    worst: float
    length: float | None = None
    """The median of those distances; None in older files."""
    alone: float | None = None
    """Median for the exported URDF by itself; None where that is the full model."""


@dataclass(frozen=True)
class Direction:
    """One change of the geometry that the data cannot tell."""

    text: str
    deviation: float
    """Its standard deviation after the data (posterior), as a share of that before (prior):
    1 where the data say nothing, near 0 where they say all."""


@dataclass(frozen=True)
class Correlation:
    """Two parameters that the data decide only together."""

    a: str
    b: str
    value: float


class Uncertainty(Document, kw_only=True, frozen=True):
    """Uncertainty of the calibration."""

    weak_directions: tuple[Direction, ...]
    correlations: tuple[Correlation, ...]
    observability_index: float
    distance_deviation: DistanceDeviation
    """In the whole workspace."""
    near: DistanceDeviation | None = None
    """Near the recorded places, at the one where it is largest; None in older files."""
    cannot_see: tuple[str, ...]


class Interval(Document, kw_only=True, frozen=True):
    """An error of distances [m], with its 68 % interval."""

    value: float
    low: float
    high: float


class ErrorParts(Document, kw_only=True, frozen=True):
    """Held-out error in three parts that add in squares: root mean squares over samples [m]."""

    error: float
    """Distance of samples from their socket's mean."""
    noise: float
    """Of the ball's seat and the encoders: it stays."""
    want_of_data: float
    """More samples and placements make it smaller."""
    not_in_model: Interval
    """The other errors, of which the model lacks the cause, with their 95 % interval."""

    @property
    def shares(self) -> tuple[float, float, float]:
        """Shares of the three parts in the mean square, which add to 1."""
        sizes = self.noise, self.want_of_data, self.not_in_model.value
        noise, want, lacking = [size**2 / self.error**2 for size in sizes]
        return noise, want, lacking

    @property
    def brief(self) -> str:
        """The parts in one line."""
        sizes = self.error, self.noise, self.want_of_data, self.not_in_model.value
        error, noise, want, lacking = [f"{1e3 * size:.2f}" for size in sizes]
        parts = f"{noise} noise, {want} want of data, {lacking} not in the model"
        return f"Held out {error} mm (rms): {parts}."

    @property
    def text(self) -> str:
        """The same with the interval of what is not in the model."""
        low = f"{1e3 * self.not_in_model.low:.2f}"
        high = f"{1e3 * self.not_in_model.high:.2f}"
        return f"{self.brief[:-1]} (95 %: {low} to {high}); the parts add in squares."


class Improvement(Document, kw_only=True, frozen=True):
    """Errors of distances before a calibration and after it: medians over pairs of poses."""

    before: Interval
    """By the nominal model with its ball refitted."""
    now: Interval
    """By ``calibrated.urdf``."""
    corrected: Interval | None = None
    """With joint positions corrected first; None where that is ``calibrated.urdf``."""
    probability: float
    """Probability that ``calibrated.urdf`` is better than the nominal model."""
    corrected_probability: float | None = None
    """The same with joint positions corrected first."""


class Better(Document, kw_only=True, frozen=True):
    """Improvement by a calibration."""

    workspace: Improvement
    """Distances between random poses of the workspace."""
    recorded_places: Improvement | None = None
    """Distances near the recorded places, at the worst of them; None where none is in reach."""

    @property
    def places(self) -> tuple[Improvement, ...]:
        """Those of the workspace, and of the recorded places where there are any."""
        return (self.workspace, *filter(None, [self.recorded_places]))

    @property
    def probability(self) -> float:
        """Probability that ``calibrated.urdf`` is better, where that is the least sure."""
        return min(place.probability for place in self.places)

    @property
    def corrected_probability(self) -> float | None:
        """The same with joint positions corrected first; None where that is no other model."""
        those = [place.corrected_probability for place in self.places]
        return min((p for p in those if p is not None), default=None)


class Apart(Document, kw_only=True, frozen=True):
    """Mean distance of the balls of two calibrations, and what chance would make of it [m]."""

    value: float
    """After a rigid motion of the base frame."""
    chance: float
    """Its mean, if the arm is the same and all that the models lack is noise."""
    deviation: float
    """Its standard deviation by chance."""
    largest: float
    """By chance 19 of 20 are not larger."""
    probability: float
    """That chance alone makes it as large."""

    @property
    def beyond_chance(self) -> bool:
        """True if it is larger than 19 of 20 would be by chance."""
        return self.value > self.largest


class Forecast(Document, kw_only=True, frozen=True):
    """Gain of another placement, if it were trained on too."""

    placement: str | None
    """Its name; None for one that is not recorded yet, with 2 x 30 varied samples far from all."""
    distance_deviation: float
    """The predicted error of distances in the workspace would then be this [m]."""


@dataclass(frozen=True)
class ErrorMap:
    """Predicted errors of places, relative to those that were recorded."""

    width: float
    """Of a square cell [m]."""
    cells: tuple[tuple[float, float, float], ...]
    """For each cell that random poses reach, from above: x and y of its middle in the base frame,
    and the standard deviation of its distance from what was trained on [m]."""


@dataclass(frozen=True)
class JointEffect:
    """Displacement of the ball by a joint's calibrated numbers: root mean square over poses [m]."""

    joint: str
    recorded: float
    """Over the samples that were trained on."""
    workspace: float
    """Over random poses of the workspace."""


class Outlook(Document, kw_only=True, frozen=True):
    """Predicted worth of a calibration."""

    joints: tuple[JointEffect, ...]
    """Effect of each joint."""
    map: ErrorMap | None = None
    """None by the paper's method, which does not say."""
    forecasts: tuple[Forecast, ...] = ()

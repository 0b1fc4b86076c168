"""Estimates of a fit in ``calibration.json``, their uncertainty, use and folds: metres, radians."""

from dataclasses import dataclass, replace

import numpy as np

from ..identification.model import Deflection
from ..identification.robot import Origin
from .calibrated import CalibratedRobot, Place
from .files import Document


class ParameterValue(Document):
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


class Coefficient(Document):
    """One coefficient beyond the geometry: a joint's elasticity or transmission error."""

    name: str
    unit: str
    value: float
    standard_deviation: float


class LaterZero(Document):
    """Zero of a joint that was found since the calibration was made (``mukca rezero``)."""

    joint: str
    offset: float
    """To be added to what the joint reads [rad], [m]."""
    standard_deviation: float


class ToolFrame(Document):
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


class JointCurve(Document):
    """Error curve of one joint: true position less what its encoder reads."""

    joint: str
    values: tuple[float, ...]
    """At 0, 1, .. 359 degrees [rad]; ``deflection.curve`` has its splines."""
    deviations: tuple[float, ...]
    """Standard deviation of each [rad]; where no angle was sampled, that of the process."""
    sampled: tuple[tuple[float, float], ...]
    """Ranges of angles within a length of a sample, from 0 to a turn [rad]."""


class ErrorCurves(Document):
    """Error curves of all joints that turn: a Gaussian process (Matern 5/2, periodic in a turn)."""

    amplitude: float
    """Standard deviation of a curve before the data [rad]."""
    length: float
    """Angle over which it changes [rad]: its bumps are some four times as wide."""
    joints: tuple[JointCurve, ...]


class PriorWidth(Document):
    """A group of parameters that share a prior, and how wide the data made that prior."""

    name: str
    unit: str
    count: int
    width: float
    """Standard deviation of the prior."""
    effective: float
    """Number of its parameters that the data decide; the others stay where the prior has them."""
    active: bool


class NoiseScale(Document):
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


class StoredPosterior(Document):
    """Beginning of a later calibration: with values and samples, it gives all covariances."""

    version: int = 1
    covariance: str
    """Lower triangle of the covariance of parameters, coefficients but for curves, frames (a turn
    about the world's axes, then a shift) and sockets: float64, deflate, base64."""
    noises: dict[str, tuple[float, float, float]]
    """By kind of samples, noise in space [m] or turn [rad] and of the joints [rad], and nu."""
    centres: tuple[tuple[float, float, float], ...] = ()
    """Of the sockets in the base [m]."""


class Scale(Document):
    """By how much the arm's lengths came out larger than nominal."""

    value: float
    """0.01 stands for an arm 1 % longer than its model."""
    deviation: float | None = None
    """Its standard deviation; None where it could not be computed, and in older files."""


class DistanceDeviation(Document):
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


class Uncertainty(Document):
    """Uncertainty of the calibration."""

    weak_directions: tuple[Direction, ...]
    correlations: tuple[Correlation, ...]
    observability_index: float
    distance_deviation: DistanceDeviation
    """In the whole workspace."""
    near: DistanceDeviation | None = None
    """Near the recorded places, at the one where it is largest; None in older files."""
    cannot_see: tuple[str, ...]


class FoldModel(Document):
    """The model of a fold, in the parameters of the calibration."""

    values: tuple[float, ...]
    """Of the parameters [m, rad]."""
    exported: tuple[float, ...]
    """The same for a URDF alone."""
    deflection: dict[str, tuple[float, ...]]
    """Coefficients of each extension of the geometry."""
    ball: Place | None
    """The nominal ball in its link, refitted [m]."""

    @classmethod
    def of(cls, calibrated: CalibratedRobot, ball: Place | None) -> "FoldModel":
        """Return what a document keeps of a calibrated robot."""
        by_name = calibrated.deflection.by_name
        return cls(
            values=tuple(calibrated.values.tolist()),
            exported=tuple(calibrated.geometry.tolist()),
            deflection={name: tuple(row.tolist()) for name, row in by_name.items()},
            ball=ball,
        )

    def robot(self, calibrated: CalibratedRobot) -> CalibratedRobot:
        """Return the calibrated robot with the numbers of this fold."""
        coefficients = tuple(map(np.array, self.deflection.values()))
        return replace(
            calibrated,
            values=np.array(self.values, dtype=float),
            deflection=Deflection(tuple(self.deflection), coefficients),
            exported=np.array(self.exported, dtype=float) if self.deflection else None,
        )

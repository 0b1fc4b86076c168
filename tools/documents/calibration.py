"""What ``calibration.json`` holds: the robot before and after, every sample, all figures.

Lengths are metres, angles radians, masses kilograms. The file needs no other to be used: it holds
the text of the nominal and of the calibrated URDF.
"""

from pathlib import Path
from typing import Any, Literal

import numpy as np

from ... import MukcaError
from ...recorder.dataset import Placement, Sample
from ...solver.auto.deflection import EXTENSIONS, Deflection, coefficient_names
from ...solver.auto.directions import Direction
from ...solver.calibrated import CalibratedRobot
from ...solver.checks.inspection import Finding
from ...solver.data.load import Load
from ...solver.data.metrics import Metrics
from ...solver.robot.parameters import all_parameters
from ...solver.robot.urdf import parse_robot
from ...solver.robot.urdf_text import scan
from .arms import ArmsDocument, FramePose
from .files import Document, DocumentError, read
from .outlook import Outlook

__all__ = [
    "FORMAT",
    "CalibrationDocument",
    "CarriedLoad",
    "Coefficient",
    "Correlation",
    "CostTerms",
    "Iteration",
    "Model",
    "PlacementErrors",
    "PlacementSamples",
    "Result",
    "Role",
    "Scale",
    "Summaries",
    "Summary",
    "Uncertainty",
    "calibrated_robot",
    "misfit",
    "read_calibration",
]

FORMAT = "mukca-calibration-1"
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
    """How many of its parameters the data decide; the others stay where the prior has them."""
    active: bool


class NoiseScale(Document, kw_only=True, frozen=True):
    """How noisy the recordings are, as the fit estimates it."""

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


class Scale(Document, kw_only=True, frozen=True):
    """By how much the arm's lengths came out larger than nominal."""

    value: float
    """0.01 stands for an arm 1 % longer than its model."""
    deviation: float | None = None
    """Its standard deviation; None by the paper's method, which does not say."""


class Uncertainty(Document, kw_only=True, frozen=True):
    """How well the calibration is known."""

    weak_directions: tuple[Direction, ...]
    correlations: tuple[Correlation, ...]
    observability_index: float
    distance_deviation: DistanceDeviation
    cannot_see: tuple[str, ...]


class CostTerms(Document, kw_only=True, frozen=True):
    """The first two terms of Eq. (5), mean over the placements of a role [m^2]."""

    inconsistency: float
    distortion: float


class Iteration(Document, kw_only=True, frozen=True):
    """Where the fit stood after one step."""

    iteration: int
    train: CostTerms | None
    test: CostTerms | None


class NextPlacement(Document, kw_only=True, frozen=True):
    """Where to record next, in words."""

    text: str


class Provenance(Document, kw_only=True, frozen=True):
    """What a result was made from and with."""

    created: str
    model_sha256: str
    data_sha256: dict[str, str]
    versions: dict[str, str]


class Result(Document, kw_only=True, frozen=True):
    """What a calibration says of itself: the object that ``mukca solve --json`` prints."""

    robot: str
    method: str
    optimizer: str
    iterations: int
    converged: bool
    solve_seconds: float
    placements: tuple[PlacementErrors, ...]
    summary: Summaries
    distorted: tuple[str, ...]
    """Training placements whose distance between sockets the model does not reproduce."""
    parameters: tuple[ParameterValue, ...]
    coefficients: tuple[Coefficient, ...] | None = None
    groups: tuple[PriorWidth, ...] | None = None
    noise: NoiseScale | None = None
    log_evidence: float | None = None
    uncertainty: Uncertainty | None = None
    scale: Scale | None = None
    frames: tuple[FramePose, ...] | None = None
    """Where the frames stand in which positions were measured; None where there is none."""
    choices: tuple[str, ...] | None = None
    """What became of each extension, and why."""
    history: tuple[Iteration, ...]
    settings: dict[str, Any]
    """The options of ``mukca solve`` that make this result again."""
    provenance: Provenance
    checks: tuple[Finding, ...] | None = None
    """What was found in the recordings; None where they could not be checked."""
    next_placement: NextPlacement | None = None
    warnings: tuple[str, ...]
    outputs: dict[str, str]
    """The files written, by kind."""


class Model(Document, kw_only=True, frozen=True):
    """The robot's model, before and after."""

    name: str
    source: str
    sha256: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    nominal_urdf: str
    calibrated_urdf: str


class RecordedSample(Document, kw_only=True, frozen=True):
    """One sample; its joint positions in the chain's order [rad, m for prismatic joints]."""

    socket: int
    position: tuple[float, ...]
    effort: tuple[float, ...] | None
    """What the joints exerted [N m]; None where it was not measured."""
    point: tuple[float, float, float] | None = None
    """Where an instrument measured the ball, in its frame [m]; None for a ball in a socket."""
    where: str = ""
    """File and line."""
    weight: float | None = None
    """Robust weight in the fit: 1 and less; None where there was none."""


class PlacementSamples(Document, kw_only=True, frozen=True):
    """The samples of one placement."""

    name: str
    role: Role
    distance: float
    files: tuple[str, ...]
    frame: str | None = None
    """The instrument's frame, where its recording names it."""
    samples: tuple[RecordedSample, ...]

    @property
    def folder(self) -> str:
        """Where it was recorded; a question mark for samples that came from no file."""
        return str(Path(self.files[0]).parent) if self.files else "?"

    def placement(self, joint_names: tuple[str, ...]) -> Placement:
        """Return the placement as it was recorded, columns in the chain's order."""
        return Placement(
            name=self.name,
            samples=tuple(
                Sample(s.position, s.socket, s.effort, s.where, point=s.point) for s in self.samples
            ),
            joint_names=joint_names,
            distance=self.distance,
            files=tuple(map(Path, self.files)),
            frame=self.frame,
        )


class CarriedLoad(Document, kw_only=True, frozen=True):
    """What pulled at the joints while recording."""

    gravity: tuple[float, float, float]
    """In the base frame [m/s^2]."""
    payload: float
    """Mass at the ball beyond that of the model [kg]."""


class CalibrationDocument(Result, kw_only=True, frozen=True):
    """All of ``calibration.json``."""

    format: str
    model: Model
    deflection: dict[str, tuple[float, ...]]
    """Coefficients of each extension of the geometry."""
    load: CarriedLoad
    data: tuple[PlacementSamples, ...]
    outlook: Outlook | None = None
    """None where it was not worked out."""
    arm_name: str = ""
    """Where several robots were calibrated together, the name of this one."""
    arms: ArmsDocument | None = None
    """What it has in common with the others."""


def read_calibration(file: Path) -> CalibrationDocument:
    """Read a ``calibration.json``.

    Raises:
        DocumentError: Missing, of another format, or damaged; the line names the key.
    """
    return read(file, CalibrationDocument, FORMAT)


def calibrated_robot(document: CalibrationDocument, source: str) -> CalibratedRobot:
    """Return the robot that a calibration describes.

    Args:
        document: The calibration.
        source: Its file, for messages.

    Raises:
        DocumentError: The document's parts do not fit each other; the line names the key.
    """
    model = document.model
    try:
        robot = parse_robot(
            scan(model.nominal_urdf.encode(), "nominal_urdf"),
            source=model.source,
            base=model.base,
            tip=model.tip,
        )
    except MukcaError as error:
        raise misfit(source, "model", str(error)) from None
    values = {value.name: value for value in document.parameters}
    parameters = tuple(p for p in all_parameters(robot) if p.name in values)
    if not len(parameters) == len(values) == len(document.parameters):
        raise misfit(source, "parameters", "not those of the joints of model.nominal_urdf")
    for extension, coefficients in document.deflection.items():
        if extension not in EXTENSIONS:
            raise misfit(source, f"deflection.{extension}", "no extension of this version")
        expected = len(coefficient_names(extension, robot.joint_names))
        if len(coefficients) != expected:
            words = f"{len(coefficients)} coefficients, but the joints need {expected}"
            raise misfit(source, f"deflection.{extension}", words)
    calibrated, exported = (
        np.array([getattr(values[p.name], key) for p in parameters], dtype=float)
        for key in ("calibrated", "exported")
    )
    deflection = Deflection(
        tuple(document.deflection), tuple(map(np.array, document.deflection.values()))
    )
    return CalibratedRobot(
        robot,
        parameters,
        calibrated,
        deflection,
        Load(document.load.gravity, document.load.payload),
        exported if document.deflection else None,
    )


def misfit(source: str, key: str, words: str) -> DocumentError:
    """Return the error for a part that does not fit the others."""
    return DocumentError(f"{source}: damaged calibration.json: `{key}`: {words}")

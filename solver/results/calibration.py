"""Content of ``calibration.json``, all that is needed to use it: metres, radians, kilograms."""

from dataclasses import replace
from typing import Any

from ...errors import MukcaError
from ..identification.data import Load
from ..identification.robot import RotationNumbers, all_parameters, parse_robot, scan
from . import estimates, worth
from .calibrated import CalibratedRobot
from .estimates import FoldModel
from .files import Document, DocumentError
from .placements import (
    Diagnostic,
    Hypothesis,
    Iteration,
    NextPlacement,
    PlacementErrors,
    PlacementSamples,
    Summaries,
)
from .worth import ErrorPatterns

FORMAT = "mukca-calibration-1"
ARMS_FORMAT = "mukca-arms-1"
UNSEEN = 0.1
"""A turn whose standard deviation is larger than this counts as unknown [rad]."""


class FramePose(Document):
    """Pose of a frame in the robot's base, with its uncertainty."""

    name: str
    xyz: tuple[float, float, float]
    """Its origin [m]."""
    rpy: tuple[float, float, float]
    """Its turn about the base's x, then y, then z axis [rad]."""
    xyz_deviation: tuple[float, float, float]
    """Standard deviation of its origin [m]."""
    turn_deviation: tuple[float, float, float]
    """Standard deviation of its turn about the base's x, y and z axes [rad]."""
    sockets: int
    """Number of sockets that have measured coordinates in it."""
    points: int
    """Number of balls that an instrument measured in it."""
    socket_error: float | None
    """Root mean square distance of those sockets from their coordinates [m]; None without any."""

    @property
    def turn_known(self) -> bool:
        """True if its direction is known: one or two places leave it free to turn."""
        return max(self.turn_deviation) < UNSEEN


class UrdfPose(Document):
    """Pose of a robot's base in the first one's, in a file with both: fitted for their URDFs."""

    xyz: tuple[float, float, float]
    """Origin of the second base in the first [m]."""
    rpy: tuple[float, float, float]
    """Its turn [rad]."""
    tool_error: float
    """Error of the vector from tool to tool against the full models, at the places that both
    share, a root mean square [m]."""


class BaseToBase(Document):
    """Pose of a robot's base in the first one's, and the error between their tools."""

    xyz: tuple[float, float, float] | None
    """Origin of the second base in the first [m]; None, here and below, where the recordings
    leave a turn of the one against the other."""
    rpy: tuple[float, float, float] | None
    """Its turn [rad]."""
    xyz_deviation: tuple[float, float, float] | None
    """Standard deviation of the origin [m]."""
    turn_deviation: tuple[float, float, float] | None
    """Standard deviation of the turn about the first base's axes [rad]."""
    tool_deviation: float | None
    """Predicted error of where the second tool stands seen from the first, over the shared region,
    a root mean square [m]."""
    shared_sockets: int
    """Number of sockets that both visited."""
    text: str
    """All that in words."""
    urdf: UrdfPose | None = None
    """The pose in ``arms.urdf``; None where it is the same, and in older files."""


class GivenArm(Document):
    """One of the robots: what was given of it, and how it stood."""

    name: str
    robot: str
    """As it was named to ``mukca solve``."""
    options: dict[str, Any]
    """Further options of it: base, tip, flange, ball."""
    train: tuple[str, ...]
    """Folders of the placements trained on."""
    test: tuple[str, ...]
    """Folders of those held out."""
    postures: list[list[list[float]]]
    """Places of its joints at a sample of each shared socket, seen from the first robot's base,
    shape (sockets, joints + 1, 3) [m]: base first, ball last. Empty where its pose is not known."""


class VisitedSocket(Document):
    """A socket, and who was there."""

    name: str
    """Placement and number."""
    xyz: tuple[float, float, float]
    """In the first robot's base [m]."""
    robots: tuple[str, ...]


class ArmsDocument(Document):
    """Relations between several robots that were calibrated together."""

    format: str = ""
    """Of the file; empty inside of others, and in older files."""
    robots: tuple[str, ...]
    """Their names; the first one's base is the world."""
    between: dict[str, BaseToBase]
    """By ``FIRST_to_SECOND``."""
    frames: tuple[FramePose, ...]
    """Poses of the frames in which positions were measured."""
    arms: tuple[GivenArm, ...] = ()
    """In the order of their names."""
    sockets: tuple[VisitedSocket, ...] = ()
    output_sha256: dict[str, str] | None = None
    """Digests of the files written with it, by their paths beside it; None in older files."""


class Provenance(Document):
    """Provenance of a result: digests of its data, versions, time."""

    created: str
    model_sha256: str
    data_sha256: dict[str, str]
    versions: dict[str, str]
    output_sha256: dict[str, str] | None = None
    """Digests of the files written with it, by name; None in older files."""


class FitResult(Document):
    """Result of a fit: parameters, uncertainty and history, in calibration.json and report.json."""

    robot: str
    """As it was named to ``mukca solve``."""
    method: str
    optimizer: str
    iterations: int
    parameters: tuple[estimates.ParameterValue, ...]
    rotation_numbers: RotationNumbers = "rpy"
    """Kind of the angles among the parameters: components of a rotation vector that turns the
    joint's nominal frame about its own axes, or as in older files the origin's roll, pitch, yaw."""
    coefficients: tuple[estimates.Coefficient, ...] | None = None
    curves: estimates.ErrorCurves | None = None
    """None where the data support none, and in older files."""
    groups: tuple[estimates.PriorWidth, ...] | None = None
    noise: estimates.NoiseScale | None = None
    log_evidence: float | None = None
    uncertainty: estimates.Uncertainty | None = None
    better: worth.Better | None = None
    """Errors that the calibration improves; None by the paper's method, and in older files."""
    error_parts: worth.ErrorParts | None = None
    """None where nothing was held out in sockets, by the paper's method, and in older files."""
    error_patterns: ErrorPatterns | None = None
    """Patterns of the rest of the error; None by the paper's method, and in older files."""
    scale: estimates.Scale | None = None
    frames: tuple[FramePose, ...] | None = None
    """Poses of the frames in which positions were measured; None where there is none."""
    choices: tuple[str, ...] | None = None
    """Decision on each extension, and its reason."""
    history: tuple[Iteration, ...]
    checks: tuple[Diagnostic, ...] | None = None
    """Diagnostics of the recordings; None where they could not be checked."""
    hypotheses: tuple[Hypothesis, ...] | None = None
    """Explanations of the recordings, the most probable first; None where they were not checked."""
    next_placement: NextPlacement | None = None
    warnings: tuple[str, ...]
    outlook: worth.Outlook | None = None
    """None where it was not worked out."""
    arm_name: str = ""
    """Name of this robot, if several were calibrated together."""
    arms: ArmsDocument | None = None
    """Its relations to the others."""
    later_zeros: tuple[estimates.LaterZero, ...] = ()
    """Zeros found since, the samples put into their terms; for another rezero, both count."""
    tools: tuple[estimates.ToolFrame, ...] = ()
    """Tools found since."""


class Result(FitResult):
    """Result of a calibration: the object that ``mukca solve --json`` prints."""

    converged: bool
    solve_seconds: float
    placements: tuple[PlacementErrors, ...]
    summary: Summaries
    left_out: tuple[PlacementErrors, ...] = ()
    """Errors of each placement by the fit that left it out, part by part where fits left out parts;
    empty where something was held out, and in older files."""
    distorted: tuple[str, ...]
    """Training placements whose distance between sockets the model does not reproduce."""
    settings: dict[str, Any]
    """The options of ``mukca solve`` that make this result again."""
    provenance: Provenance
    outputs: dict[str, str]
    """The files written, by kind."""

    @property
    def unseen(self) -> tuple[PlacementErrors, ...]:
        """Errors of what a fit did not see: held out, or where nothing is, left out."""
        held_out = tuple(row for row in self.placements if row.role == "test")
        return held_out or self.left_out


class Model(Document):
    """The robot's model, before and after."""

    name: str
    source: str
    sha256: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    nominal_urdf: str
    calibrated_urdf: str


class CalibrationDocument(Result):
    """All of ``calibration.json``."""

    format: str
    model: Model
    deflection: dict[str, tuple[float, ...]]
    """Coefficients of each extension of the geometry."""
    load: Load
    """Load of the joints while recording."""
    data: tuple[PlacementSamples, ...]
    refitted_ball: tuple[float, float, float] | None = None
    """The ball of the nominal model in its link, fitted to what was trained on [m]; None where that
    is not identified, and in older files."""
    folds: tuple[FoldModel, ...] = ()
    """Models of the fits that each left out some samples; empty in older files."""
    misfit: float | None = None
    """Error of left-out samples beyond the posterior, in units of the noise of their fit; None
    where nothing was left out."""
    tail: float | None = None
    """Factor by which 95 of 100 left-out samples need more than normal errors do; None likewise."""
    posterior: estimates.StoredPosterior | None = None
    """None by the paper's method, of several robots, and in older files."""

    @property
    def later_offsets(self) -> list[float]:
        """Offsets of all joints by the zeros found since, in chain order [rad, m]."""
        offsets = {zero.joint: zero.offset for zero in self.later_zeros}
        return [offsets.get(name, 0.0) for name in self.model.joint_names]


def calibrated_robot(document: CalibrationDocument, source: str) -> CalibratedRobot:
    """Return the robot that a calibration describes, which messages name by its source."""
    model = document.model
    try:
        text = scan(model.nominal_urdf.encode(), "nominal_urdf")
        text.source = model.source
        robot = parse_robot(text, base=model.base, tip=model.tip)
        # Older files have the tilts of the frames' axes.
        if document.rotation_numbers == "rpy":
            joints = tuple(replace(joint, tilt_axes=None) for joint in robot.joints)
            robot = replace(robot, joints=joints)
    except MukcaError as error:
        raise misfit(source, "model", str(error)) from None
    if robot.joint_names != model.joint_names:
        words = f"the URDF has {', '.join(robot.joint_names)}"
        raise misfit(source, "model.joint_names", words)
    values = {value.name: value for value in document.parameters}
    parameters = tuple(p for p in all_parameters(robot) if p.name in values)
    if not len(parameters) == len(values) == len(document.parameters):
        raise misfit(
            source, "parameters", "not those of the joints of model.nominal_urdf"
        )
    numbers = estimates.FoldModel(
        values=tuple(values[p.name].calibrated for p in parameters),
        exported=tuple(values[p.name].exported for p in parameters),
        deflection=document.deflection,
        ball=None,
    )
    kind = document.rotation_numbers
    return numbers.robot(
        CalibratedRobot(robot, parameters, load=document.load, rotation_numbers=kind)
    )


def misfit(source: str, key: str, words: str) -> DocumentError:
    """Return the error for a part that does not fit the others."""
    return DocumentError(f"{source}: damaged calibration.json: `{key}`: {words}")

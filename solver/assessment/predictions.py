"""Predictions of the ball in each sample by all models, and the joint ranges that these cover."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from msgspec import structs

from ...recorder import ALL_ROUND, arc
from ..identification.data import (
    Measurement,
    Pose,
    fit_frames,
    measure,
    socket_centres,
    targets,
)
from ..identification.robot import Robot
from ..results import (
    MODELS,
    ByModel,
    CalibratedRobot,
    CalibrationDocument,
    Document,
    DocumentError,
    ModelName,
    RecordedSample,
    Role,
    calibrated_robot,
    misfit,
    names_of,
    target_predictions,
)
from .formatting import short_names

Point = tuple[float, float, float]
Frames = Mapping[str, Mapping[str, Pose]]
DRAWN = 3000
"""Samples drawn at most; all figures are computed from all of them."""
_AGREE = 1e-6
"""Figures in the file and those that follow from its samples differ by less than this [m]."""


@dataclass(frozen=True)
class PlacementPrediction:
    """The ball's centre in each sample of one placement, by both models."""

    measured: Measurement
    role: Role
    points: ByModel[np.ndarray]
    """Predicted ball centres, socket after socket, shape (N, 3) [m]."""
    samples: tuple[RecordedSample, ...]
    """The samples in the order of the points."""
    frames: Frames
    """Poses of the instruments' frames by each model."""

    @property
    def name(self) -> str:
        """The placement's name."""
        return self.measured.name

    @cached_property
    def deviations(self) -> ByModel[np.ndarray]:
        """Each predicted centre less its socket's mean, or the measured point, shape (N, 3) [m]."""

        def deviations(model: ModelName) -> np.ndarray:
            points = self.points.of(model)
            return points - targets(points, self.measured, self.frames[model])

        return self.points.by_name(deviations)

    def errors(self, model: ModelName) -> np.ndarray:
        """Return the length of each deviation, shape (N,) [m]."""
        return np.linalg.norm(self.deviations.of(model), axis=1)

    def centres(self, model: ModelName = "calibrated") -> np.ndarray:
        """Return where a model puts the sockets, shape (sockets, 3) [m]."""
        return socket_centres(self.points.of(model), self.measured)

    @cached_property
    def position(self) -> np.ndarray:
        """The middle of the sockets in the base frame, by the calibrated model, shape (3,) [m]."""
        return self.centres().mean(axis=0)


@dataclass(frozen=True)
class Predictions:
    """A calibration, and the predictions of its models for all its samples."""

    document: CalibrationDocument
    source: str
    """Name of its file in messages."""
    calibration: CalibratedRobot
    placements: tuple[PlacementPrediction, ...]
    left_out: tuple[PlacementPrediction, ...] = ()
    """Placements that folds leave out, by the folds' models; in the order of the document's."""

    @property
    def all(self) -> list[PlacementPrediction]:
        """All placements, those that folds leave out once more."""
        return [*self.placements, *self.left_out]

    @property
    def unseen(self) -> list[PlacementPrediction]:
        """Placements by fits that did not see them: held out, or where none is, left out."""
        return self.of_role("test") or [*self.left_out]

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.calibration.robot

    @cached_property
    def judged(self) -> list[PlacementPrediction]:
        """All placements, what folds leave out by the folds: their errors prove something."""
        by_name: dict[str, list[PlacementPrediction]] = {}
        for part in self.left_out:
            by_name.setdefault(part.name, []).append(part)
        return [
            _in_parts(placement, by_name.get(placement.name, ()))
            for placement in self.placements
        ]

    @property
    def names(self) -> list[str]:
        """Short names of the placements."""
        return short_names([placement.name for placement in self.placements])

    def of_role(self, role: Role) -> list[PlacementPrediction]:
        """Return the placements of a role."""
        return [placement for placement in self.placements if placement.role == role]


def predict(document: CalibrationDocument, source: str) -> Predictions:
    """Return what the models of a calibration predict for its samples; raises DocumentError."""
    calibration = calibrated_robot(document, source)
    measured = measurements_of(document, calibration.robot)
    parts = [
        _Part(m, row.role, row.by_socket)
        for row, m in zip(document.data, measured, strict=True)
    ]
    placements = _predicted(calibration, parts)
    left_out: list[PlacementPrediction] = []
    for number, fold in enumerate(document.folds):
        fold_parts = [*_parts(document, measured, number)]
        predicted = _predicted(fold.robot(calibration), fold_parts)
        left_out += [p for p in predicted if p.role == "left_out"]
    _check(document, placements, left_out, source)
    return Predictions(
        document, source, calibration, tuple(placements), tuple(left_out)
    )


def _in_parts(
    placement: PlacementPrediction, parts: Sequence[PlacementPrediction]
) -> PlacementPrediction:
    """Return a placement with the deviations of its parts, which folds left out, if all were."""
    ranks = {id(sample): i for i, sample in enumerate(placement.samples)}
    if sum(len(part.samples) for part in parts) < len(ranks):
        return placement
    if len(parts) == 1:
        return parts[0]

    def points(model: ModelName) -> np.ndarray:
        points = placement.points.of(model)
        predicted = targets(points, placement.measured, placement.frames.get(model))
        for part in parts:
            rows = [ranks[id(sample)] for sample in part.samples]
            predicted[rows] += part.deviations.of(model)
        return predicted

    models = names_of(part.points for part in parts)
    by_model = ByModel(**{name: points(name) for name in models})
    return replace(placement, role="left_out", points=by_model)


class _Part(NamedTuple):
    """Samples of a placement: all of them, or those on one side of a fold."""

    measured: Measurement
    role: Role
    samples: tuple[RecordedSample, ...]
    """In the order of the rows of ``measured``."""


def _parts(
    document: CalibrationDocument, measurements: Sequence[Measurement], fold: int
) -> Iterator[_Part]:
    """Yield the samples trained on by placement, and apart from them those that a fold left out."""
    roles: dict[Role, bool] = {"train": False, "left_out": True}
    for row, measured in zip(document.data, measurements, strict=True):
        for role, is_in_fold in roles.items() if row.role == "train" else ():
            pairs = enumerate(row.samples)
            ranks = [i for i, s in pairs if (s.fold == fold) == is_in_fold]
            if ranks:
                part = replace(measured.only(np.array(ranks)), moved=None)
                samples = tuple(row.samples[i] for i in ranks)
                recorded = structs.replace(row, samples=samples)
                yield _Part(part, role, recorded.by_socket)


def _predicted(
    calibration: CalibratedRobot, parts: Sequence[_Part]
) -> list[PlacementPrediction]:
    """Return what the models of a robot predict; those trained on place instruments' frames."""
    models = {**calibration.models}
    training = [part.measured for part in parts if part.role == "train"]
    frames = {
        name: fit_frames([(model.predict(m), m) for m in training])
        for name, model in models.items()
    }
    placements: list[PlacementPrediction] = []
    for measured, role, samples in parts:
        predicted = target_predictions(models, measured, frames)
        points = ByModel(**{name: p.points for name, p in predicted.items()})
        poses = {name: p.frames or {} for name, p in predicted.items()}
        placements.append(PlacementPrediction(measured, role, points, samples, poses))
    return placements


def measurements_of(document: CalibrationDocument, robot: Robot) -> list[Measurement]:
    """Return the placements whose samples a calibration holds.

    Raises:
        MeasurementError: A placement cannot be used.
    """
    measurements: list[Measurement] = []
    for row in document.data:
        measured = measure(
            row.placement(robot.joint_names), robot, sockets=1, whole=True
        )
        shifts = np.array([sample.moved or (0.0, 0.0, 0.0) for sample in row.by_socket])
        measurements.append(
            replace(measured, moved=shifts) if np.any(shifts) else measured
        )
    return measurements


def _check(
    document: CalibrationDocument,
    placements: Sequence[PlacementPrediction],
    left_out: Sequence[PlacementPrediction],
    source: str,
) -> None:
    """See that samples, errors and summaries are of the same placements, and follow from them."""
    recorded = [(row.name, row.role) for row in document.data]
    if not recorded:
        raise misfit(source, "data", "no placement; calibrate again")
    if recorded != [(row.name, row.role) for row in document.placements]:
        raise misfit(
            source, "placements", "not the names and roles of `data`; calibrate again"
        )
    if [p.name for p in left_out] != [row.name for row in document.left_out]:
        raise misfit(source, "left_out", "not what `data` says; calibrate again")
    for role in ("train", "test"):
        is_recorded = role in dict(recorded).values()
        if is_recorded and getattr(document.summary, role) is None:
            raise misfit(
                source, f"summary.{role}", "missing, but `data` has such placements"
            )
    for i, row in enumerate(document.history):
        if row.train is None and row.test is None:
            raise misfit(source, f"history[{i}]", "neither `train` nor `test`")
    predictions = (*placements, *left_out)
    rows = (*document.placements, *document.left_out)
    for placement, errors in zip(predictions, rows, strict=True):
        for model in MODELS:
            computed = float(placement.errors(model).mean())
            stated = errors.of(model).mean_absolute_error
            if abs(computed - stated) > _AGREE:
                raise DocumentError(
                    f"{source}: {placement.name}: its samples give {1e3 * computed:.3f} mm by the "
                    f"{model} model, but `placements` says {1e3 * stated:.3f} mm; the file was "
                    "edited or damaged, so calibrate again"
                )


class JointRange(Document):
    """A joint and its limits."""

    name: str
    unit: Literal["rad", "m"]
    lower: float | None
    upper: float | None


class SocketCoverage(Document):
    """Joint positions in one socket [rad, m for prismatic joints]."""

    placement: str
    role: Role
    socket: int
    low: tuple[float, ...]
    """Smallest position of each joint."""
    high: tuple[float, ...]
    positions: tuple[tuple[float, ...], ...]
    """Of the samples, thinned out where there are many; shape (N, joints)."""


class Coverage(Document):
    """Range of each joint in each socket."""

    joints: tuple[JointRange, ...]
    sockets: tuple[SocketCoverage, ...]


def coverage(predictions: Predictions) -> Coverage:
    """Return the joint positions in each socket, thinned out where there are many."""
    joints = [
        JointRange(
            name=joint.name,
            unit="m" if joint.type == "prismatic" else "rad",
            lower=joint.lower if np.isfinite(joint.lower) else None,
            upper=joint.upper if np.isfinite(joint.upper) else None,
        )
        for joint in predictions.robot.actuated
    ]
    sockets = list[SocketCoverage]()
    for placement in predictions.placements:
        measured = placement.measured
        for k, rows in zip(measured.sockets, measured.by_socket, strict=True):
            drawn = np.round(rows[:: -(-len(rows) // DRAWN)], 4).tolist()
            covered = SocketCoverage(
                placement=placement.name,
                role=placement.role,
                socket=k,
                low=tuple(rows.min(axis=0).tolist()),
                high=tuple(rows.max(axis=0).tolist()),
                positions=tuple(map(tuple, drawn)),
            )
            sockets.append(covered)
    return Coverage(joints=tuple(joints), sockets=tuple(sockets))


def travels(covered_range: Coverage) -> dict[str, float]:
    """Return how far each joint that turns did over all that was trained on, by its name [rad].

    The least arc that holds all positions, for a joint that can go all round.
    """
    sockets = [socket for socket in covered_range.sockets if socket.role == "train"]
    turned: dict[str, float] = {}
    for i, joint in enumerate(covered_range.joints if sockets else ()):
        low, high = min(s.low[i] for s in sockets), max(s.high[i] for s in sockets)
        if (
            joint.lower is None
            or joint.upper is None
            or joint.upper - joint.lower >= ALL_ROUND
        ):
            low, high = arc((s.low[i], s.high[i]) for s in sockets)
        if joint.unit == "rad":
            turned[joint.name] = high - low
    return turned

"""What a calibration file proves: its models' predictions for every sample in it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ...recorder.dataset import Placement, Sample
from ...solver.calibrated import CalibratedRobot as Calibration
from ...solver.data.measurements import Measurement, measure
from ...solver.data.metrics import evaluate, socket_centres
from ...solver.robot.urdf import Robot
from ..documents.calibration import CalibrationDocument, calibrated_robot
from ..documents.files import DocumentError as CalibrationError

__all__ = ["MODELS", "Evidence", "Seen", "evidence_of", "measurements_of", "predict", "short_where"]

Vector = NDArray[np.float64]
MODELS = ("nominal", "calibrated")
_AGREE = 1e-6
"""Figures in the file and those that follow from its samples differ by less than this [m]."""


@dataclass(frozen=True)
class Seen:
    """One placement, as both models see it."""

    measured: Measurement
    role: str
    """``train`` or ``test``."""
    points: Mapping[str, Vector]
    """Predicted ball centres by model, socket after socket, shape (N, 3) [m]."""
    samples: tuple[Mapping[str, Any], ...]
    """The samples' rows in the file, in the order of the points."""

    @property
    def name(self) -> str:
        """The placement's name."""
        return self.measured.name

    @cached_property
    def deviations(self) -> dict[str, Vector]:
        """Each prediction less the mean of its socket, by model, shape (N, 3) [m]."""
        return {
            model: points - np.repeat(self.centres(model), self.measured.counts, axis=0)
            for model, points in self.points.items()
        }

    def errors(self, model: str) -> Vector:
        """Return the length of each deviation, shape (N,) [m]."""
        return np.linalg.norm(self.deviations[model], axis=1)

    def centres(self, model: str = "calibrated") -> Vector:
        """Return where the model puts the sockets, shape (sockets, 3) [m]."""
        return socket_centres(self.points[model], self.measured)

    @cached_property
    def position(self) -> Vector:
        """The middle of the sockets in the base frame, by the calibrated model, shape (3,) [m]."""
        return self.centres().mean(axis=0)


@dataclass(frozen=True)
class Evidence:
    """A calibration file, read and measured anew."""

    document: Mapping[str, Any]
    calibration: Calibration
    placements: tuple[Seen, ...]

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.calibration.robot

    def of_role(self, role: str) -> list[Seen]:
        """Return the placements of a role."""
        return [seen for seen in self.placements if seen.role == role]

    @property
    def judged(self) -> list[Seen]:
        """What figures rest on: the held-out placements; without any, those trained on."""
        return self.of_role("test") or self.of_role("train")


def evidence_of(document: Mapping[str, Any], source: str) -> Evidence:
    """Return the evidence in a calibration's document.

    Args:
        document: As :func:`mukca.solver.calibrated.load_document` returns it.
        source: Its file, for messages.

    Raises:
        CalibrationError: The document is damaged, or its figures do not follow from its samples.
    """
    calibration = calibrated_robot(msgspec.convert(document, CalibrationDocument), source)
    try:
        _refuse_infinite(document, source)
        measurements = measurements_of(document, calibration.robot)
        rows = zip(document["data"], measurements, strict=True)
        placements = tuple(_seen(row, measured, calibration) for row, measured in rows)
        for seen, figures in zip(placements, document["placements"], strict=True):
            _check_figures(seen, figures, source)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise CalibrationError(f"{source}: damaged calibration.json: {error!r}") from None
    return Evidence(document, calibration, placements)


def measurements_of(document: Mapping[str, Any], robot: Robot) -> list[Measurement]:
    """Return the placements whose samples a calibration's document holds."""
    return [
        measure(
            Placement(
                name=str(row["name"]),
                samples=tuple(map(_sample, row["samples"])),
                joint_names=robot.joint_names,
                distance=row["distance"],
                files=tuple(map(Path, row["files"])),
            ),
            robot,
            sockets=1,
        )
        for row in document["data"]
    ]


def _sample(row: Mapping[str, Any]) -> Sample:
    effort = row.get("effort")
    return Sample(
        position=tuple(map(float, row["position"])),
        socket=int(row["socket"]),
        effort=None if effort is None else tuple(map(float, effort)),
        where=str(row.get("where", "")),
    )


def _seen(row: Mapping[str, Any], measured: Measurement, calibration: Calibration) -> Seen:
    points = {
        "nominal": calibration.nominal_ball(measured.positions),
        "calibrated": predict(calibration, measured),
    }
    samples = sorted(row["samples"], key=lambda sample: sample["socket"])
    return Seen(measured, str(row["role"]), points, tuple(samples))


def predict(calibration: Calibration, measured: Measurement) -> Vector:
    """Return where the calibrated robot puts the ball in each sample, shape (N, 3) [m]."""
    return calibration.ball(measured.positions, measured.efforts)


def _check_figures(seen: Seen, figures: Mapping[str, Any], source: str) -> None:
    for model in MODELS:
        found = evaluate(seen.points[model], seen.measured).mean_absolute_error
        told = figures[model]["mean_absolute_error"]
        if figures["name"] != seen.name or abs(found - told) > _AGREE:
            raise CalibrationError(
                f"{source}: {seen.name}: its samples give {1e3 * found:.3f} mm by the {model} "
                f"model, its figures say {1e3 * told:.3f} mm for {figures['name']}; the file was "
                "edited or damaged, so calibrate again"
            )


def _refuse_infinite(value: Any, source: str) -> None:
    """See that every number is finite: Python's JSON reader lets NaN and Infinity through."""
    if isinstance(value, float) and not math.isfinite(value):
        raise CalibrationError(f"{source}: damaged calibration.json: it holds {value}")
    if isinstance(value, Mapping | list | tuple):
        for item in value.values() if isinstance(value, Mapping) else value:  # pyright: ignore
            _refuse_infinite(item, source)


def short_where(where: str) -> str:
    """Return a file and line with no more folders than tell placements apart."""
    return "/".join(where.split("/")[-3:])

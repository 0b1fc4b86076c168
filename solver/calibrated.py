"""A calibrated robot, and the file that keeps it: ``calibration.json``.

The file holds the nominal and the calibrated model, every sample and all figures, so that later
commands need no other file.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from .. import MukcaError
from .auto.deflection import Deflection
from .data.observations import Load
from .robot.kinematics import BallModel, gravity_torques
from .robot.parameters import Parameter, all_parameters
from .robot.urdf import Robot, parse_robot
from .robot.urdf_text import Origin, relocate_meshes, scan, set_origins

__all__ = [
    "FORMAT",
    "Calibration",
    "CalibrationError",
    "calibration_of",
    "load_calibration",
    "load_document",
]

Vector = NDArray[np.float64]
FORMAT = "mukca-calibration-1"


class CalibrationError(MukcaError):
    """A calibration file cannot be read."""


@dataclass(frozen=True)
class Calibration:
    """A robot with calibrated joint origins and, where the data support it, joint deflections.

    The ball's centre is Phi(Theta, q'), where q' are the joint positions corrected by
    :mod:`mukca.solver.auto.deflection`.
    """

    robot: Robot
    """The nominal robot."""
    parameters: tuple[Parameter, ...]
    """What was calibrated of its geometry."""
    values: Vector
    """The calibrated parameters, shape (n,) [m, rad]."""
    deflection: Deflection = field(default_factory=Deflection)
    """What corrects the joint positions before the geometry is applied."""
    load: Load = field(default_factory=Load)
    """What pulls at the joints where no effort is measured."""
    exported: Vector | None = None
    """The best parameters for those who know nothing of deflections; None where there are none."""

    @cached_property
    def model(self) -> BallModel:
        """The ball's position as a function of :attr:`parameters` and joint positions."""
        return BallModel(self.robot, [p.index for p in self.parameters])

    def ball(self, q: Vector, effort: Vector | None = None) -> Vector:
        """Return the ball's centre in the base frame [m].

        Args:
            q: Joint positions in chain order, shape (m,) or (N, m) [rad].
            effort: What the joints exert on the arm, of the same shape [N m]; None for the
                gravity torques of the model's masses.

        Returns:
            Shape (3,) or (N, 3).
        """
        positions = np.atleast_2d(np.asarray(q, dtype=float))
        if self.deflection.extensions:
            load = self.load
            torque = (
                gravity_torques(self.robot, positions, load.gravity, load.payload)
                if effort is None
                else np.atleast_2d(np.asarray(effort, dtype=float))
            )
            positions = self.deflection.true_positions(positions, torque)
        return self._points(self.values, positions, q)

    def geometric_ball(self, q: Vector) -> Vector:
        """Return the ball's centre by the exported URDF; see :meth:`ball`."""
        return self._points(self.values if self.exported is None else self.exported, q, q)

    def nominal_ball(self, q: Vector) -> Vector:
        """Return the ball's centre by the nominal model; see :meth:`ball`."""
        return self._points(self.model.nominal, q, q)

    def _points(self, parameters: Vector, positions: Vector, q: Vector) -> Vector:
        points = self.model.points(parameters, np.atleast_2d(np.asarray(positions, dtype=float)))
        return points[0] if np.ndim(q) == 1 else points

    def urdf(self, folder: Path | None = None, *, compensated: bool = False) -> bytes:
        """Return the calibrated URDF: joint origins replaced, all else as it was.

        Args:
            folder: Where it will stand; relative mesh paths are rewritten to be found from
                there. None leaves them.
            compensated: Give the geometry for joint positions that are corrected first, instead
                of the best one for those that are not.
        """
        values = self.values if compensated or self.exported is None else self.exported
        origins = self.model.origins(values)
        changed = {joint.name: _origin(origins[i]) for i, joint in enumerate(self.robot.joints)}
        text = set_origins(self.robot.text, changed)
        source = Path(self.robot.source)
        if folder is None or not source.is_file():
            return text
        return relocate_meshes(scan(text, self.robot.source), source.parent, folder)

    def table(self) -> list[dict[str, Any]]:
        """Return the parameters: joint, component, unit, nominal, calibrated, change."""
        return [
            {
                "name": p.name,
                "joint": p.joint,
                "component": p.component,
                "unit": p.unit,
                "nominal": float(nominal),
                "calibrated": float(value),
                "change": float(value - nominal),
                "exported": float(exported),
            }
            for p, nominal, value, exported in zip(
                self.parameters,
                self.model.nominal,
                self.values,
                self.values if self.exported is None else self.exported,
                strict=True,
            )
        ]

    def as_dict(self) -> dict[str, Any]:
        """Return what :func:`load_calibration` reads back."""
        robot = self.robot
        return {
            "model": {
                "name": robot.name,
                "source": robot.source,
                "sha256": robot.sha256,
                "base": robot.base,
                "tip": robot.tip,
                "joint_names": list(robot.joint_names),
                "nominal_urdf": robot.text.data.decode(),
                "calibrated_urdf": self.urdf().decode(),
            },
            "parameters": self.table(),
            "deflection": {
                extension: values.tolist()
                for extension, values in zip(
                    self.deflection.extensions, self.deflection.coefficients, strict=True
                )
            },
            "load": {"gravity": list(self.load.gravity), "payload": self.load.payload},
        }


def _origin(numbers: Vector) -> Origin:
    x, y, z, roll, pitch, yaw = numbers.tolist()
    return Origin((x, y, z), (roll, pitch, yaw))


def load_document(file: Path) -> dict[str, Any]:
    """Return all that a calibration file holds.

    Raises:
        CalibrationError: Missing, not JSON, or not a calibration of this format.
    """
    try:
        document: Any = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise CalibrationError(f"{file}: {error.strerror}; expected a calibration.json") from None
    except ValueError as error:
        raise CalibrationError(f"{file}: not a calibration.json: {error}") from None
    if not isinstance(document, dict) or cast("Any", document).get("format") != FORMAT:
        raise CalibrationError(f"{file}: not a calibration.json of this version ({FORMAT})")
    return cast("dict[str, Any]", document)


def load_calibration(file: Path) -> Calibration:
    """Read a calibration file.

    Raises:
        CalibrationError: Not such a file, or one whose parts do not fit each other.
    """
    return calibration_of(load_document(file), str(file))


def calibration_of(document: Mapping[str, Any], source: str) -> Calibration:
    """Return the calibrated robot of a document; see :func:`load_document`.

    Raises:
        CalibrationError: The document's parts do not fit each other.
    """
    try:
        model = document["model"]
        robot = parse_robot(
            scan(model["nominal_urdf"].encode(), source),
            source=model["source"],
            base=model["base"],
            tip=model["tip"],
        )
        rows = {row["name"]: row for row in document["parameters"]}
        parameters = tuple(p for p in all_parameters(robot) if p.name in rows)
        if len(parameters) != len(rows):
            raise ValueError("parameters of other joints than the model's")
        values, exported = (
            np.array([float(rows[p.name][key]) for p in parameters])
            for key in ("calibrated", "exported")
        )
        deflection = document["deflection"]
        x, y, z = map(float, document["load"]["gravity"])
        return Calibration(
            robot,
            parameters,
            values,
            Deflection(
                tuple(deflection), tuple(np.array(v, dtype=float) for v in deflection.values())
            ),
            Load((x, y, z), float(document["load"]["payload"])),
            exported if deflection else None,
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CalibrationError(f"{source}: damaged calibration.json: {error!r}") from None

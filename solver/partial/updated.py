"""Calibrations updated by a partial fit: joint zeros, a tool's frame, the posterior of the arm."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec import structs

from ...errors import fixed
from ..calibration import Calibration, UsageError
from ..identification.data import Pose
from ..identification.effects import JOINT_OFFSET
from ..identification.inference import offsets_in_origins
from ..identification.robot import BallModel, Robot, add_link, all_parameters, scan
from ..results import (
    CalibratedRobot,
    CalibrationDocument,
    Coefficient,
    FoldModel,
    LaterZero,
    ToolFrame,
)
from .doubts import ChangedZeros
from .system import System
from .zeros import JointZero

LIMIT = 2e-3
"""Standard deviation along any direction, above which a place is not enough to use [m]."""


@dataclass(frozen=True, repr=False)
class Found:
    """A frame on the arm or beside it, estimated with the calibrated chain held."""

    frame: ToolFrame
    """Its pose, and the covariance of its place for the arm of :attr:`calibration`."""
    calibration: Calibration
    """The calibration with the frame as a link."""
    notes: tuple[str, ...]
    """Remarks on the samples."""
    untold: tuple[str, ...]
    """Directions that are not identifiable, or reasons not to rely on it, in words."""

    @property
    def brief(self) -> tuple[str, ...]:
        """The answer in words, line by line; reasons not to rely on it come first."""
        return (*self.untold, *self.notes)

    @property
    def scatter(self) -> str:
        """Scatter of the samples, in words."""
        return ""

    @property
    def text(self) -> tuple[str, ...]:
        """The result in words, line by line, the answer first."""
        return (*self.brief, self.scatter)

    @property
    def place(self) -> str:
        """Its place with standard deviations, in words."""
        sigma = np.sqrt(np.diag(self.frame.covariance))
        numbers = [
            f"{fixed(1e3 * v, 2, '+')} +- {1e3 * s:.2f}"
            for v, s in zip(self.frame.xyz, sigma, strict=True)
        ]
        return f"x y z {' '.join(numbers)} mm"

    def __repr__(self) -> str:
        return "\n".join(self.text)

    def as_dict(self) -> dict[str, Any]:
        """Return it by name."""
        values = {**vars(self)}
        del values["frame"], values["calibration"]
        figures = msgspec.to_builtins(
            values, enc_hook=lambda value: np.asarray(value).tolist()
        )
        return {**self.frame.as_dict(), **figures}

    def save(
        self,
        folder: str | Path,
        *,
        force: bool = False,
        pages: Mapping[str, bytes] | None = None,
    ) -> dict[str, str]:
        """Write ``calibrated.urdf`` and ``calibration.json`` with the link.

        With them come ``pages``, by name. The other arguments, result and errors are those of
        :meth:`.Calibration.save`.
        """
        return self.calibration.save(
            folder, force=force, accept_distorted=True, pages=lambda _: pages or {}
        )


def found(
    calibration: Calibration,
    system: System,
    link: tuple[str, str],
    pose: Pose,
    zeros: ChangedZeros,
    untold: tuple[str, ...],
) -> Found:
    """Return a link (name, parent) by a fit, with the chance that a zero changed."""
    origin = pose.origin
    frame = ToolFrame(
        name=link[0],
        parent=link[1],
        xyz=origin.xyz,
        rpy=origin.rpy,
        covariance=zeros.covariance.tolist(),
    )
    doubts = () if zeros.told or zeros.alike else zeros.text
    notes = (*system.task.rows.warnings, *doubts)
    return Found(frame, updated(calibration, system, tool=frame), notes, untold)


def signed(values: Iterable[float], digits: int) -> str:
    """Return numbers with their signs and so many decimals, blanks between."""
    return " ".join(fixed(value, digits, "+") for value in values)


def not_enough(
    covariance: np.ndarray, limit: float, subject: str, remedy: str
) -> tuple[str, ...]:
    """Return a sentence where a place is less sure than a limit [m], and what would tell it."""
    variances, directions = np.linalg.eigh(covariance)
    if variances[-1] <= limit**2:
        return ()
    along = signed(directions[:, -1], 2)
    deviation = float(variances[-1]) ** 0.5
    return (
        f"NOT ENOUGH DATA: these {subject} along ({along}), +- {1e3 * deviation:.1f} mm "
        f"(limit {1e3 * limit:g} mm): {remedy}.",
    )


def updated(
    calibration: Calibration,
    system: System,
    zeros: Sequence[JointZero] = (),
    tool: ToolFrame | None = None,
) -> Calibration:
    """Return a calibration with the estimates of a fit: the arm's parameters, zeros, a tool."""
    offsets = np.array([zero.offset for zero in zeros])
    calibrated = _updated_arm(calibration.calibrated, system, offsets, tool)
    document = _updated_document(calibration.document, calibrated, zeros, tool)
    if zeros:  # to which the samples of folds are converted, too
        old = calibration.calibrated
        folds = [(_with_zeros(f.robot(old), offsets), f.ball) for f in document.folds]
        models = tuple(FoldModel.of(*fold) for fold in folds)
        document = structs.replace(document, folds=models)
    return Calibration(document, calibrated, calibration.source)


def _updated_arm(
    old: CalibratedRobot,
    system: System,
    offsets: np.ndarray,
    tool: ToolFrame | None,
) -> CalibratedRobot:
    """Return an arm with the estimates of a fit; the offsets of zeros are empty where none is."""
    model, x = system.task.prior.model, system.state.x
    changes = dict(zip(model.names, system.shift, strict=False))
    change = np.array(
        [0.0 if tool and p.of_ball else changes[p.name] for p in old.parameters]
    )
    robot = old.robot
    if tool:
        text = add_link(robot.text, tool.parent, tool.origin, tool.name)
        robot = replace(robot, text=scan(text, robot.text.source))
    deflection = model.deflection(x[: model.size]).without(JOINT_OFFSET.name)
    arm = replace(
        old,
        robot=robot,
        values=old.values + change,
        deflection=deflection,
        exported=old.geometry + change if deflection.extensions else None,
    )
    return _with_zeros(arm, offsets) if offsets.size else arm


def _updated_document(
    document: CalibrationDocument,
    calibrated: CalibratedRobot,
    zeros: Sequence[JointZero],
    tool: ToolFrame | None,
) -> CalibrationDocument:
    """Return the document of a calibration whose arm was updated."""
    urdfs = structs.replace(
        document.model,
        nominal_urdf=calibrated.robot.text.data.decode(),
        calibrated_urdf=calibrated.urdf().decode(),
    )
    coefficients = calibrated.deflection.by_name
    values, exported = calibrated.values.tolist(), calibrated.geometry.tolist()
    numbers = zip(document.parameters, values, exported, strict=True)
    document = structs.replace(
        document,
        parameters=tuple(
            structs.replace(
                row, calibrated=value, change=value - row.nominal, exported=number
            )
            for row, value, number in numbers
        ),
        deflection={
            name: tuple(array.tolist()) for name, array in coefficients.items()
        },
        model=urdfs,
        tools=(*document.tools, *([tool] if tool else [])),
    )
    if zeros:
        offsets = [-zero.offset for zero in zeros]
        later = zip(zeros, document.later_offsets, strict=True)
        document = structs.replace(
            document,
            later_zeros=tuple(
                LaterZero.filled(zero, offset=before + zero.offset)
                for zero, before in later
            ),
            coefficients=_coefficients(document.coefficients or (), zeros),
            data=tuple(data.shifted(offsets) for data in document.data),
        )
    return document


def urdf_with_zeros(robot: Robot, offsets: Sequence[float]) -> bytes:
    """Return the URDF of a nominal robot with zeros of its joints [rad] put into its origins."""
    parameters = tuple(all_parameters(robot))
    nominal = BallModel(robot, [p.index for p in parameters]).nominal
    arm = CalibratedRobot(robot, parameters, nominal)
    return _with_zeros(arm, np.array(offsets)).urdf()


def _with_zeros(arm: CalibratedRobot, offsets: np.ndarray) -> CalibratedRobot:
    """Return an arm whose joints are read from new zeros [rad], which go into its geometry."""
    put = partial(offsets_in_origins, arm.model, arm.parameters, offsets=offsets)
    try:
        exported = None if arm.exported is None else put(arm.exported)
        return replace(arm, values=put(arm.values), exported=exported)
    except KeyError:
        raise UsageError(
            "a joint's new zero goes into the angles of its origin, which this calibration held "
            "fixed (--free, --fix); calibrate with all of them free"
        ) from None


def _coefficients(
    old: Sequence[Coefficient], zeros: Sequence[JointZero]
) -> tuple[Coefficient, ...]:
    """Return the coefficients with the zeros of all joints, as exports to servos read them."""
    by_name = {row.name: row for row in old}
    for zero in zeros:
        (name,) = JOINT_OFFSET.coefficient_names([zero.joint])
        before = by_name[name].value if name in by_name else 0.0
        by_name[name] = Coefficient.filled(
            zero, name=name, unit="rad", value=before + zero.offset
        )
    return tuple(by_name.values())

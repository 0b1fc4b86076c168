"""What every format is given, what it returns, and what it leaves out."""

import hashlib
import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from ..._version import __version__
from ...errors import MukcaError
from ...solver.calibration import Calibration
from ...solver.data import kabsch


class ExportError(MukcaError):
    """A calibration cannot be written in a format; the line says why, and what would work."""


@dataclass(frozen=True)
class Identity:
    """By what, from what, and for which arm a file was made."""

    made_by: str
    calibration: str
    """The file that was exported."""
    sha256: str
    """Of that file."""
    robot: str
    created: str
    """When the calibration was made, UTC."""
    serial_number: str

    def lines(self) -> list[str]:
        """Return it as lines of a comment."""
        return [
            f"Calibrated kinematics of {self.robot}, serial number {self.serial_number}.",
            f"Made by {self.made_by} from {self.calibration}, calibrated {self.created}.",
            f"sha256 of that file: {self.sha256}",
        ]


@dataclass(frozen=True)
class Request:
    """One export: the calibration, and what the user asked for."""

    format: str
    calibration: Calibration
    identity: Identity
    file: Path
    """Where the result goes."""
    like: Path | None = None
    """A file of the user's of the same format, from which the rest is taken."""
    joints: str | None = None
    """How the user's file calls the arm's joints; see
    :func:`mukca.solver.calibration.usage.joints_named`."""
    servos: str | None = None
    """The make of the arm's servos."""
    flange: str | None = None
    """The link that carries a tool; None for the one that carries the ball."""
    tools: Mapping[str, tuple[float, ...]] = field(default_factory=dict[str, tuple[float, ...]])
    """Links to add: x y z [m], roll pitch yaw [rad] in the flange's frame, by name."""

    @cached_property
    def origins(self) -> np.ndarray:
        """Origins of the chain's joints as ``calibrated.urdf`` has them, shape (joints, 6).

        This is the best geometry for programs that do not correct joint positions.
        """
        calibrated = self.calibration.calibrated
        exported = calibrated.exported
        return calibrated.model.origins(calibrated.values if exported is None else exported)


@dataclass(frozen=True)
class Loss:
    """Something that a format cannot say, and what that costs at the ball."""

    what: str
    mean: float
    """Mean over the recorded poses [m]."""
    largest: float
    """[m]."""

    def __str__(self) -> str:
        return (
            f"Not in this format: {self.what}. Cost at the ball, over the recorded poses: "
            f"{1e3 * self.mean:.3f} mm on average, {1e3 * self.largest:.3f} mm at most"
        )


@dataclass(frozen=True)
class Exported:
    """The files of an export, and what to tell the user."""

    files: dict[str, bytes]
    """By name; they go into one folder."""
    losses: tuple[Loss, ...] = ()
    lines: tuple[str, ...] = ()
    """What to do with the files, and what to know about them."""


def identify(calibration: Calibration, file: Path, serial_number: str | None) -> Identity:
    """Return whose calibration a file holds.

    The serial number is the one given, or what was noted while recording.
    """
    document = calibration.document
    numbers = {number for data in document.data for number in _noted(data.files)}
    known = numbers.pop() if len(numbers) == 1 else "not known"
    return Identity(
        made_by=f"mukca {__version__}",
        calibration=file.name,
        sha256=hashlib.sha256(file.read_bytes()).hexdigest(),
        robot=_plain(document.model.name),
        created=_plain(document.provenance.created),
        serial_number=_plain(serial_number or known),
    )


def _noted(files: Collection[str]) -> list[str]:
    """Return the serial numbers noted beside a recording, if it still lies where it was."""
    try:
        sessions = json.loads((Path(next(iter(files))).parent / "placement.json").read_text())
        return [str(s["serial_number"]) for s in sessions["sessions"] if "serial_number" in s]
    except (OSError, ValueError, LookupError, TypeError, StopIteration):
        return []


def _plain(text: str) -> str:
    """Return text that stays on one line in any comment."""
    return "".join(c if c.isprintable() else " " for c in text).replace("--", "-").replace("*/", "")


def losses_without(request: Request, uncarried: Collection[str]) -> tuple[Loss, ...]:
    """Return what a format leaves out, each with its cost.

    Args:
        request: The export.
        uncarried: Joints whose origins the format cannot change.
    """
    calibrated = request.calibration.calibrated
    q = np.concatenate([[s.position for s in d.samples] for d in request.calibration.document.data])
    geometric = calibrated.geometric_ball(q)
    losses: list[Loss] = []
    if calibrated.deflection.extensions:
        words = "corrections of the joints (" + ", ".join(calibrated.deflection.extensions) + ")"
        # Where an arm's base frame stands is not measured: a shift or turn of all is no loss.
        ball = calibrated.ball(q)
        losses.append(_loss(words, kabsch(geometric, ball).apply(geometric) - ball))
    exported = calibrated.values if calibrated.exported is None else calibrated.exported
    nominal = calibrated.model.nominal
    for name in dict.fromkeys(p.joint for p in calibrated.parameters if p.joint in uncarried):
        without = np.where([p.joint == name for p in calibrated.parameters], nominal, exported)
        loss = _loss(_named(request, name), calibrated.model.points(without, q) - geometric)
        losses += [loss] if loss.largest > 0 else []
    return tuple(losses)


def _named(request: Request, joint: str) -> str:
    ball = request.calibration.robot.ball_joint
    return f"the ball's place on {ball.parent}" if joint == ball.name else f"the origin of {joint}"


def _loss(what: str, differences: np.ndarray) -> Loss:
    distances = np.linalg.norm(differences, axis=1)
    return Loss(what, float(distances.mean()), float(distances.max()))

"""An export: the request and the origins that every format is given, its files, and its losses."""

import csv
import hashlib
import io
import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from ..._version import __version__
from ...errors import LARGEST_DOCUMENT, MukcaError, read_bytes
from ...recorder import METADATA, read_sessions
from ...solver.calibration import pose_of_numbers
from ...solver.identification.data import kabsch
from ...solver.identification.robot import angles_near, workspace
from ...solver.results import encode

if TYPE_CHECKING:
    from ...solver.calibration import Calibration, FullModel
    from ...solver.identification.robot import Robot


class ExportError(MukcaError):
    """A calibration cannot be written in a format; the line says why, and what would work."""


class ExportOptions(TypedDict, total=False):
    """Options that only some formats have; :data:`.formats.FORMATS` says which."""

    like: str | Path | None
    """A file of the user's of the same format, from which the rest is taken."""
    joints: str | None
    """Names of the arm's joints in that file, between commas; or one word with ``*`` for each."""
    servos: str | None
    """The make of the arm's servos, ``feetech`` or ``dynamixel``."""
    flange: str | None
    """The link that carries a tool; None for the one that carries the ball."""
    payload: tuple[float, Sequence[float]] | None
    """Mass on the flange [kg] and its centre there [m], in place of that of the recordings."""
    rows: int | None
    """Number of offsets of each joint."""
    tools: Mapping[str, Sequence[float]]
    """Links to add: x y z [m], roll pitch yaw [rad] in the flange's frame, by name."""


@dataclass(frozen=True)
class Identity:
    """Provenance of an exported file: the program, the calibration, and the arm."""

    made_by: str
    calibration: str
    sha256: str
    """The file that was exported, and its digest."""
    robot: str
    created: str
    serial_number: str

    def lines(self) -> list[str]:
        """Return it as lines of a comment."""
        lines = [
            f"Calibrated kinematics of {self.robot}, serial number {self.serial_number}.",
            f"Made by {self.made_by} from {self.calibration}, calibrated {self.created}.",
            f"sha256 of that file: {self.sha256}",
        ]
        return list(map(plain, lines))

    @property
    def in_yaml(self) -> dict[str, str]:
        """Its fields as strings of YAML."""
        return {key: json.dumps(value) for key, value in vars(self).items()}


@dataclass(frozen=True)
class Request:
    """One export: a calibration, the format, and the user's options."""

    format: str
    calibration: "Calibration"
    identity: Identity
    file: Path
    """The file to write."""
    options: ExportOptions

    @property
    def like(self) -> Path | None:
        """The user's own file of the same format."""
        like = self.options.get("like")
        return None if like is None else Path(like)

    def like_text(self) -> str:
        """Return the text of that file; an ExportError where it cannot be read."""
        try:
            return read_bytes(self.like or "", LARGEST_DOCUMENT).decode()
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "not a text file"
            raise ExportError(f"--like {self.like}: {reason}") from None

    @property
    def robot(self) -> "Robot":
        """The nominal robot."""
        return self.calibration.robot

    @property
    def kinematics(self) -> "FullModel":
        """The calibrated arm with the mass that is asked for."""
        return self.calibration.kinematics(payload=self.options.get("payload"))

    @property
    def flange(self) -> str:
        """The link that carries a tool."""
        return self.options.get("flange") or self.robot.ball_joint.parent

    def require_ending(self, *endings: str) -> None:
        """Refuse a file of another ending."""
        if self.file.suffix not in endings:
            listing = " or ".join(endings)
            raise ExportError(f"--out {self.file}: name a file that ends in {listing}")

    @property
    def origins(self) -> np.ndarray:
        """Origins of the chain's joints as ``calibrated.urdf`` has them, shape (joints, 6)."""
        return self.calibration.calibrated.origins


ANYWHERE = 400
"""Random poses over which a loss in the workspace is averaged."""


@dataclass(frozen=True)
class Loss:
    """Something that a format cannot say, and its cost at the ball."""

    what: str
    mean: float
    """Mean over the recorded poses [m]."""
    largest: float
    """[m]."""
    anywhere: float
    """Mean over random poses of the whole workspace [m]."""
    of_ball: bool = False
    """True where it is the ball's own place, which another tool does not need."""

    def __str__(self) -> str:
        lost = f"Not in this format: {self.what}"
        if self.of_ball:
            return lost
        return (
            f"{lost}. Without that, the ball is elsewhere by {1e3 * self.mean:.3f} mm on average "
            f"at the recorded poses, and by {1e3 * self.anywhere:.3f} mm in the workspace"
        )


@dataclass(frozen=True)
class Exported:
    """The files of an export, and what to tell the user."""

    files: dict[str, bytes]
    """By name; they go into one folder."""
    losses: tuple[Loss, ...] = ()
    lines: tuple[str, ...] = ()
    """Loading the files, and what to know about them."""
    outputs: Mapping[str, str] = field(default_factory=dict[str, str])
    """Paths of the files written, by name."""


def identify(calibration: "Calibration", serial_number: str | None) -> Identity:
    """Return the provenance of exports, with the serial number given, or noted."""
    document = calibration.document
    file = Path(calibration.source)
    saved = file.is_file()
    numbers = set(chain.from_iterable(_noted(data.files) for data in document.data))
    known = numbers.pop() if len(numbers) == 1 else "not known"
    return Identity(
        made_by=f"mukca {__version__}",
        calibration=file.name if saved else "an unsaved calibration",
        sha256=hashlib.sha256(
            read_bytes(file) if saved else encode(document)
        ).hexdigest(),
        robot=plain(document.model.name),
        created=plain(document.provenance.created),
        serial_number=plain(serial_number or known),
    )


def _noted(files: Collection[str]) -> list[str]:
    """Return the serial numbers noted beside a recording, if it still lies where it was."""
    folders = dict.fromkeys(Path(file).parent for file in files)
    sessions = chain.from_iterable(read_sessions(f / METADATA) for f in folders)
    return [str(s["serial_number"]) for s in sessions if "serial_number" in s]


def filled(template: str, **words: object) -> bytes:
    """Return a template's text; nothing in it is escaped."""
    from jinja2 import Environment, FileSystemLoader

    folder = FileSystemLoader(Path(__file__).parent / "templates")
    environment = Environment(  # noqa: S701 (no HTML)
        loader=folder, keep_trailing_newline=True, trim_blocks=True
    )
    return environment.get_template(template).render(**words).encode()


def commented_table(
    about: Iterable[str],
    rows: Iterable[Iterable[object]],
) -> bytes:
    """Return rows as CSV, below lines of comments."""
    text = io.StringIO()
    text.writelines(f"# {plain(line)}\n" for line in about)
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def plain(text: str) -> str:
    """Return text that stays on one line in any comment."""
    line = "".join(c if c.isprintable() else " " for c in text)
    return re.sub("--+", "-", re.sub(r"[*/]*(\*/|/\*)[*/]*", "", line))


def redistributed_origins(
    request: Request, carried: Collection[str]
) -> dict[str, np.ndarray]:
    """Return origins, shape (6,), of some joints, which take the changes of those before them."""
    origins: dict[str, np.ndarray] = {}
    change = np.eye(4)
    changed = False
    joints = request.robot.joints
    for joint, origin in zip(joints, request.origins, strict=True):
        nominal = np.array(joint.origin.numbers)
        if joint.name in carried:
            origins[joint.name] = origin
            if changed:
                T = change @ pose_of_numbers(origin)
                angles = angles_near(T[:3, :3], nominal[3:])
                origins[joint.name] = np.concatenate([T[:3, 3], angles])
            change = np.eye(4)
            changed = False
        elif changed or np.any(origin != nominal):
            before = np.linalg.inv(pose_of_numbers(nominal))
            change = before @ change @ pose_of_numbers(origin)
            changed = True
    return origins


def after_last_exported(request: Request, carried: Collection[str]) -> list[str]:
    """Return the joints after the last carried one, whose changes no origin can take."""
    names = [joint.name for joint in request.robot.joints]
    return names[1 + max(i for i, name in enumerate(names) if name in carried) :]


def losses_without(
    request: Request, uncarried: Collection[str] = ()
) -> tuple[Loss, ...]:
    """Return what a format leaves out, which cannot change the origins of some joints."""
    calibrated = request.calibration.calibrated
    losses: list[Loss] = []
    corrections = ", ".join(calibrated.deflection.extensions)
    if corrections:
        words = f"corrections of the joints ({corrections})"
        balls = calibrated.geometric_ball
        losses.append(cost_at_poses(request, words, balls, calibrated.ball))
    robot = request.robot
    poses = recorded(request), workspace(robot, ANYWHERE)
    geometric = [calibrated.geometric_ball(q) for q in poses]
    exported = calibrated.geometry
    nominal = calibrated.model.nominal
    joints = [parameter.joint for parameter in calibrated.parameters]
    for name in dict.fromkeys(joint for joint in joints if joint in uncarried):
        words = f"the origin of {name}"
        if of_ball := name == robot.ball_joint.name:
            words = f"the ball's place on {robot.ball_joint.parent}; it matters to the ball alone"
        values = np.where([joint == name for joint in joints], nominal, exported)
        balls = [calibrated.model.points(values, q) for q in poses]
        loss = replace(_loss(words, balls, geometric), of_ball=of_ball)
        if loss.largest > 0:
            losses.append(loss)
    return tuple(losses)


def exported(
    request: Request,
    content: bytes,
    lines: Iterable[str] = (),
    uncarried: Collection[str] = (),
) -> Exported:
    """Return the one file of an export, and what :func:`losses_without` says of it."""
    losses = losses_without(request, uncarried)
    return Exported({request.file.name: content}, losses, tuple(lines))


def recorded(request: Request) -> np.ndarray:
    """Return the joint positions that were recorded, shape (N, m) [rad]."""
    rows = [row.samples for row in request.calibration.document.data]
    return np.array([sample.position for sample in chain(*rows)])


Balls = Callable[[np.ndarray], np.ndarray]
"""The ball's centres at joint positions, shapes (N, 3) [m] and (N, m) [rad]."""


def cost_at_poses(request: Request, what: str, balls: Balls, truths: Balls) -> Loss:
    """Return what balls cost that are not where they truly are.

    Where an arm's base frame stands is not measured: a shift or turn of all is no loss.
    """
    poses = recorded(request), workspace(request.robot, ANYWHERE)
    targets = [truths(q) for q in poses]
    pairs = zip(map(balls, poses), targets, strict=True)
    aligned = [kabsch(places, goals).apply(places) for places, goals in pairs]
    return _loss(what, aligned, targets)


def _loss(
    what: str, balls: Sequence[np.ndarray], targets: Sequence[np.ndarray]
) -> Loss:
    """Return the loss by balls at recorded poses and anywhere, and where they should be [m]."""
    gaps = map(np.subtract, balls, targets)
    lengths, anywhere = [np.linalg.norm(gap, axis=1) for gap in gaps]
    mean = float(lengths.mean())
    return Loss(what, mean, float(lengths.max()), float(anywhere.mean()))

"""Joint states out of a log, and the model's joints among its columns."""

import importlib
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import MukcaError
from ...solver.calibration import joints_named

FULL_TURN = 2 * np.pi + 0.1
"""No joint's angle in radians is larger."""
STATES = 10
"""A window holds as many states at least."""


class ExtractError(MukcaError):
    """A log cannot be read, or does not hold what is looked for; the line says what would work."""


@dataclass(frozen=True)
class Question:
    """A log to read, and the joints to look for in it."""

    path: Path
    joints: tuple[str, ...]
    """The model's joints that move, in chain order."""
    prismatic: tuple[bool, ...]
    """True for those that slide."""
    named: str | None = None
    """Their names in the log, between commas, or one word in which ``*`` stands for each of the
    model's names; None to look for the model's names."""
    topic: str | None = None
    """(bags) The topic; None for the one with most states."""
    units: str | None = None
    """``radians``, ``degrees``, or the path of a lerobot calibration file."""
    efforts: bool = False
    """Read efforts, too, which many logs have in units of their own."""


@dataclass(frozen=True)
class Log:
    """The states of the model's joints, oldest first within each part."""

    stamps: np.ndarray
    """Shape (N,) [s]."""
    positions: np.ndarray
    """In chain order, shape (N, m) [rad], [m] for a prismatic joint."""
    efforts: np.ndarray | None
    """Shape (N, m) [N m]."""
    parts: np.ndarray
    """Number of the connection, or episode, that each state belongs to, shape (N,); between two
    parts anything may have happened."""
    notes: tuple[str, ...] = ()
    """Remarks for people, a line each."""
    resolution: float = 0.0
    """The step of the joints' encoders, where they are coarse [rad]."""

    @property
    def least_window(self) -> float:
        """A window must be as long as this to hold enough states [s]."""
        steps = np.diff(self.stamps)[np.diff(self.parts) == 0]
        return (STATES + 0.5) * float(np.median(steps)) if len(steps) else 0.0


_CLEAN = re.compile(r"\s*[\[(].*?[\])]\s*$|\.pos$|_(deg|rad|degrees|radians)$")


def columns_of(names: Sequence[str], question: Question) -> list[int] | None:
    """Return where a log has the model's joints; None where it lacks one."""
    # A log's name fits if it is the model's, or ends or begins it with a mark between, as
    # left/joint1 and panda_joint1 fit joint1; a unit behind it does not count.
    wanted = question.joints
    if question.named is not None:
        wanted = joints_named(question.named, wanted)
        return [names.index(word) for word in wanted] if set(wanted) <= set(names) else None
    if set(wanted) <= set(names):
        return [names.index(joint) for joint in wanted]
    columns: list[int] = []
    for joint in wanted:
        fitting = [i for i, name in enumerate(names) if _fits(name, joint)]
        if len(fitting) > 1:
            some = ", ".join(names[i] for i in fitting)
            raise ExtractError(
                f"{question.path}: {joint!r} may be any of {some}; say which arm, as in "
                f"--joints '{names[fitting[0]].replace(joint, '*')}'"
            )
        columns += fitting
    return columns if len(set(columns)) == len(wanted) else None


def _fits(name: str, joint: str) -> bool:
    name = _CLEAN.sub("", _CLEAN.sub("", name))
    long, short = (name, joint) if len(name) >= len(joint) else (joint, name)
    return long == short or (long.endswith(short) and long[-len(short) - 1] in "_/.-:")


def check_angles(angles: np.ndarray, degrees: bool, question: Question) -> None:
    """Refuse angles of turning joints [rad] that were likely of another unit."""
    largest = float(np.abs(angles).max(initial=0.0))
    if largest > FULL_TURN:
        raise ExtractError(
            f"{question.path}: an angle of {largest:.4g} rad; if these are degrees, say "
            "--units degrees"
        )
    if degrees and 0 < np.degrees(largest) < FULL_TURN:
        raise ExtractError(
            f"{question.path}: no joint goes beyond {np.degrees(largest):.2g} degrees; if these "
            "are radians, say --units radians"
        )


def needed_columns(names: Sequence[str], question: Question) -> list[int]:
    """Return where a log has the model's joints; an ExtractError where it lacks one."""
    columns = columns_of(names, question)
    if columns is None:
        raise unknown_joints(names, question)
    return columns


def unknown_joints(names: Sequence[str], question: Question) -> ExtractError:
    """Return the error for a log whose joints are not the model's."""
    wanted = question.named or ", ".join(question.joints)
    return ExtractError(
        f"{question.path}: no state has all of {wanted}; it has "
        f"{', '.join(names) or 'no joints'}; name them in chain order by --joints A,B,..."
    )


def read_log(question: Question) -> Log:
    """Return the joint states of a log of any kind.

    Raises:
        ExtractError: There is nothing there, or nothing that can be read; see also the modules.
        RecordingError: A file is damaged.
    """
    name = _kind(question)
    read: Callable[[Question], Log] = importlib.import_module(f".{name}", __package__).read
    if question.topic is not None and name != "bags":
        raise ExtractError("--topic is for bags")
    if question.units is not None and name not in ("lerobot", "csv_log"):
        raise ExtractError("--units is for lerobot data sets and CSV logs")
    log = read(question)
    if not len(log.stamps):
        raise ExtractError(f"{question.path}: no state in it can be used")
    return log


def _kind(question: Question) -> str:
    """Return the module that reads a path."""
    path = question.path
    if not path.exists():
        raise ExtractError(f"{path}: no such file or folder")
    if path.is_dir() and (path / "meta" / "info.json").exists():
        return "lerobot"
    if path.suffix in (".csv", ".tsv", ".txt"):
        return "csv_log"
    if path.suffix == ".stream" or (path.is_dir() and any(path.glob("*.stream"))):
        return "kept_stream"
    if path.suffix in (".bag", ".db3", ".mcap") or (path / "metadata.yaml").exists():
        return "bags"
    raise ExtractError(
        f"{path}: nothing that can be read: give a ROS bag (.bag, .db3, .mcap, or a folder with "
        "metadata.yaml), a lerobot data set, a CSV log, or a recording with a kept stream"
    )

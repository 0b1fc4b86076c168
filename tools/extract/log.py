"""Joint states out of a log, a CSV file or a kept stream, and the model's joints in its columns."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from ...errors import MukcaError
from ...recorder import ColumnError, match_joints, read_stream_log
from ...solver.calibration import joints_named

FULL_TURN = 2 * np.pi + 0.1
"""No joint's angle in radians is larger."""
STATES = 10
"""A window holds as many states at least."""


class ExtractError(MukcaError):
    """A log cannot be read, or lacks the joints; the message says what would work."""


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


def in_order(
    stamps: Sequence[float] | np.ndarray,
    positions: Sequence[np.ndarray] | np.ndarray,
    efforts: Sequence[np.ndarray] | None = None,
    notes: Sequence[str] = (),
) -> Log:
    """Return a log of one part, its states in order of time, each moment once."""
    moments, first = np.unique(stamps, return_index=True)
    known = None if efforts is None else np.array(efforts, dtype=float)[first]
    parts = np.zeros(len(moments), dtype=int)
    return Log(moments, np.array(positions)[first], known, parts, tuple(notes))


SET_BACK = 0.5
"""A stamp that is so much earlier than the latest before it is of a clock that was set back [s]."""


def in_parts(
    stamps: Sequence[float] | np.ndarray,
    positions: Sequence[np.ndarray] | np.ndarray,
    efforts: Sequence[np.ndarray] | None,
    notes: Sequence[str],
) -> Log:
    """Return a log of states as they came; where the clock was set back, another part begins."""
    times = np.asarray(stamps, dtype=float)
    back = times < np.maximum.accumulate(np.append(-np.inf, times[:-1])) - SET_BACK
    begins = [i for i in np.flatnonzero(back).tolist() if times[i] < times[i - 1] - SET_BACK]
    logs: list[Log] = []
    told = list(notes)
    for start, end in pairwise([0, *begins, len(times)]):
        some = None if efforts is None else efforts[start:end]
        logs.append(in_order(times[start:end], positions[start:end], some))
        if start:
            told.append(
                f"{times[start - 1] - times[0]:.1f} s after the first state the stamps went back "
                f"by {times[start - 1] - times[start]:.1f} s; what follows is a part of its own"
            )
    known = [log.efforts for log in logs if log.efforts is not None]
    return Log(
        np.concatenate([log.stamps for log in logs]),
        np.concatenate([log.positions for log in logs]),
        np.concatenate(known) if known else None,
        np.repeat(np.arange(len(logs)), [len(log.stamps) for log in logs]),
        tuple(told),
    )


def columns_of(names: Sequence[str], question: Question) -> list[int] | None:
    """Return where a log has the model's joints; None where it lacks one."""
    wanted = question.joints
    if question.named is not None:
        wanted = joints_named(question.named, wanted)
        return [names.index(word) for word in wanted] if set(wanted) <= set(names) else None
    try:
        match = match_joints(names, wanted, in_order=False)
    except ColumnError as error:
        raise ExtractError(which_arm(error, question)) from None
    return None if match is None else list(match.order)


def which_arm(error: ColumnError, question: Question) -> str:
    """Return the message for joints that several columns may be."""
    joint, column = error.joint, error.columns[0]
    arm = (
        f"; say which arm, as in --joints '{column.replace(joint, '*')}'" if joint in column else ""
    )
    return f"{question.path}: {error}{arm}"


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
    from .bags import read_bag, read_lerobot_log
    from .csv_log import read_csv_log

    name = _kind(question)
    readers = {"bags": read_bag, "lerobot": read_lerobot_log, "csv_log": read_csv_log}
    read = readers.get(name, read_kept_stream)
    if question.topic is not None and name != "bags":
        raise ExtractError("--topic is for bags")
    if question.units is not None and name not in ("lerobot", "csv_log"):
        raise ExtractError("--units is for lerobot data sets and CSV logs")
    log = read(question)
    if not len(log.stamps):
        raise ExtractError(f"{question.path}: no state in it can be used")
    return log


def _kind(question: Question) -> str:
    """Return the kind of log that a path is."""
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


def read_kept_stream(question: Question) -> Log:
    """Return the states of a kept stream, or of all in a placement's folder, one part each."""
    path, m = question.path, len(question.joints)
    files = sorted(path.glob("*.stream"), key=lambda f: (len(f.name), f.name))
    rows: list[tuple[np.ndarray, ...]] = []
    notes, last, measured = list[str](), 0, True
    for file in files if path.is_dir() else [path]:
        kept = read_stream_log(file)
        columns = needed_columns(kept.joints, question)
        if not len(kept.stamps):
            continue
        notes += [f"read {file.name}, {len(kept.stamps)} states", *kept.remarks]
        measured = measured and kept.efforts is not None
        efforts = np.full_like(kept.positions, np.nan) if kept.efforts is None else kept.efforts
        parts = kept.connections - kept.connections.min() + last
        last = int(parts.max()) + 1
        rows.append((kept.stamps, kept.positions[:, columns], efforts[:, columns], parts))
    empty = (np.empty(0), np.empty((0, m)), np.empty((0, m)), np.empty(0, dtype=int))
    stamps, positions, torques, numbers = map(np.concatenate, zip(empty, *rows, strict=True))
    return Log(stamps, positions, torques if measured else None, numbers, tuple(notes))

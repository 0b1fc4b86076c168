"""Joint states out of a log, a CSV file or a kept stream, and the model's joints in its columns."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...drivers import JointState
from ...errors import MukcaError
from ...recorder import ColumnError, match_joints
from ...solver.calibration import joints_named

FULL_TURN = 2 * np.pi + 0.1
"""No joint's angle in radians is larger."""
SLOWEST = 0.15
"""Logs with longer steps hold no rest of a third of a second [s]."""
NORMALISED = 100.0
"""Largest of values that lerobot normalises to the range of a motor."""
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

    @property
    def turning(self) -> np.ndarray:
        """True for those that turn, shape (m,)."""
        return ~np.array(self.prismatic)


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
    episodes: bool = False
    """True where each part has a clock of its own, as episodes do: no rest goes on in another."""

    @property
    def least_window(self) -> float:
        """A window must be as long as this to hold enough states [s]."""
        return 0.0 if self.step is None else (STATES + 0.5) * self.step

    @property
    def step(self) -> float | None:
        """Typical time from a state to the next of its part [s]; None where no part has two."""
        within = np.diff(self.parts) == 0
        steps = np.diff(self.stamps)[within]
        return float(np.median(steps)) if len(steps) else None

    def state(self, row: int) -> JointState:
        """Return one of the states."""
        position = tuple(self.positions[row].tolist())
        efforts = self.efforts
        effort = None if efforts is None else tuple(efforts[row].tolist())
        return JointState(float(self.stamps[row]), position, effort)


SET_BACK = 0.5
"""A stamp that is so much earlier than the one before it is of a clock that was set back [s]."""


def in_parts(
    stamps: Sequence[float] | np.ndarray,
    positions: Sequence[np.ndarray] | np.ndarray,
    efforts: Sequence[np.ndarray] | np.ndarray | None,
    notes: Sequence[str],
) -> Log:
    """Return a log of states as they came; where the clock was set back, another part begins.

    Within a part the states are put in order of time, each moment once.
    """
    times = np.asarray(stamps, dtype=float)
    # These are the last states before the clock was set back.
    last = np.flatnonzero(np.diff(times) < -SET_BACK)
    remarks = [
        f"{times[i] - times[0]:.1f} s after the first state the stamps went back by "
        f"{times[i] - times[i + 1]:.1f} s; what follows is a part of its own"
        for i in last
    ]
    parts = np.searchsorted(last, np.arange(len(times)))
    order = np.lexsort((times, parts))
    moments = np.array([parts[order], times[order]])
    steps = np.diff(moments, axis=1, prepend=-np.inf)
    rows = order[steps.any(axis=0)]
    q = np.asarray(positions)[rows]
    torques = None if efforts is None else np.asarray(efforts, dtype=float)[rows]
    return Log(times[rows], q, torques, parts[rows], (*notes, *remarks))


def require_rate(
    log: Log, question: Question, advice: str, slowest: float = SLOWEST
) -> None:
    """Refuse a log whose states are too seldom for a rest, or whose stamps are no seconds.

    Args:
        log: The log.
        question: Its path.
        advice: End of the message.
        slowest: Typical step from which it is refused [s].

    Raises:
        ExtractError: The states are too seldom.
    """
    step = np.inf if log.step is None else log.step
    if not 1e-5 < step < slowest:
        raise ExtractError(
            f"{question.path}: {len(log.stamps)} moments, typically {step:.3g} s apart; 10 a "
            f"second and more are needed; {advice}"
        )


def columns_of(names: Sequence[str], question: Question) -> list[int] | None:
    """Return where a log has the model's joints; None where it lacks one."""
    wanted = question.joints
    if question.named is not None:
        wanted = joints_named(question.named, wanted)
        lacks_one = not set(wanted) <= set(names)
        return None if lacks_one else [names.index(word) for word in wanted]
    try:
        match = match_joints(names, wanted, in_order=False)
    except ColumnError as error:
        raise ExtractError(which_arm(error, question)) from None
    return list(match.order) if match else None


def which_arm(error: ColumnError, question: Question) -> str:
    """Return the message for joints that several columns may be."""
    joint, column = error.joint, error.columns[0]
    arm = f"; say which arm, as in --joints '{column.replace(joint, '*')}'"
    return f"{question.path}: {error}{arm * (joint in column)}"


def require_angles(question: Question, kind: str) -> None:
    """Refuse units that are no radians nor degrees, of a log of some kind."""
    if question.units not in (None, "radians", "degrees"):
        raise ExtractError(f"--units {question.units}: for {kind}, radians or degrees")


def check_angles(angles: np.ndarray, degrees: bool, question: Question) -> None:
    """Refuse angles, shape (N, m) [rad], that were likely of another unit, of joints that turn."""
    turning = angles[:, question.turning]
    largest = float(np.abs(turning).max(initial=0.0))
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


def refuse_normalised(degrees: np.ndarray, question: Question) -> None:
    """Refuse angles [deg] that end at 100 exactly, as parts of a motor's range do.

    Raises:
        ExtractError: They do; without the motors' ranges nobody can make radians of them.
    """
    largest = float(np.abs(degrees).max(initial=0.0))
    if abs(largest - NORMALISED) < 1e-6:
        raise ExtractError(
            f"{question.path}: values end at {largest:g} exactly: no degrees, but parts of each "
            "motor's range, from -100 to 100; of a lerobot data set give --units FILE, the arm's "
            "calibration file"
        )


def needed_columns(names: Sequence[str], question: Question) -> list[int]:
    """Return where a log has the model's joints; an ExtractError where it lacks one."""
    columns = columns_of(names, question)
    if columns is None:
        raise unknown_joints(names, question)
    return columns


def unknown_joints(names: Sequence[str], question: Question) -> ExtractError:
    """Return the error for a log whose joints are not the model's."""
    listing = question.named or ", ".join(question.joints)
    return ExtractError(
        f"{question.path}: no state has all of {listing}; it has "
        f"{', '.join(names) or 'no joints'}; name them in chain order by --joints A,B,..."
    )

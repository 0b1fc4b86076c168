"""Options of a recording session, and the metadata of its placement."""

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Literal

from ...recorder import (
    METADATA,
    SOCKETS,
    Metadata,
    read_keys,
    read_metadata,
)
from ...recorder.session import TARGET
from ...recorder.stream import WINDOW, JointLimits
from ...recorder.terminal import ConsoleKeyboard, Keyboard, Script
from ...solver.calibration import SolveOptions, UsageError
from ...solver.identification.robot import Robot
from ..cli import (
    Options,
    RobotOptions,
    part,
)


def has_keyboard() -> bool:
    """Return whether standard input is a terminal."""
    return sys.stdin is not None and sys.stdin.isatty()  # pyright: ignore[reportUnnecessaryComparison]


POSES = 10
"""Poses of a quick session."""
HELD = 6
"""Samples in each socket for a session that tests a calibration."""


class _SessionOptions(Options, group="recording"):
    driver: str
    out: Path
    robot_name: str | None = None
    distance: float | None = None
    sockets: int | None = None
    target: int | None = None
    window: float = WINDOW
    still: float | None = None
    keys: Path | None = None
    keep_stream: bool = False


class _HandOptions(Options, group="hands and ears"):
    auto: bool = False
    key: Sequence[str] = ()
    sound: Literal["bell", "off"] = "bell"
    say: bool = False


class _GuideOptions(Options, group="guide"):
    goal_mm: float | None = None
    turn: float | None = None
    page: bool = False
    page_host: str = "127.0.0.1"
    no_guide: bool = False


class _TestOptions(Options, group="in two minutes"):
    quick: bool = False
    stops: bool = False
    calibration: Path | None = None


class _LoadOptions(Options, group="load, for noticing a hand on the arm"):
    load: SolveOptions = part(SolveOptions, "payload gravity")


class _NoteOptions(Options, group="notes, kept with the recording"):
    operator: str | None = None
    serial_number: str | None = None
    warm_up: float | None = None
    temperature: float | None = None
    notes: str | None = None


class RecordOptions(
    _SessionOptions,
    _HandOptions,
    _GuideOptions,
    _TestOptions,
    _LoadOptions,
    _NoteOptions,
    RobotOptions,
):
    """Options of ``mukca record``."""

    @property
    def scripted(self) -> bool:
        """True where a script presses the keys."""
        return self.keys is not None or not has_keyboard()

    @property
    def samples(self) -> int:
        """Samples to take in each socket."""
        default = POSES if self.quick else HELD if self.calibration else TARGET
        return self.target or default

    def open_keys(self, stack: ExitStack) -> tuple[Keyboard | None, Script | None]:
        """Return the keyboard where there is a terminal, and the script where there is one."""
        keyboard = None
        if has_keyboard() and sys.platform == "win32":
            import msvcrt

            keyboard = ConsoleKeyboard(msvcrt)
        elif has_keyboard():
            keyboard = Keyboard()
        if self.keys:
            try:
                file = stack.enter_context(self.keys.open("rb"))
            except OSError as error:
                raise UsageError(f"--keys {self.keys}: {error.strerror}") from None
            return keyboard, Script(file.fileno(), str(self.keys))
        if keyboard:
            return keyboard, None
        if self.auto:
            raise UsageError(
                "--auto needs a terminal, for the keys between two sockets"
            )
        if self.goal_mm is not None or self.turn is not None:
            raise UsageError("--goal-mm and --turn need a terminal, where the guide is")
        if sys.stdin is None:  # pyright: ignore[reportUnnecessaryComparison]
            raise UsageError(
                "standard input is closed; run it in a terminal, or use --keys FILE"
            )
        return None, Script(sys.stdin.fileno())

    def metadata(self, robot: Robot) -> Metadata:
        """Return the placement's metadata by the options and the recording that is continued."""
        file = self.out / METADATA
        sockets: object = 1 if self.quick else self.sockets
        if sockets is None:
            sockets = read_metadata(file).get("sockets")
        keys = read_keys(file)
        measured = keys.distance is not None and not keys.distance_assumed
        return Metadata(
            robot=robot.name,
            joints=robot.joint_names,
            units=tuple(joint.unit for joint in joints_of(robot)),
            distance=self.distance or keys.distance,
            measured=self.distance is not None or measured,
            sockets=sockets
            if isinstance(sockets, int) and 1 <= sockets <= 10
            else SOCKETS,
            model_sha256=robot.sha256,
            robot_name=self.robot_name or "",
        )


def joints_of(robot: Robot) -> tuple[JointLimits, ...]:
    """Return the limits of the chain's actuated joints."""
    return tuple(
        JointLimits(
            joint.name, joint.lower, joint.upper, prismatic=joint.type == "prismatic"
        )
        for joint in robot.actuated
    )

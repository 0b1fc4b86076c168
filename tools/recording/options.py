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
from ...recorder.stream import STILL, WINDOW, JointLimits
from ...recorder.terminal import ConsoleKeyboard, Keyboard, Script
from ...solver.calibration import SolveOptions, UsageError
from ...solver.identification.robot import Robot
from ..cli import (
    DISTANCES,
    SPREADS,
    WINDOWS,
    Options,
    RobotOptions,
    option,
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
    driver: str = option(
        ...,
        "the arm's driver and address, as in franka:172.16.0.2; mukca drivers lists them",
        "NAME[:ADDRESS]",
    )
    out: Path = option(
        ...,
        "folder of this placement; if it is there, the recording goes on",
        "DIR/PLACEMENT",
    )
    robot_name: str | None = option(
        None, "which of several robots it is, as solve --robot NAME=R has it", "NAME"
    )
    distance: float | None = option(
        None,
        "distance of the centres of sockets 0 and 1 in metres, measured with a caliper "
        "(default: that of a recording that goes on; else you are asked)",
        "M",
        between=DISTANCES,
    )
    sockets: int | None = option(
        None,
        "number of sockets, 1 to 10 (default: {})",
        "N",
        between=(1, 10),
        usual=SOCKETS,
        unless="quick",
    )
    target: int | None = option(
        None,
        "samples for each socket (default: {})",
        "N",
        between=(1, 10_000),
        usual=TARGET,
    )
    window: float = option(
        WINDOW, "seconds that a capture averages", "S", between=WINDOWS
    )
    still: float | None = option(
        None,
        "an arm whose standard deviation over the window is larger is not still (default: {}, "
        "or the step of its encoders)",
        "RAD",
        between=SPREADS,
        usual=STILL,
    )
    keys: Path | None = option(None, "read keys from a script", "FILE")
    keep_stream: bool = option(
        False, "also keep every state in a compact file, which mukca extract reads"
    )


class _HandOptions(Options, group="hands and ears"):
    auto: bool = option(
        False,
        "capture without a key wherever the arm rests at a new, plausible pose; press a key at"
        " each change of socket",
    )
    key: Sequence[str] = option(
        (),
        "let keys do something, as in capture=Enter,PageDown for a foot pedal or a presenter: "
        "capture, undo, redo, delete, relabel, measure, next, avoid, finish, help, yes, new, keep",
        "ACTION=KEY,...",
        repeated=True,
    )
    sound: Literal["bell", "off"] = option(
        "bell",
        "the terminal's bell: once for a capture, twice for a refusal, three times for a "
        "socket done, and a pattern each for an alarm, ENOUGH and NEXT PLACE",
    )
    say: bool = option(
        False,
        "also say captures, refusals, alarms and ends aloud, by spd-say, espeak-ng, espeak or say",
    )


class _GuideOptions(Options, group="guide"):
    goal_mm: float | None = option(
        None,
        "aim for this predicted error of distances in the workspace (default: what mukca solve"
        " asks)",
        "MM",
        between=(1e-3, 1e3),
        unless="calibration no_guide quick keys",
    )
    turn: float | None = option(
        None,
        "turn no joint farther than this from where the session began, to spare cables",
        "DEG",
        between=(30, 360),
        unless="no_guide quick keys",
    )
    page: bool = option(
        False,
        "also show the session on a page for a tablet beside the arm; the page only reads, and"
        " the screen has its address",
    )
    page_host: str = option(
        "127.0.0.1",
        "address that serves the page; 0.0.0.0 lets the whole network see it (default: this "
        "computer alone)",
        "HOST",
        needs="page",
    )
    no_guide: bool = option(False, "record without a fit: no advice, no alarms")


class _TestOptions(Options, group="in two minutes"):
    quick: bool = option(
        False, "take ten poses in one socket: is this arm worth calibrating?"
    )
    stops: bool = option(
        False,
        "lead each joint to both of its stops once, without a ball; mukca rezero --stops then "
        "tells zeros",
        unless="quick calibration keys",
    )
    calibration: Path | None = option(
        None,
        "say whether this calibration still holds (exit status 1 if not). Without --quick: "
        "take {} samples in each of two sockets, at poses that tell the joints' zeros best",
        "FILE",
        usual=HELD,
    )


class _LoadOptions(Options, group="load, for noticing a hand on the arm"):
    load: SolveOptions = part(SolveOptions, "payload gravity")


class _NoteOptions(Options, group="notes, kept with the recording"):
    operator: str | None = option(None, "who records", "NAME")
    serial_number: str | None = option(None, "serial number of the arm", "TEXT")
    warm_up: float | None = option(
        None, "minutes since power-on", "MIN", between=(0, 1e6)
    )
    temperature: float | None = option(
        None, "temperature in degrees Celsius", "C", between=(-100, 200)
    )
    notes: str | None = option(None, "anything else worth keeping", "TEXT")


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

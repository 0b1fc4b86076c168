"""Resources of a session: its keys, the robot's driver, the recording's file and log."""

import sys
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from typing import Any

from ...drivers import Reconnecting, open_driver
from ...recorder import Metadata, StreamLog, next_log_file
from ...recorder.session import Recording
from ...recorder.stream import JointLimits, Stream
from ...recorder.terminal import ConsoleKeyboard, Keyboard, Script
from ...solver.calibration import UsageError
from ...solver.robot import Robot
from ..cli import Terminal
from ..simulation import practice_driver
from .options import RecordOptions, SettledOptions, has_keyboard

NOTES = ("operator", "serial_number", "warm_up", "temperature", "notes")


def keys_of(options: RecordOptions, stack: ExitStack) -> tuple[Keyboard | None, Script | None]:
    """Return the keyboard where there is a terminal, and the script where there is one."""
    keyboard = None
    if has_keyboard() and sys.platform == "win32":
        import msvcrt

        keyboard = ConsoleKeyboard(msvcrt)
    elif has_keyboard():
        keyboard = Keyboard()
    if options.keys is not None:
        try:
            file = stack.enter_context(options.keys.open("rb"))
        except OSError as error:
            raise UsageError(f"--keys {options.keys}: {error.strerror}") from None
        return keyboard, Script(file.fileno(), str(options.keys))
    if keyboard:
        return keyboard, None
    if options.auto:
        raise UsageError("--auto needs a terminal, for the keys between two sockets")
    if sys.stdin is None:  # pyright: ignore[reportUnnecessaryComparison]
        raise UsageError("standard input is closed; run it in a terminal, or use --keys FILE")
    return None, Script(sys.stdin.fileno())


def connect(text: str, robot: Robot) -> Reconnecting:
    """Open ``NAME[:ADDRESS]`` as a driver that connects again by itself."""
    name, _, address = text.partition(":")
    if name == "mock" and "fault=" in address:
        return Reconnecting(practice_driver(address, robot))
    return Reconnecting(lambda: open_driver(name, address, robot.joint_names))


def open_recording(
    options: SettledOptions, robot: Robot, joints: tuple[JointLimits, ...], still: float
) -> Recording:
    """Open the file of the samples, with what was noted of this start."""
    given: dict[str, Any] = {name: getattr(options, name) for name in NOTES}
    return Recording(
        options.out,
        Metadata(
            robot=robot.name,
            joints=robot.joint_names,
            units=tuple(joint.unit for joint in joints),
            distance=options.distance if options.stated else None,
            measured=options.measured,
            sockets=options.sockets,
            model_sha256=robot.sha256,
            robot_name=options.robot_name or "",
            session={
                "driver": options.driver,
                "window": options.window,
                "still": still,
                **{name: value for name, value in given.items() if value is not None},
            },
        ),
    )


@contextmanager
def open_log(
    stream: Stream, options: SettledOptions, robot: Robot, terminal: Terminal
) -> Generator[None, None, None]:
    """Log every state to a file beside the samples."""
    log = StreamLog(next_log_file(options.out), robot.joint_names)
    stream.log = log
    try:
        yield
    finally:
        log.close()
        if log.trouble:
            terminal.warn(log.trouble)

"""Inputs of a recording session: the keyboard or a key script, and the robot's driver."""

import sys
from contextlib import ExitStack

from ...drivers import Reconnecting, open_driver
from ...recorder.terminal import Keyboard, Script
from ...solver.calibration import UsageError
from .options import RecordOptions


def is_scripted(options: RecordOptions) -> bool:
    """Return whether a script presses the keys."""
    return options.keys is not None or not _has_keyboard()


def _has_keyboard() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()  # pyright: ignore[reportUnnecessaryComparison]


def keys_of(options: RecordOptions, stack: ExitStack) -> tuple[Keyboard | None, Script | None]:
    """Return the keyboard where there is a terminal, and the script where there is one."""
    keyboard = Keyboard() if _has_keyboard() else None
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


def connect(text: str, joint_names: tuple[str, ...]) -> Reconnecting:
    """Open ``NAME[:ADDRESS]`` as a driver that connects again by itself."""
    name, _, address = text.partition(":")
    return Reconnecting(lambda: open_driver(name, address, joint_names))

"""``mukca record``: record at the robot, in the terminal."""

import argparse
import gc
import logging
import os
import shlex
import sys
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...drivers.registry import open_driver
from ...recorder.session import SOCKETS, STILL, TARGET, WINDOW
from ..arguments import UsageError, add_load, add_robot, load_of, robot_of
from ..terminal import Terminal

if TYPE_CHECKING:
    from ...drivers.reconnect import Reconnecting
    from ...recorder.display import Lines, Screen
    from ...recorder.keyboard import Keyboard
    from ...recorder.record import Outcome
    from ...recorder.recording import Recording
    from ...recorder.script import Script
    from ...recorder.session import JointLimits, Session
    from ...solver.robot.urdf import Robot

EXAMPLE = """example:
  mukca record --robot panda --driver franka:172.16.0.2 --out data/front

keys:
  space or a  capture         s       next socket      q  finish
  d or u      undo            0 to 9  that socket      ?  help

A key script (--keys FILE, or piped standard input) has words between blanks:
  a           wait until the arm rests at a new place, and has rested for a whole window; capture
  !a          capture at once, whatever the arm does
  d u s 0 1 ? q, or several as in sa   the keys
  a*30        the word thirty times
  wait=2.5    wait until the robot's clock has gone on by 2.5 s
  # ...       a comment, up to the end of the line
as in:  echo 'a*30 s a*30 q' | mukca record ...
Its end finishes the session. The status is then 1 if a capture was refused, or if the arm came to
no new rest within 30 s. A session ended by a signal returns 129, 130, 131 or 143; all is saved."""

NOTES = ("operator", "serial_number", "warm_up", "temperature", "notes")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    add_robot(parser)
    required = parser.add_argument_group("recording")
    add = required.add_argument
    add("--driver", required=True, metavar="NAME[:ADDRESS]", help="see mukca drivers")
    add("--out", required=True, type=Path, metavar="DIR/PLACEMENT", help="continued if it exists")
    add("--distance", type=float, default=0.05, metavar="M", help="between the centres of sockets "
        "0 and 1, in metres, as measured with a caliper (default: %(default)s)")  # fmt: skip
    add("--sockets", type=int, default=SOCKETS, metavar="N", help="1 to 10 (default: %(default)s)")
    add(
        "--target",
        type=int,
        default=TARGET,
        metavar="N",
        help="samples for each socket (default: %(default)s)",
    )
    add(
        "--window",
        type=float,
        default=WINDOW,
        metavar="S",
        help="seconds that a capture averages (default: %(default)s)",
    )
    add(
        "--still",
        type=float,
        metavar="RAD",
        help="largest standard deviation over the window of an arm that is still "
        f"(default: {STILL}, or the step of its encoders)",
    )
    add("--keys", type=Path, metavar="FILE", help="read keys from a script")
    add_load(parser, "noticing a hand on the arm")
    notes = parser.add_argument_group("notes, kept with the recording")
    notes.add_argument("--operator", metavar="NAME")
    notes.add_argument("--serial-number", metavar="TEXT", help="of the arm")
    notes.add_argument("--warm-up", type=float, metavar="MIN", help="minutes since power-on")
    notes.add_argument("--temperature", type=float, metavar="C", help="degrees Celsius")
    notes.add_argument("--notes", metavar="TEXT")


def run(arguments: argparse.Namespace, terminal: Terminal) -> int:
    """Record until the operator finishes."""
    if find_spec("termios") is None:
        raise UsageError(
            "recording does not yet work on Windows; record on Linux, on macOS or in WSL. "
            "check, solve, validate and report do work here"
        )
    _check(arguments)
    robot = robot_of(arguments)
    outcome = _record(arguments, robot, terminal)
    try:
        _say_outcome(outcome, arguments, terminal)
        sys.stdout.flush()
    except OSError:
        _mute()
    if outcome.signal is not None:
        return 128 + outcome.signal
    return 1 if outcome.refused and _is_scripted(arguments) else 0


def joints_of(robot: "Robot") -> "tuple[JointLimits, ...]":
    """Return the chain's actuated joints as the recorder sees them."""
    from ...recorder.session import JointLimits

    return tuple(
        JointLimits(joint.name, joint.lower, joint.upper, prismatic=joint.type == "prismatic")
        for joint in robot.actuated
    )


def _record(arguments: argparse.Namespace, robot: "Robot", terminal: Terminal) -> "Outcome":
    """Open all that a session needs, in the order in which it can fail, and run it."""
    from ...recorder.push import Push
    from ...recorder.record import Recorder
    from ...recorder.stream import Stream
    from ...recorder.watch import Watch
    from ..hints import gravity_of, seat_check

    joints = joints_of(robot)
    push, check = Push(joints, gravity_of(robot, load_of(arguments))), seat_check(robot)
    with ExitStack() as stack:
        keyboard, script = _keys(arguments, stack)
        stack.enter_context(_quiet())
        stack.enter_context(_without_pauses())
        driver = stack.enter_context(_connect(arguments.driver, robot.joint_names))
        still = max(STILL, driver.resolution) if arguments.still is None else arguments.still
        stream = Stream(driver)
        stack.callback(stream.close)
        recording = stack.enter_context(_recording(arguments, robot, joints, still))
        live = script is None
        return Recorder(
            session=_session(arguments, joints, recording),
            stream=stream,
            watch=Watch(
                joints,
                window=arguments.window,
                still=still,
                live=live,
                resolution=driver.resolution,
            ),
            recording=recording,
            display=_display(terminal),
            title=f"{robot.name}  {arguments.driver}  {arguments.out}",
            keyboard=keyboard,
            script=script,
            push=push,
            check=check,
        ).run()


def _check(arguments: argparse.Namespace) -> None:
    """Refuse numbers that mean nothing."""
    for name, low, high in (
        ("distance", 1e-3, 10.0),
        ("window", 0.02, 10.0),
        ("still", 1e-9, 0.1),
        ("sockets", 1, 10),
        ("target", 1, 10_000),
        ("warm_up", 0, 1e6),
        ("temperature", -100, 200),
    ):
        value = getattr(arguments, name)
        if value is not None and not low <= value <= high:
            option = name.replace("_", "-")
            raise UsageError(f"--{option} {value:g}: expected {low:g} to {high:g}")


def _is_scripted(arguments: argparse.Namespace) -> bool:
    return arguments.keys is not None or not _has_keyboard()


def _has_keyboard() -> bool:
    return sys.stdin is not None and sys.stdin.isatty()  # pyright: ignore[reportUnnecessaryComparison]


def _keys(
    arguments: argparse.Namespace, stack: ExitStack
) -> "tuple[Keyboard | None, Script | None]":
    """Return the keyboard where there is a terminal, and the script where there is one."""
    from ...recorder.keyboard import Keyboard
    from ...recorder.script import Script

    keyboard = Keyboard() if _has_keyboard() else None
    if arguments.keys is not None:
        try:
            file = stack.enter_context(arguments.keys.open("rb"))
        except OSError as error:
            raise UsageError(f"--keys {arguments.keys}: {error.strerror}") from None
        return keyboard, Script(file.fileno(), str(arguments.keys))
    if keyboard:
        return keyboard, None
    if sys.stdin is None:  # pyright: ignore[reportUnnecessaryComparison]
        raise UsageError("standard input is closed; run it in a terminal, or use --keys FILE")
    return None, Script(sys.stdin.fileno())


@contextmanager
def _quiet() -> Generator[None, None, None]:
    """Keep the library's log off the screen; what matters of it stands there anyway."""
    log = logging.getLogger("mukca")
    handler, propagate = logging.NullHandler(), log.propagate
    log.addHandler(handler)
    log.propagate = False
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.propagate = propagate


@contextmanager
def _without_pauses() -> Generator[None, None, None]:
    """Keep what was loaded by now out of garbage collection.

    To look through all of it takes a tenth of a second, in which no state is read.
    """
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def _connect(text: str, joint_names: tuple[str, ...]) -> "Reconnecting":
    from ...drivers.reconnect import Reconnecting

    name, _, address = text.partition(":")
    return Reconnecting(lambda: open_driver(name, address, joint_names))


def _recording(
    arguments: argparse.Namespace,
    robot: "Robot",
    joints: "tuple[JointLimits, ...]",
    still: float,
) -> "Recording":
    from ...recorder.recording import Metadata, Recording

    given: dict[str, Any] = {name: getattr(arguments, name) for name in NOTES}
    return Recording(
        arguments.out,
        Metadata(
            robot=robot.name,
            joints=robot.joint_names,
            units=tuple(joint.unit for joint in joints),
            distance=arguments.distance,
            sockets=arguments.sockets,
            model_sha256=robot.sha256,
            session={
                "driver": arguments.driver,
                "window": arguments.window,
                "still": still,
                **{name: value for name, value in given.items() if value is not None},
            },
        ),
    )


def _session(
    arguments: argparse.Namespace, joints: "tuple[JointLimits, ...]", recording: "Recording"
) -> "Session":
    """Return the session as an earlier start left it."""
    from ...recorder.session import Session

    content = recording.content
    last = content.live[-1].socket if content.live else 0
    session = Session(
        joints,
        sockets=arguments.sockets,
        target=arguments.target,
        socket=last,
        samples=content.samples,
        withdrawn=content.withdrawn,
    )
    for remark in recording.remarks:
        session = session.with_message(remark, alarm=True)
    if session.samples:
        session = session.with_message(f"continues a recording of {len(session.live)} samples")
    return session


def _display(terminal: Terminal) -> "Screen | Lines":
    from ...recorder.display import Lines, Screen

    console = terminal.console
    whole = console.is_terminal and not console.is_dumb_terminal
    return Screen(console) if whole and console.file.isatty() else Lines(console)


def _say_outcome(outcome: "Outcome", arguments: argparse.Namespace, terminal: Terminal) -> None:
    session = outcome.session
    counts = ", ".join(f"{count} in socket {k}" for k, count in enumerate(session.counts))
    taken_back = f" ({len(session.withdrawn)} taken back)" if session.withdrawn else ""
    terminal.say(f"{arguments.out / 'samples.csv'}: {counts}{taken_back}")
    if outcome.refused:
        terminal.say(f"{outcome.refused} captures were refused")
    if outcome.signal is None and min(session.counts) > 0:
        words = ["mukca", "solve", str(arguments.out), "--robot", arguments.robot]
        terminal.say(f"Next: another placement, then  {shlex.join(words)} --test HELD_OUT")


def _mute() -> None:
    """Write to nowhere from now on: the terminal is gone."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (sys.stdout, sys.stderr):
        os.dup2(nowhere, stream.fileno())

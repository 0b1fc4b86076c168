"""``mukca record``: record at the robot, in the terminal."""

import argparse
import os
import shlex
import signal
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Literal

from ....recorder import SOCKETS
from ....recorder.session import TARGET
from ....recorder.stream import STILL, WINDOW
from ....solver.calibration import SolveOptions, UsageError
from .. import DISTANCES, SPREADS, WINDOWS, RobotOptions, Terminal, option, part

if TYPE_CHECKING:
    from ....recorder.terminal import Outcome
    from ....solver.calibration import Calibration
    from ....solver.robot import Robot

POSES = 10
"""So many a quick session takes."""
LEAST_POSES = 5
"""With fewer it says nothing."""
EXAMPLE = """example:
  mukca record --robot panda --driver franka:172.16.0.2 --distance 0.0501 --out data/front
  mukca record --robot panda --driver franka:172.16.0.2 --out data/front --auto --page
  mukca record --robot panda --driver franka:172.16.0.2 --out quick/today --quick

keys:
  space or a  capture         s       next socket      q  finish
  d or u      undo            0 to 9  that socket      ?  help
  r           redo            x, l    delete, or give another socket to, a sample by its number

A key script (--keys FILE, or piped standard input) has words between blanks:
  a           wait until the arm rests at a new place, and has rested for a whole window; capture
  !a          capture at once, whatever the arm does
  d u r s 0 1 ? q, or several as in sa   the keys
  delete=12, relabel=12:1   a sample by its number, and the socket it was in
  a*30        the word thirty times
  wait=2.5    wait until the robot's clock has gone on by 2.5 s
  # ...       a comment, up to the end of the line
as in:  echo 'a*30 s a*30 q' | mukca record ...
Its end finishes the session. The status is then 1 if a capture was refused, or if the arm came to
no new rest within 30 s. A session ended by a signal returns 129, 130, 131 or 143; all is saved."""


_recording = partial(option, group="recording")
_hands = partial(option, group="hands and ears")
_guide = partial(option, group="guide")
_quick = partial(option, group="in two minutes")
_notes = partial(option, group="notes, kept with the recording")


@dataclass(frozen=True, kw_only=True)
class Options(RobotOptions):
    """Options of ``mukca record``."""

    driver: str = _recording("see mukca drivers", "NAME[:ADDRESS]", ...)
    out: Path = _recording("continued if it exists", "DIR/PLACEMENT", ...)
    robot_name: str | None = _recording(
        "which of several robots it is, as solve --robot NAME=R has it", "NAME"
    )
    distance: float | None = _recording(
        "between the centres of sockets 0 and 1, in metres, as measured with a caliper "
        "(default: what is continued, or 0.05)",
        "M",
        between=DISTANCES,
    )
    sockets: int | None = _recording(f"1 to 10 (default: {SOCKETS})", "N", between=(1, 10))
    target: int | None = _recording(
        f"samples for each socket (default: {TARGET})", "N", between=(1, 10_000)
    )
    window: float = _recording("seconds that a capture averages", "S", WINDOW, between=WINDOWS)
    still: float | None = _recording(
        "largest standard deviation over the window of an arm that is still "
        f"(default: {STILL}, or the step of its encoders)",
        "RAD",
        between=SPREADS,
    )
    keys: Path | None = _recording("read keys from a script", "FILE")
    keep_stream: bool = _recording(
        "keep every state in a compact file beside the samples, for mukca extract to look at again",
        default=False,
    )
    auto: bool = _hands(
        "capture without a key wherever the arm comes to rest at a new, plausible pose; a key at "
        "each change of socket",
        default=False,
    )
    key: Sequence[str] = _hands(
        "let keys do something, as in capture=Enter,PageDown for a foot pedal or a presenter: "
        "capture, undo, redo, delete, relabel, next, finish, help",
        "ACTION=KEY,...",
        (),
        repeated=True,
    )
    sound: Literal["bell", "off"] = _hands(
        "the terminal's bell: once captured, twice refused, three times a socket done",
        default="bell",
    )
    goal_mm: float | None = _guide(
        "what the predicted error of distances in the workspace should come to (default: three "
        "times the arm's repeatability)",
        "MM",
        between=(1e-3, 1e3),
    )
    page: bool = _guide(
        "show the same on a page, read-only, for a tablet beside the arm; its address is on the "
        "screen",
        default=False,
    )
    page_host: str = _guide(
        "where the page is served; 0.0.0.0 lets the whole network see it (default: this computer "
        "alone)",
        "HOST",
        "127.0.0.1",
    )
    no_guide: bool = _guide("no fit while recording", default=False)
    quick: bool = _quick(
        "one socket, ten poses: how far off is this arm, and is it worth calibrating?",
        default=False,
    )
    calibration: Path | None = _quick(
        "with --quick: does this calibration still hold? Exit status 1 if not", "FILE"
    )
    load: SolveOptions = part(
        SolveOptions, "payload", "gravity", group="load, for noticing a hand on the arm"
    )
    operator: str | None = _notes("", "NAME")
    serial_number: str | None = _notes("of the arm", "TEXT")
    warm_up: float | None = _notes("minutes since power-on", "MIN", between=(0, 1e6))
    temperature: float | None = _notes("degrees Celsius", "C", between=(-100, 200))
    notes: str | None = _notes("", "TEXT")


def run(options: Options, terminal: Terminal) -> int:
    """Record until the operator finishes."""
    if find_spec("termios") is None:
        raise UsageError(
            "recording does not yet work on Windows; record on Linux, on macOS or in WSL. "
            "check, solve, validate and report do work here"
        )
    # A session fills in what is continued: the distance, the sockets, the next placement.
    arguments = argparse.Namespace(**vars(options))
    with _interruptible():
        _fill_in(arguments)
        if sys.stdout.isatty():
            terminal.say("loading ...")
            sys.stdout.flush()
        from ...recording import is_scripted, record_session

        robot = options.load_robot()
        calibration = _calibration(arguments)
        outcome = record_session(arguments, robot, terminal)
        while outcome.new_placement and outcome.signal is None:
            arguments.out = next_folder(arguments.out)
            outcome = record_session(arguments, robot, terminal, moved=True)
    try:
        _say_outcome(outcome, arguments, terminal)
        sys.stdout.flush()
    except OSError:
        _mute()
    if outcome.signal is not None:
        return 128 + outcome.signal
    drifted = arguments.quick and _judge(arguments, robot, calibration, outcome, terminal)
    return 1 if drifted or (outcome.refused and is_scripted(arguments)) else 0


def _fill_in(arguments: argparse.Namespace) -> None:
    """Set what --quick stands for, and what is left to its default."""
    if arguments.calibration and not arguments.quick:
        raise UsageError("--calibration is for --quick; mukca validate looks at recordings")
    if arguments.quick:
        arguments.sockets = 1
        arguments.no_guide = True
    if arguments.target is None:
        arguments.target = POSES if arguments.quick else TARGET


def _calibration(arguments: argparse.Namespace) -> "Calibration | None":
    """Return the calibration that is looked at, read before anything is recorded."""
    if arguments.calibration is None:
        return None
    from ....solver.calibration import load_calibration

    return load_calibration(arguments.calibration)


def _judge(
    arguments: argparse.Namespace,
    robot: "Robot",
    calibration: "Calibration | None",
    outcome: "Outcome",
    terminal: Terminal,
) -> bool:
    """Say what a quick session shows; return whether the calibration does not hold any more."""
    from ...recording import verify_calibration, worth_calibrating

    if len(outcome.session.live) < LEAST_POSES:
        terminal.say(f"Too few poses to tell: record {LEAST_POSES} at least.")
        return False
    if calibration is None:
        terminal.say(worth_calibrating(robot, arguments.out))
        return False
    odds = verify_calibration(calibration, arguments.out)
    terminal.say(odds.text)
    return not odds.valid


def next_folder(folder: Path) -> Path:
    """Return the first of ``front-2``, ``front-3``, ... that does not exist."""
    count = 2
    while (other := folder.with_name(f"{folder.name}-{count}")).exists():
        count += 1
    return other


@contextmanager
def _interruptible() -> Generator[None, None, None]:
    """Let Ctrl-C end the program at once while it loads and connects.

    As an exception it could be swallowed by whatever is being imported. Nothing is open yet that
    could be lost; once the session runs, it looks at signals by itself.
    """

    def end(number: int, frame: FrameType | None) -> None:
        os.write(sys.stderr.fileno(), b"\nmukca record: interrupted\n")
        os._exit(130)

    before = signal.signal(signal.SIGINT, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _say_outcome(outcome: "Outcome", arguments: argparse.Namespace, terminal: Terminal) -> None:
    session = outcome.session
    counts = ", ".join(f"{count} in socket {k}" for k, count in enumerate(session.counts))
    taken_back = f" ({len(session.withdrawn)} taken back)" if session.withdrawn else ""
    terminal.say(f"{arguments.out / 'samples.csv'}: {counts}{taken_back}")
    if outcome.refused:
        terminal.say(f"{outcome.refused} captures were refused")
    if terminal.brief or arguments.quick:
        return
    if outcome.signal is None and min(session.counts) > 0:
        for line in _next_steps(outcome, arguments):
            terminal.say(line)


def _next_steps(outcome: "Outcome", arguments: argparse.Namespace) -> list[str]:
    """Return the commands to go on with, as they can be typed in the same folder."""
    robot = ["--robot", str(arguments.robot)]
    for name in ("base", "flange"):
        value = getattr(arguments, name)
        robot += [f"--{name}", value] if value else []
    robot += ["--tip", arguments.tip] if arguments.tip != "ball_link" else []
    robot += ["--ball", *map(repr, arguments.ball)] if arguments.ball else []
    out = str(arguments.out)
    again = ["--driver", arguments.driver, "--distance", repr(arguments.distance)]
    again += ["--robot-name", arguments.robot_name] if arguments.robot_name else []
    again += [f"--{name}" for name in ("auto", "page") if getattr(arguments, name)]
    again += [word for keys in arguments.key for word in ("--key", keys)]
    again += ["--out", str(next_folder(arguments.out))]
    advised = outcome.advice.closing if outcome.advice else ()
    return [
        *advised,
        f"Next: {shlex.join(['mukca', 'check', out, *robot])}",
        f"then: {shlex.join(['mukca', 'solve', out, *robot, '--out', f'{out}-calibrated'])}",
        f"or, better, the base elsewhere first: {shlex.join(['mukca', 'record', *robot, *again])}",
    ]


def _mute() -> None:
    """Write to nowhere from now on: the terminal is gone."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (sys.stdout, sys.stderr):
        os.dup2(nowhere, stream.fileno())

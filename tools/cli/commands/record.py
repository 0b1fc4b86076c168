"""``mukca record``: record at the robot, in the terminal."""

import argparse
import os
import shlex
import signal
import sys
from collections.abc import Generator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from ....recorder import SOCKETS
from ....recorder.session import TARGET
from ....recorder.stream import STILL, WINDOW
from .. import Terminal, add_load, add_robot, robot_of
from ..robot_arguments import UsageError

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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.epilog = EXAMPLE
    add_robot(parser)
    required = parser.add_argument_group("recording")
    add = required.add_argument
    add("--driver", required=True, metavar="NAME[:ADDRESS]", help="see mukca drivers")
    add("--out", required=True, type=Path, metavar="DIR/PLACEMENT", help="continued if it exists")
    add("--robot-name", metavar="NAME", help="which of several robots it is, as solve --robot "
        "NAME=R has it")  # fmt: skip
    add("--distance", type=float, metavar="M", help="between the centres of sockets 0 and 1, in "
        "metres, as measured with a caliper (default: what is continued, or 0.05)")  # fmt: skip
    add("--sockets", type=int, metavar="N", help=f"1 to 10 (default: {SOCKETS})")
    add("--target", type=int, metavar="N", help=f"samples for each socket (default: {TARGET})")
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
    add("--keep-stream", action="store_true", help="keep every state in a compact file beside the "
        "samples, for mukca extract to look at again")  # fmt: skip
    hands = parser.add_argument_group("hands and ears")
    hands.add_argument("--auto", action="store_true", help="capture without a key wherever the arm "
        "comes to rest at a new, plausible pose; a key at each change of socket")  # fmt: skip
    hands.add_argument("--key", action="append", default=[], metavar="ACTION=KEY,...", help="let "
        "keys do something, as in capture=Enter,PageDown for a foot pedal or a presenter: capture, "
        "undo, redo, delete, relabel, next, finish, help")  # fmt: skip
    hands.add_argument("--sound", choices=("bell", "off"), default="bell", help="the terminal's "
        "bell: once captured, twice refused, three times a socket done")  # fmt: skip
    guide = parser.add_argument_group("guide")
    guide.add_argument(
        "--goal-mm",
        type=float,
        metavar="MM",
        help="what the predicted error of distances in the workspace should come to (default: "
        "three times the arm's repeatability)",
    )
    guide.add_argument("--page", action="store_true", help="show the same on a page, read-only, "
        "for a tablet beside the arm; its address is on the screen")  # fmt: skip
    guide.add_argument("--page-host", metavar="HOST", default="127.0.0.1", help="where the page is "
        "served; 0.0.0.0 lets the whole network see it (default: this computer alone)")  # fmt: skip
    guide.add_argument("--no-guide", action="store_true", help="no fit while recording")
    quick = parser.add_argument_group("in two minutes")
    quick.add_argument("--quick", action="store_true", help="one socket, ten poses: how far off is "
        "this arm, and is it worth calibrating?")  # fmt: skip
    quick.add_argument("--calibration", type=Path, metavar="FILE", help="with --quick: does this "
        "calibration still hold? Exit status 1 if not")  # fmt: skip
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
    with _interruptible():
        _check(arguments)
        _fill_in(arguments)
        if sys.stdout.isatty():
            terminal.say("loading ...")
            sys.stdout.flush()
        from ...recording import is_scripted, record_session

        robot = robot_of(arguments)
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
        ("goal_mm", 1e-3, 1e3),
    ):
        value = getattr(arguments, name)
        if value is not None and not low <= value <= high:
            option = name.replace("_", "-")
            raise UsageError(f"--{option} {value:g}: expected {low:g} to {high:g}")


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
    for option in ("base", "flange"):
        value = getattr(arguments, option)
        robot += [f"--{option}", value] if value else []
    robot += ["--tip", arguments.tip] if arguments.tip != "ball_link" else []
    robot += ["--ball", *map(repr, arguments.ball)] if arguments.ball else []
    out = str(arguments.out)
    again = ["--driver", arguments.driver, "--distance", repr(arguments.distance)]
    again += ["--robot-name", arguments.robot_name] if arguments.robot_name else []
    again += [f"--{option}" for option in ("auto", "page") if getattr(arguments, option)]
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

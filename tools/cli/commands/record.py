"""``mukca record``: record at the robot, in the terminal."""

import os
import shlex
import signal
import sys
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from types import FrameType

from .... import recorder
from ....recorder import terminal as recorder_terminal
from ....solver import calibration
from ....solver.assessment import plural
from ....solver.calibration import UsageError
from ... import recording, simulation
from ...recording import RecordOptions
from ...report import figures
from .. import Terminal, one_arm

LEAST_POSES = 5
"""Poses below which a quick session says nothing."""
NOT_ENOUGH = 3
"""Exit status where the data do not suffice to say."""


def run_record(options: RecordOptions, terminal: Terminal) -> int:
    """Record until the operator finishes."""
    with _interruptible():
        terminal.say_at_once("loading ...")
        robot = options.load_robot()
        if options.stops:
            return recording.record_stops(options, robot, terminal)
        options = _at_newest(options, terminal)
        metadata = options.metadata(robot)
        may_ask = metadata.sockets > 1 and not options.scripted
        asked = may_ask and metadata.distance is None
        if asked:
            metadata = recording.with_distance(metadata, terminal)
        if may_ask and not (options.out / recorder.SAMPLES).exists():
            beside = recording.recorded_beside(options.out, robot)
            metadata = recording.with_distance_of_base(metadata, beside, terminal)
        calibrated = _calibration_of(options, robot.joint_names)
        begin = recording.SessionStart(options, metadata, robot, terminal)
        outcome, start = _recorded(begin)
        options = start.options
    try:
        if asked and outcome.signal is None:
            metadata = recording.with_second_reading(
                start.metadata, options.out, terminal
            )
            start = replace(start, metadata=metadata)
        _say_outcome(outcome, start)
        sys.stdout.flush()
    except OSError:  # the terminal is gone: write to nowhere from now on
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere, stream.fileno())
    if outcome.signal is not None:
        return 128 + outcome.signal
    if outcome.refused and options.scripted:
        return 1
    if not options.quick and calibrated is None:
        return 0
    if len(outcome.session.live) < LEAST_POSES:
        terminal.say(f"Too few poses to tell: record {LEAST_POSES} at least.")
        return NOT_ENOUGH
    if calibrated is None:
        words, status = recording.worth_calibrating(robot, options.out)
        terminal.say(words)
        return status
    placement = recorder.read_placement(options.out)
    settings = calibration.SolveOptions()
    changes, done = recording.judged(
        calibrated, [placement], settings, ball_moved=options.quick
    )
    terminal.warn(*map(str, done))
    terminal.say(changes.text, *changes.not_shown)
    return changes.verdict.exit_status


def _at_newest(options: RecordOptions, terminal: Terminal) -> RecordOptions:
    """Return options for the newest folder of a base: ``front-2`` after ``front``."""
    newest = recorder.newest_folder(options.out)
    if newest != options.out:
        name = options.out.name
        terminal.say(f"{name} was followed by {newest.name}, which goes on")
    return replace(options, out=newest)


def _calibration_of(
    options: RecordOptions, joint_names: Sequence[str]
) -> "calibration.Calibration | None":
    """Return the calibration that samples are held against; refuse that of another robot."""
    if not options.calibration:
        return None
    calibrated = calibration.load_calibration(one_arm(options.calibration))
    if calibrated.robot.joint_names != joint_names:
        names = ", ".join(calibrated.robot.joint_names)
        raise UsageError(
            f"--calibration {options.calibration}: of another robot, whose joints are {names}"
        )
    return calibrated


def _recorded(
    start: "recording.SessionStart",
) -> "tuple[recorder_terminal.Outcome, recording.SessionStart]":
    """Record one placement after the other; return the last, and how it began."""
    parts: list[recorder.Placement] = []
    robot = start.robot
    driver, distance = start.options.driver, start.metadata.distance
    hand = simulation.following_hand(driver, robot, distance)
    with recording.page_of(start.options) as page:
        start = replace(start, page=page, hand=hand)
        while True:
            options = start.options
            outcome = recording.record_session(start)
            session = outcome.session
            metadata = replace(
                start.metadata, distance=session.distance, measured=session.measured
            )
            start = replace(start, metadata=metadata)
            live = session.live
            distance = session.distance or recorder.DEFAULT_DISTANCE
            placement = recorder.Placement(
                options.out.name, live, robot.joint_names, distance
            )
            if options.scripted and not (options.no_guide or options.quick):
                for alarm in recording.SessionAlarms(robot)([*parts, placement]):
                    start.terminal.say(f"! {alarm.words}: {alarm.text}")
            if outcome.successor is None:
                return outcome, start
            if outcome.signal is not None:
                outcome.successor.close()
                return outcome, start
            parts += [placement] if live else []
            successor = outcome.successor
            if successor.metadata.readings_changed:
                lost = sum(len(part.samples) for part in parts)
                start, parts = replace(start, lost=start.lost + lost), []
            start = replace(
                start,
                options=replace(options, out=successor.folder),
                metadata=successor.metadata,
                recording=successor,
            )


@contextmanager
def _interruptible() -> Generator[None]:
    """Let Ctrl-C end the program at once while it loads and connects, with nothing open to lose."""

    def end(number: int, frame: FrameType | None) -> None:
        os.write(sys.stderr.fileno(), b"\nmukca record: interrupted\n")
        os._exit(130)

    before = signal.signal(signal.SIGINT, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _say_outcome(
    outcome: "recorder_terminal.Outcome", start: "recording.SessionStart"
) -> None:
    options = start.options
    metadata = start.metadata
    terminal = start.terminal
    session = outcome.session
    counts = ", ".join(f"{n} in socket {k}" for k, n in enumerate(session.counts))
    taken_back = f" ({len(session.withdrawn)} taken back)" if session.withdrawn else ""
    terminal.say(f"{options.out / 'samples.csv'}: {counts}{taken_back}")
    if metadata.distance is None and metadata.sockets > 1:
        terminal.say(
            "Nobody has said how far apart the sockets are; none is written, solve takes 50 mm "
            "and gives no PASS. Measure it: "
            f"mukca info {shlex.quote(str(options.out))} --set-distance METRES"
        )
    if outcome.refused:
        terminal.say(f"Refused: {plural(outcome.refused, 'capture')}")
    if terminal.brief or options.quick or options.calibration:
        return
    if outcome.signal is None and min(session.counts) > 0:
        terminal.say(*_next_steps(outcome, start))


def _next_steps(
    outcome: "recorder_terminal.Outcome", start: "recording.SessionStart"
) -> list[str]:
    """Return the commands to go on with, as they can be typed in the same folder."""
    options = start.options
    metadata = start.metadata
    earlier_placements = recording.recorded_beside(options.out, start.robot)
    folders = [str(placement.files[0].parent) for placement in earlier_placements]
    elsewhere = recording.driver_elsewhere(options.driver)
    settings = replace(
        options,
        distance=metadata.distance if metadata.measured else None,
        driver=elsewhere or options.driver,
    )

    def given(*names: str) -> list[str]:
        return figures.as_options({name: getattr(settings, name) for name in names})

    robot = given("robot", "base", "flange", "tip", "ball")
    out = str(options.out)
    calibrated = f"{options.out}-calibrated"
    words_again = given("driver", "distance", "robot_name", "auto", "page")
    words_again += list(chain.from_iterable(("--key", keys) for keys in options.key))
    words_again += ["--out", str(recorder.next_folder(options.out))]
    advised = outcome.advice.closing if outcome.advice else ()
    zeros = ["--zeros"] if recording.SessionAlarms(start.robot).coarse else []
    record_again = ["mukca", "record", *robot, *words_again]
    solve = ["mukca", "solve", *folders, out, *robot, *zeros, "--out", calibrated]
    lines = [
        *advised,
        f"Next: {shlex.join(['mukca', 'check', *folders, out, *robot, *zeros])}",
        f"then: {shlex.join(solve)}",
    ]
    if elsewhere:
        again = shlex.join(record_again)
        lines.append(f"or, better, the base elsewhere first: {again}")
    return lines

"""Setup of a recording session: all that it needs, in the order in which it can fail."""

import gc
import logging
import math
import sys
from collections.abc import Generator, Sequence
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from typing import Any

from ...recorder import Sample, StreamLog, next_log_file
from ...recorder.stream import STILL, ContactDetector, Stream, StreamMonitor
from ...recorder.terminal import Lines, Outcome, Recorder, Screen, keys_with
from ...solver.robot import Robot
from ..cli import Terminal, one_arm
from . import session_start
from .checks import gravity_of, odd_pose
from .guidance_process import BackgroundGuidance
from .options import SettledOptions

LOCAL_HOSTS = ("127.0.0.1", "localhost", "::1")


def record_session(
    options: SettledOptions,
    robot: Robot,
    terminal: Terminal,
    moved: Sequence[Sample] | None = None,
) -> Outcome:
    """Record at one placement until the operator finishes.

    Args:
        options: Of the session.
        robot: Its nominal model.
        terminal: Where the session is shown.
        moved: At a further placement of the same run, the samples since the base moved there.
    """
    keys = keys_with(options.key)
    with ExitStack() as stack:
        keyboard, script = session_start.keys_of(options, stack)
        stack.enter_context(_undisturbed())
        if sys.stdout.isatty():
            terminal.say(f"connecting to {options.driver} ...")
            sys.stdout.flush()
        driver = stack.enter_context(session_start.connect(options.driver, robot))
        still = max(STILL, driver.resolution) if options.still is None else options.still
        stream = stack.enter_context(closing(Stream(driver)))
        recording = stack.enter_context(session_start.open_recording(options, robot, still))
        if options.keep_stream:
            stream.log = log = StreamLog(next_log_file(options.out), robot.joint_names)
            stack.callback(lambda: terminal.warn(*([log.trouble] if log.trouble else [])))
            stack.callback(log.close)
        live = script is None
        session = session_start.first_session(options, robot, recording, moved or ())
        page = None
        if options.page:
            from .page import PageProcess

            page = stack.enter_context(closing(PageProcess(options, options.page_host)))
            session = session.with_message(f"page: {page.url}")
            if options.page_host not in LOCAL_HOSTS:
                warning = "whoever knows this address can watch, from anywhere in the network"
                session = session.with_message(warning, alarm=True)
        guided = keyboard is not None and live and not options.no_guide
        guidance = stack.enter_context(closing(_guidance(options, robot))) if guided else None
        return Recorder(
            session=session,
            stream=stream,
            monitor=StreamMonitor(
                session.joints,
                window=options.window,
                still=still,
                live=live,
                resolution=driver.resolution,
            ),
            recording=recording,
            display=_display(terminal),
            title=_title(options, robot),
            keyboard=keyboard,
            script=script,
            contact=ContactDetector(
                session.joints, gravity_of(robot, options.load.validated().load)
            ),
            plausible=partial(odd_pose, robot, options.distance),
            keys=keys,
            hands_free=options.auto,
            moved=moved is not None and not moved,
            sound=options.sound != "off",
            guidance=guidance,
            observer=page,
            resume_summary=session_start.resume_summary_of(recording, session, options)
            if keyboard and live
            else (),
        ).run()


def _guidance(options: SettledOptions, robot: Robot) -> BackgroundGuidance:
    turn = math.inf if options.turn is None else math.radians(options.turn)
    settings: dict[str, Any] = {"distance": options.distance, "sockets": options.sockets}
    if options.calibration is not None:
        settings |= {"calibration": one_arm(options.calibration), "target": options.target}
    else:
        goal = None if options.goal_mm is None else 1e-3 * options.goal_mm
        settings |= {"goal": goal, "earlier": session_start.recorded_beside(options.out, robot)}
    return BackgroundGuidance(options, **settings, turn=turn)


def _title(options: SettledOptions, robot: Robot) -> str:
    out = str(options.out)
    folder = out if len(out) <= 36 else f"…{out[-35:]}"
    apart = f"sockets {1e3 * options.distance:g} mm" if options.stated else "sockets unmeasured"
    return f"{robot.name}  {folder}  {apart}  {options.driver}"


@contextmanager
def _undisturbed() -> Generator[None, None, None]:
    """Keep the library's log off the screen, and garbage collection off all that is loaded."""
    log = logging.getLogger("mukca")
    before, frozen = (log.handlers, log.propagate), gc.get_freeze_count() > 0
    log.handlers, log.propagate = [*log.handlers, logging.NullHandler()], False
    gc.collect()  # it stops reading for 0.1 s
    gc.freeze()
    try:
        yield
    finally:
        log.handlers, log.propagate = before
        if not frozen:
            gc.unfreeze()


def _display(terminal: Terminal) -> Screen | Lines:
    console = terminal.console
    whole = console.is_terminal and not console.is_dumb_terminal
    if whole and console.file.isatty():
        return Screen(console)
    return Lines(console, brief=terminal.brief)
